"""Relaxed schemes: they keep the energy, and the order of the method."""

import jax
import numpy as np
import pytest

import study

RELAXED = study.Relaxed(scheme=study.schemes["rk4"])
PERIOD = 0.151532834447260357127078726219


@pytest.mark.slow
@pytest.mark.parametrize("problem, dt", [("hardening", 0.0075), ("softening", 0.057), ("double_well", 2.5)])
def test_the_energy_of_the_paper_s_runge_kutta_runs_is_kept(problem, dt):
    """The Runge-Kutta method itself loses energy on the first two springs, and blows up in the double well."""
    ds = study.run(problem, RELAXED, dt=dt, steps=20_000, every=20_000, observe=["max_energy_error"])
    assert ds.status == 0 and ds.max_energy_error < 1e-10


def _order(scheme):
    """Observed order of the displacement of the hardening spring after a quarter of its period, where it is zero."""
    steps = [50, 100, 200]
    ends = [study.run("hardening", scheme, dt=PERIOD / 4 / n, steps=n, every=n).u.values[-1] for n in steps]
    return -np.diff(np.log(np.abs(ends))) / np.diff(np.log(steps))


class _WithoutLead(study.Relaxed):
    """A relaxed scheme that takes y₀ + γ Δy as the motion at the end of the step, and not at t + γ Δt."""

    def step(self, problem, state, t, dt):
        new, effort = super().step(problem, state, t, dt)
        return type(new)(new.inner, 0 * new.lead), effort


def test_a_step_that_makes_up_for_the_last_one_keeps_the_order():
    """Without compensation of the last step's shift in time the order is three (Ketcheson, 2019, section 2)."""
    assert _order(RELAXED) == pytest.approx(4, abs=0.1)
    assert _order(_WithoutLead(scheme=RELAXED.scheme)) == pytest.approx(3, abs=0.1)


@pytest.mark.slow
def test_relaxed_runs_of_several_unknowns_with_accelerations_and_lanes():
    for name in ("rk4", "central_difference", "generalized_alpha"):
        ds = study.run(
            "fpu_chain", study.Relaxed(scheme=study.schemes[name]), dt=np.array([5e-3, 1e-2]), steps=300,
            every=300, observe=["max_energy_error"],
        )  # fmt: skip
        assert (ds.status == 0).all() and (ds.max_energy_error < 1e-11).all(), name


@pytest.mark.slow
def test_relaxed_runs_have_derivatives():
    """A relaxation whose root is constant in a derivative."""

    def last(u0):
        return study.final_state("softening", RELAXED, dt=0.05, steps=30, u0=u0)["u"]

    difference = float(last(3.001) - last(2.999)) / 2e-3
    assert jax.grad(last)(3.0).item() == pytest.approx(difference, rel=1e-5)
    assert jax.jvp(last, (3.0,), (1.0,))[1].item() == pytest.approx(difference, rel=1e-5)


def test_a_spring_in_balance_stays():
    ds = study.run(study.Problem(lambda u: u, 0.0, potential=lambda u: u * u / 2), RELAXED, dt=0.1, steps=3)
    assert ds.status == 0 and (ds.u == 0).all()


def test_what_cannot_be_relaxed_is_refused():
    spring = {"force": lambda u: u, "u0": 1.0}
    for problem in (study.Problem(**spring), study.Problem(**spring, potential=lambda u: u * u / 2, damping=0.1)):
        with pytest.raises(ValueError, match="'Relaxed' needs a problem with a potential and without"):
            study.run(problem, RELAXED, dt=0.1, steps=1)
    with pytest.raises(TypeError, match="Relaxed takes a study.OneStep"):
        study.Relaxed(scheme=study.schemes["houbolt"])
