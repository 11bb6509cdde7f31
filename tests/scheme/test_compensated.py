"""Schemes with compensated sums."""

import jax
import numpy as np
import pytest

import study


@pytest.mark.slow
def test_compensated_sums_lower_the_floor_and_nothing_else():
    period, steps = 0.151532834447260357127078726219, 200_000
    ends = {
        name: abs(study.run("hardening", scheme, dt=period / 4 / steps, steps=steps, every=steps).u.values[-1])
        for name, scheme in {"plain": "rk4", "compensated": study.Compensated(scheme=study.schemes["rk4"])}.items()
    }
    assert ends["compensated"] < 2e-15 < ends["plain"]
    plain, compensated = (
        study.run("softening", scheme, dt=0.05, steps=100).u.values
        for scheme in ("average_acceleration", study.Compensated(scheme=study.schemes["average_acceleration"]))
    )
    np.testing.assert_allclose(plain, compensated, atol=1e-12)


@pytest.mark.slow
def test_compensated_sums_lower_the_round_off():
    """With step sizes whose square is exact in single precision, compensation at least halves the energy round-off."""
    dt = np.ldexp(np.arange(4000, 4064), -20)
    errors = {}
    for name, double, scheme in (
        ("exact", True, study.Compensated(scheme=study.schemes["central_difference"])),
        ("plain", False, study.schemes["central_difference"]),
        ("compensated", False, study.Compensated(scheme=study.schemes["central_difference"])),
    ):
        with jax.enable_x64(double):
            ds = study.run("hardening", scheme, dt=dt, steps=10_000, observe=["mean_energy_error"])
        errors[name] = ds.mean_energy_error.values.astype(float)
    plain, compensated = (np.std(errors[name] - errors["exact"]) for name in ("plain", "compensated"))
    assert 0 < compensated < plain / 2


@pytest.mark.parametrize("scheme", ["rk4", None, study.schemes["houbolt"]])
def test_only_steps_that_add_can_be_compensated(scheme):
    with pytest.raises(TypeError, match="Compensated takes a study.OneStep, whose step adds to u and u̇"):
        study.Compensated(scheme=scheme)
