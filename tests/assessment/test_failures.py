"""Maps of how a scheme fails on a problem."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.assessment.failures import map_of

#: Circular frequency of the elastic frame, in 1/s.
OMEGA = 53.0


@pytest.fixture(scope="module")
def mapped():
    """The map of central difference on a frame that yields, whose force bounds every run."""
    frame = study.Problem(
        study.materials.elastoplastic(stiffness=OMEGA**2, yield_force=30.0, hardening=0.02),
        0.0,
        load=lambda t: 40.0 * jnp.sin(5.0 * t),
        title="yielding frame",
    )
    return map_of(frame, study.schemes["central_difference"], 2.0, 0.2, np.array([]))


@pytest.mark.slow
def test_no_step_beyond_the_stability_limit_counts_as_safe(mapped):
    limit = 2 / OMEGA
    beyond = mapped.map_step_size.values > limit
    assert beyond.sum() > 10 and (~beyond).sum() > 5
    outcome = mapped.outcome.sel(excitation=1.0).values
    # every run completes, since the force is bounded, although its result may be wrong by any factor
    assert (outcome[beyond] == study.Outcome.BEYOND_THE_LIMIT).all()
    assert (outcome[~beyond] != study.Outcome.BEYOND_THE_LIMIT).all()
    assert mapped.largest_safe_step_size.item() <= limit
    assert mapped.stable_step_size.values == pytest.approx(limit, rel=1e-4)
    assert "at the start exceeds 2, the stability limit of 'Central difference'" in mapped.failure.item()
