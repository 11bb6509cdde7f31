"""Observed trajectories and quantities that a user defines."""

from functools import partial

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.problem import chains


def test_a_quantity_of_the_user_is_recorded():
    first = study.Quantity(partial(chains.oscillatory_energy, 0), "i_1", "energy of the first spring", "J")
    ds = study.run(chains.fpu_chain(), "rk4", dt=0.002, steps=10, observe=["trajectory", first])
    assert ds.i_1.dims == ("t",) and ds.i_1.attrs == {"long_name": "energy of the first spring", "units": "J"}
    assert ds.i_1[0] == pytest.approx(1.0)
    np.testing.assert_allclose(ds.i_1, (ds.v[:, 3] ** 2 + 2500 * ds.u[:, 3] ** 2) / 2, rtol=1e-12)


@pytest.fixture
def pair():
    """Two linear oscillators under a load."""
    return study.Problem(
        lambda u: jnp.array([1.0, 4.0]) * u, u0=[1.0, -2.0], damping=0.1, load=lambda t: jnp.cos(t) * jnp.ones(2)
    )


@pytest.mark.slow
def test_a_quantity_has_time_and_acceleration(pair):
    force = study.Quantity(lambda t, v, a: jnp.cos(t) - a - 0.1 * v, "internal", units="N")
    ds = study.run(pair, "average_acceleration", dt=0.05, steps=40, observe=["trajectory", force], every=4)
    np.testing.assert_allclose(ds.internal, ds.u * [1.0, 4.0], atol=1e-13)
    assert ds.internal.dims == ("t", "component")


@pytest.mark.parametrize("lanes", [0, 3, 70])
def test_quantities_are_reduced(pair, lanes):
    u0 = np.array([1.0, -2.0]) if not lanes else np.linspace(0.5, 1.0, lanes)[:, None] * [1.0, -2.0]
    reduced = [study.Quantity(lambda u: u[:1] - u[1:], f"{kind}_gap", reduce=kind) for kind in ("peak", "final", "rms")]
    ds = study.run(pair, "rk4", dt=0.05, steps=40, u0=u0, observe=["trajectory", *reduced])
    gap = ds.u[..., 0] - ds.u[..., 1]
    np.testing.assert_allclose(ds.peak_gap[..., 0], abs(gap).max("t"), rtol=1e-12)
    np.testing.assert_allclose(ds.final_gap[..., 0], gap[..., -1], rtol=1e-12)
    np.testing.assert_allclose(ds.rms_gap[..., 0], np.sqrt((gap**2).integrate("t") / 2), rtol=1e-12)
    assert ds.peak_gap.dims[-1] == "peak_gap_component"


def test_the_peak_of_a_quantity_is_a_size_from_the_start_on():
    peak = study.Quantity(lambda u: u, "highest", reduce="peak")
    damped = study.Problem(lambda u: u, u0=-1.0, damping=1.0)
    assert study.run(damped, "rk4", dt=0.1, steps=60, observe=peak).highest == 1


def test_unfit_quantities_are_refused():
    with pytest.raises(ValueError, match="takes some of t, u, v, a, ground .* not x, y"):
        study.Quantity(lambda x, y: x)
    with pytest.raises(ValueError, match="reduce must be one of None, 'peak', 'final', 'rms', not 'mean'"):
        study.Quantity(lambda u: u, reduce="mean")
    with pytest.raises(TypeError, match="a quantity needs a function, not 'u'"):
        study.Quantity("u")


@pytest.mark.slow
def test_floors_are_accelerated_with_the_ground():
    """Without a spring the mass has no absolute acceleration; on a stiff spring it follows the ground."""
    ground = study.GroundMotion([0.0, 1.0, -1.0, 0.5, 0.0], 0.5)
    observe = ["trajectory", "absolute_acceleration"]
    loose = study.Problem(lambda u: 0 * u, u0=0.0, ground=ground)
    ds = study.run(loose, "rk4", dt=0.01, steps=150, observe=observe)
    np.testing.assert_allclose(ds.absolute_acceleration, 0, atol=1e-14)
    stiff = study.Problem(lambda u: 1e6 * u, u0=[0.0, 0.0], damping=2e3, ground=ground, influence=[1.0, 0.5])
    ds = study.run(stiff, "bathe", dt=0.01, steps=150, observe=observe)
    expected = np.interp(ds.t, ground.kinks, ground.acceleration)[:, None] * [1.0, 0.5]
    np.testing.assert_allclose(ds.absolute_acceleration[5:], expected[5:], atol=0.02)
    with pytest.raises(ValueError, match="absolute_acceleration of 'still' needs Problem.ground=...."):
        study.run(study.Problem(lambda u: u, u0=1.0, title="still"), "rk4", dt=0.1, steps=1, observe=observe)
