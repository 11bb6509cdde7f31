"""Motions with two unknowns and an energy."""

import numpy as np
import pytest

import study
from study.problem import orbits
from study.problem.named import known


@pytest.mark.slow
def test_arenstorf_s_orbit_closes_after_the_printed_period():
    problem = study.problems["arenstorf"]
    ds = study.run(problem, "dormand_prince6", dt=orbits.PERIOD / 2**19, steps=2**19, every=2**19)
    np.testing.assert_allclose(ds.u[-1], problem.u0, rtol=0, atol=1e-10)
    np.testing.assert_allclose(ds.v[-1], problem.v0, rtol=0, atol=1e-7)
    # Coriolis' force does no work, so that Jacobi's constant is conserved
    start, end = problem.energy(problem.u0, problem.v0), problem.energy(ds.u[-1].values, ds.v[-1].values)
    assert float(end) == pytest.approx(float(start), rel=1e-7)


def test_the_straight_motion_of_henon_and_heiles_turns_where_its_integral_says():
    target = known["henon_heiles"]
    problem = study.problems["henon_heiles"]
    assert float(problem.energy(problem.u0, problem.v0)) == pytest.approx(1 / 12, rel=1e-14)
    ds = study.run(problem, "dormand_prince6", dt=target.time / 4096, steps=4096, every=4096)
    np.testing.assert_allclose(ds.u[-1], target.u, rtol=0, atol=1e-12)
    np.testing.assert_allclose(ds.v[-1], 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(orbits.STRAIGHT_PERIOD, 6.9016, rtol=0, atol=5e-5)


def test_below_a_sixth_a_star_stays_in_the_triangle():
    """A star of the chaotic sea stays in the triangle with the energy 1/8, and escapes with 1/4."""
    problem = study.problems["henon_heiles"]

    def run(energy, steps):
        speed = np.sqrt(2 * (energy - float(problem.potential(np.array([0.0, -0.15])))))
        return study.run(
            problem, "yoshida4", dt=0.05, steps=steps, every=20, u0=[0.0, -0.15], v0=[speed, 0.0], on_failure="ignore"
        )

    inside = run(1 / 8, 100_000)
    assert (inside.u[:, 1] > -0.5).all() and (inside.u[:, 1] + np.sqrt(3) * abs(inside.u[:, 0]) < 1).all()
    states = zip(inside.u.values[::500], inside.v.values[::500], strict=True)
    energies = [float(problem.energy(u, v)) for u, v in states]
    np.testing.assert_allclose(energies, 1 / 8, rtol=1e-5)
    assert not (np.abs(run(1 / 4, 20_000).u) < 1).all()
