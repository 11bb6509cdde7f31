"""The rest position of a problem, and the times at which a run crosses the potential barrier or has grown."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.observer.outcome import OutcomeObserver


@pytest.mark.parametrize(
    "problem, sentence",
    [
        (study.Problem(lambda u: u, 1.0, title="own"), "needs Problem(potential=...)"),
        (study.Problem(lambda u: u, [1.0, 2.0], potential=lambda u: (u * u).sum() / 2, title="own"), "more than one"),
        (study.Problem(lambda u: -u, 1.0, potential=lambda u: -u * u / 2, title="own"), "has no minimum downhill"),
        (
            study.Problem(lambda u: -2 * u / (1 + u * u) ** 2, 1.0, potential=lambda u: 1 / (1 + u * u), title="hill"),
            "has no minimum downhill",
        ),
        (study.Problem(potential=lambda u: jnp.exp(-u * u), u0=1.0, title="underflow"), "has no minimum downhill"),
        (study.Problem(lambda u: 1.0 + 0 * u, 1.0, potential=lambda u: u, title="own"), "has no minimum downhill"),
        ("duffing_chaotic", "damping or a load change its energy"),
    ],
)
def test_no_outcome_without_a_rest(problem, sentence):
    with pytest.raises(ValueError) as caught:
        OutcomeObserver.of(problem)
    assert sentence in str(caught.value)


def test_no_outcome_of_a_structure():
    with pytest.raises(ValueError, match="has more than one unknown"):
        study.run("fpu_chain", "rk4", dt=0.01, steps=10, observe=[OutcomeObserver(rest=0.0)])


def test_the_rest_lies_before_a_singularity():
    repelled = study.Problem(potential=lambda u: u * u / 2 + 1 / u, u0=5.0)
    assert OutcomeObserver.of(repelled).rest_at == pytest.approx(1.0, abs=1e-12)


def test_the_rest_lies_downhill_and_a_hill_is_seen():
    well, spring = OutcomeObserver.of("double_well"), OutcomeObserver.of("softening")
    assert well.rest == pytest.approx(-0.125, abs=1e-9) and well.barrier == 0.0
    assert spring.rest == pytest.approx(0.0, abs=1e-9) and spring.barrier is None


def test_a_run_from_above_the_hill_is_in_no_wrong_well():
    ds = study.run(
        "double_well", "rk4", dt=0.02, steps=2000, u0=[0.5, 2.0], observe=[OutcomeObserver.of("double_well")]
    )
    assert np.isinf(ds.crossed_at).all()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.* has negative numerical damping:RuntimeWarning")
def test_a_run_has_grown_once_it_keeps_a_hundred_times_the_energy():
    """Newmark's method with γ < ½ multiplies the energy of a linear spring by nearly the same factor in each step."""
    spring = study.Problem(lambda u: u, 1.0, potential=lambda u: u * u / 2, title="linear")
    scheme, dt = study.Newmark(beta=0.25, gamma=0.25), 0.2
    theory = study.LinearTheory(scheme, np.array([dt / (2 * np.pi)])).spectral_radius.item()
    ds = study.run(spring, scheme, dt=dt, steps=1000, observe=[OutcomeObserver.of(spring)])
    assert ds.grown_from == pytest.approx(dt * np.log(100) / np.log(theory) / 2, rel=0.02)
