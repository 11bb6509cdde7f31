"""The largest displacement, also between the steps."""

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.interpolate

import study


@pytest.mark.parametrize("dt", [0.3, 0.9])
def test_the_peak_is_that_of_the_cubic_through_the_steps(dt):
    stiffness, load = jnp.array([1.0, 4.0]), lambda t: jnp.cos(t) * jnp.ones(2)
    pair = study.Problem(lambda u: stiffness * u, u0=[0.0, -0.1], v0=[1.0, 1.0], load=load)
    ds = study.run(pair, "average_acceleration", dt=dt, steps=20, observe=["trajectory", "peak"])
    t = np.linspace(0, 20 * dt, 200_001)
    cubic = scipy.interpolate.CubicHermiteSpline(ds.t.values, ds.u.values, ds.v.values)(t)
    np.testing.assert_allclose(ds.peak, np.abs(cubic).max(axis=0), rtol=1e-8)
    assert (ds.peak > np.abs(ds.u).max("t")).all()


def test_the_peak_of_a_mass_at_rest_is_where_it_rests():
    ds = study.run(study.Problem(lambda u: 0.0 * u, u0=-2.0), "rk4", dt=0.1, steps=5, observe=["peak"])
    assert ds.peak == 2.0


@pytest.mark.slow
def test_the_error_of_the_peak_is_of_fourth_order():
    spring = study.Problem(lambda u: u, u0=0.0, v0=1.0)
    error = [1 - float(study.run(spring, "rk4", dt=dt, steps=int(3 / dt), observe=["peak"]).peak) for dt in (0.2, 0.1)]
    assert 0 < error[1] < error[0] / 12 and error[0] < 0.2**4 / 384 * 4
