"""Estimators compared with closed forms and with local errors, the errors of one step from the numerical state."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.control.named import estimators
from study.scheme.named import schemes

OSCILLATOR = study.Problem(lambda u: u, u0=1.0)
DT = 0.05


def march(scheme, estimator, dt=DT, problem=OSCILLATOR):
    """A run of two periods with equal steps and the estimate of each step; the largest displacement is one."""
    steps = round(4 * np.pi / dt)
    return study.run(
        problem, scheme, controller=study.Prescribed([dt]), duration=steps * dt, tolerance=1.0, estimator=estimator
    )


def local_errors(ds):
    """Errors of displacement and velocity in each step, against the exact motion from the state at its start."""
    u, v = ds.u.values, ds.v.values
    h = ds.step_size.values[1:]
    exact = u[:-1] * np.cos(h) + v[:-1] * np.sin(h), v[:-1] * np.cos(h) - u[:-1] * np.sin(h)
    return np.abs(u[1:] - exact[0]), np.abs(v[1:] - exact[1])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "newmark_dissipative", "central_difference"])
def test_zienkiewicz_and_xie_for_newmark(name):
    ds, beta = march(name, "zienkiewicz_xie"), schemes[name].beta  # type: ignore[attr-defined]
    acceleration = -ds.u.values
    np.testing.assert_allclose(ds.estimate[1:], abs((beta - 1 / 6) * DT**2 * np.diff(acceleration)), atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "hht_alpha", "wbz_alpha", "generalized_alpha", "bathe"])
def test_zienkiewicz_and_xie_where_the_motion_is_fast(name):
    """The estimate equals the local error of the displacement where u''' is large, and is small at turning points."""
    ds = march(name, "zienkiewicz_xie")
    fast = abs(ds.u.values[1:]) < 0.3
    ratio = ds.estimate.values[1:] / local_errors(ds)[0]
    np.testing.assert_allclose(ratio[fast], 1, atol=0.05)
    turning = np.argmin(abs(ds.v.values[5:])) + 5
    assert ds.estimate[turning] < 0.1 * ds.estimate.max()


def test_three_points_see_the_velocity():
    ds = march("average_acceleration", "three_point")
    u, v = local_errors(ds)
    largest = np.maximum(u, v)
    ratio = ds.estimate.values[2:] / largest[1:]
    assert 0.9 < np.median(ratio) < 1.1 and np.all((ratio > 0.6) & (ratio < 1.4))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "rk4", "hht_alpha"])
def test_step_doubling_is_the_error_of_the_finer_steps(name):
    ds = march(name, "step_doubling")
    u, v = local_errors(ds)
    np.testing.assert_allclose(ds.estimate[3:], np.maximum(u, v)[2:], rtol=0.12)


@pytest.mark.slow
def test_an_embedded_pair_estimates_the_error_of_its_lower_order():
    """The estimate falls with the fifth power of the step size; the error at the end falls with the tolerance."""
    coarse, fine = (march("dormand_prince6", "embedded_pair", dt).estimate.max() for dt in (0.4, 0.2))
    assert np.log2(coarse / fine) == pytest.approx(5, abs=0.3)
    spring = study.Problem(lambda u: u + u**3, u0=1.0)
    ends = [
        study.run(spring, "dormand_prince6", tolerance=tolerance, duration=9.0) for tolerance in (1e-4, 1e-8, 1e-12)
    ]
    errors = [abs(ds.u[-1] - ends[-1].u[-1]).item() for ds in ends[:2]]
    assert ends[0].attrs["estimator"] == "Embedded pair" and errors[1] < 1e-7 < errors[0] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "hht_alpha", "wbz_alpha", "generalized_alpha"])
def test_the_half_step_residual_falls_with_the_square_of_the_step(name):
    """The ratio of the largest residual to Δt² is the same at both step sizes; with average acceleration it is 1/8."""
    first, second = (march(name, "half_step_residual", dt).estimate[5:].max().item() / dt**2 for dt in (0.02, 0.01))
    assert first == pytest.approx(second, rel=0.03)
    if name == "average_acceleration":
        assert first == pytest.approx(1 / 8, rel=0.01)


def test_the_apparent_frequency_is_that_of_a_linear_structure():
    ds = march("average_acceleration", "apparent_frequency")
    np.testing.assert_allclose(ds.estimate[1:], DT / (2 * np.pi), rtol=1e-9)


def test_the_iterations_are_those_that_an_observer_counts():
    problem = study.Problem(lambda u: u + 5 * u**3, u0=1.0)
    wanted = {"controller": study.Prescribed([0.1]), "duration": 3.0, "tolerance": 6.0, "estimator": "iterations"}
    ds = study.run(problem, "average_acceleration", observe=["trajectory", "newton_iterations"], **wanted)
    assert ds.estimate.sum() == ds.newton_iterations > 30


@pytest.mark.slow
def test_an_estimate_is_relative_to_the_motion():
    """Other units of displacement and time leave all steps of a linear structure the same.

    It alone sees an absolute number in an estimate.
    """
    stiffness = np.array([[3.0, -1.0], [-1.0, 2.0]])
    for name in estimators:
        if name in ("iterations", "embedded_pair"):
            continue
        runs = []
        for length, time in ((1.0, 1.0), (1000.0, 0.01)):
            problem = study.Problem(stiffness=stiffness / time**2, u0=[length, 0.5 * length])
            tolerance = 0.05 if name == "apparent_frequency" else 1e-3
            wanted = {"dt": 0.02 * time, "duration": 5 * time, "estimator": name, "tolerance": tolerance}
            runs.append(study.run(problem, "average_acceleration", **wanted))
        assert runs[0].steps == runs[1].steps
        np.testing.assert_allclose(runs[0].u[-1], runs[1].u[-1] / 1000, rtol=1e-6)


def test_an_estimator_refuses_what_it_cannot_estimate():
    with pytest.raises(ValueError, match="third order of a step, and those of 'Runge-Kutta' are of order 5"):
        study.run("hardening", "rk4", tolerance=1e-3, duration=1.0, estimator="zienkiewicz_xie")
    with pytest.raises(ValueError, match="linear acceleration, which 'Wilson-θ' assumes itself"):
        study.run("hardening", "wilson_theta", tolerance=1e-3, duration=1.0, estimator="zienkiewicz_xie")
    with pytest.raises(ValueError, match="takes no Newton iterations"):
        study.run("hardening", "rk4", tolerance=6, duration=1.0, estimator="iterations")
    with pytest.raises(ValueError, match="needs a scheme that carries the acceleration"):
        study.run("hardening", "rk4", tolerance=1e-3, duration=1.0, estimator="half_step_residual")


@pytest.mark.slow
def test_an_estimator_of_your_own():
    class Speed(study.Estimator):
        title, source, doi = "Speed", "", ""

        def exponent(self, scheme):
            return 1

        def estimate(self, scheme, problem, carried, old, new, t, dt, effort):
            return (jnp.abs(new.v) * dt,), carried

    ds = study.run(OSCILLATOR, "rk4", tolerance=0.1, duration=6.0, dt=0.01, estimator=Speed())
    assert (abs(ds.v[1:] * ds.step_size[1:]) < 0.1).all() and ds.attrs["estimator"] == "Speed"
