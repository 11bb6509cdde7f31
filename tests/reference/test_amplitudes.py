"""Exact periods and orbits over amplitudes."""

import jax
import numpy as np
import pytest

import study
from reference.experiments.amplitudes import amplitudes


@pytest.fixture(scope="module")
def springs():
    """Exact periods over two decades of amplitude."""
    return amplitudes(["hardening", "softening", "double_well"], {"first": -1.0, "last": 1.0, "count": 6})


def test_after_a_period_a_motion_is_back_at_its_start(springs):
    for name in springs.problem.values:
        spring, parts = springs.sel(problem=name), 20_000
        ends = study.run(name, "rk4", dt=spring.period.values / parts, u0=spring.u0.values, steps=parts, every=parts)
        late = ends.v[:, -1].values / np.asarray(jax.vmap(study.problems[name].force)(spring.u0.values))
        assert np.abs(late / spring.period.values).max() < 1e-11
        np.testing.assert_allclose(ends.u[:, -1], spring.u0.values, rtol=1e-10)


def test_the_highest_frequency_is_that_of_the_tangent_on_the_way(springs):
    selected = springs.isel(amplitude=2)
    hard, soft, well = (selected.sel(problem=name) for name in springs.problem.values)
    assert hard.highest_frequency.item() == pytest.approx(np.sqrt(100 * (1 + 30 * hard.u0.item() ** 2)))
    assert soft.highest_frequency.item() == pytest.approx(10.0)
    # in the double well, the motion from u₀ < 1 has its far turning point at u² = 2 − u₀²
    assert well.highest_frequency.item() == pytest.approx(np.sqrt(-0.5 + 1.5 * (2 - well.u0.item() ** 2)))
