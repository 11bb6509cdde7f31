"""Parameters that programs and books list in different orders are given by name."""

import inspect

import pytest

import study
from study.scheme.base import Scheme

#: Public classes of schemes.
SCHEMES = [kind for kind in map(study.__getattr__, dir(study)) if inspect.isclass(kind) and issubclass(kind, Scheme)]


@pytest.mark.parametrize(
    "make, sentence",
    [
        (lambda: study.Newmark(0.5, 0.25), "Newmark takes keywords only: Newmark(beta=…, gamma=…)."),  # type: ignore[call-arg]
        (lambda: study.RungeKutta4("rk4"), "RungeKutta4 takes keywords only: RungeKutta4(title=…)."),
        (lambda: study.Compensated("rk4"), "Compensated takes keywords only: Compensated(scheme=…)."),  # type: ignore[call-arg]
        (
            lambda: study.GeneralizedAlpha.hht(0.9),
            "GeneralizedAlpha.hht takes keywords only: GeneralizedAlpha.hht(rho_inf=…).",
        ),
        (
            lambda: study.materials.elastoplastic(1e3, 4e5),
            "elastoplastic takes keywords only: elastoplastic(stiffness=…, yield_force=…, hardening=…).",
        ),
        (lambda: study.Rayleigh(0.1, 0.02), "Rayleigh takes keywords only: Rayleigh(a=…, b=…)."),  # type: ignore[call-arg]
        (
            lambda: study.materials.Gap(1e3, 0.1),  # type: ignore[call-arg]
            "Gap takes keywords only: Gap(stiffness=…, opening=…).",
        ),
        (lambda: study.DeadBand(1.0, 0.1), "DeadBand takes keywords only: DeadBand(low=…, high=…, patience=…)."),
    ],
)
def test_the_message_lists_the_keywords(make, sentence):
    with pytest.raises(TypeError) as error:
        make()
    assert str(error.value) == sentence


@pytest.mark.parametrize("kind", SCHEMES)
def test_no_scheme_has_a_parameter_without_a_name(kind):
    assert {entry.kind for entry in inspect.signature(kind).parameters.values()} <= {inspect.Parameter.KEYWORD_ONLY}


def test_a_derived_scheme_takes_keywords_too_and_may_add_a_parameter_without_a_default():
    class Shifted(study.Newmark):
        shift: float

    assert Shifted(beta=0.25, gamma=0.5, shift=1.0).shift == 1.0
    with pytest.raises(TypeError, match=r"Shifted takes keywords only: Shifted\(beta=…, gamma=…, shift=…\)\.$"):
        Shifted(0.25, 0.5, 1.0)  # type: ignore[call-arg]
