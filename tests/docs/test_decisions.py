"""The short table of recommendations."""

import pytest
import xarray as xr

from docs.decisions import short_cell


def _decision(**values) -> xr.Dataset:
    usual = {
        "scheme_title": "Bathe",
        "verdict": 0,
        "smaller_steps": 3.0,
        "step_size": 0.0025,
        "steps_per_period": 10.0,
        "omega_step": 0.1,
        "problem": "softening",
    }
    return xr.Dataset(usual | values)


@pytest.mark.parametrize(
    "omega_step, printed", [(1.7e6, "1.7 × 10⁶"), (5e-5, "5 × 10⁻⁵"), (1700.0, "1700"), (0.0537, "0.054")]
)
def test_a_cell_states_the_product_of_frequency_and_step(omega_step, printed):
    cell = short_cell(_decision(omega_step=omega_step, verdict=1)).replace("\u00a0", " ")
    assert cell == f"Bathe: ≤ 10 steps, ωΔt = {printed}"


def test_a_step_in_seconds_is_not_a_number_of_steps():
    assert short_cell(_decision(problem="records")).startswith("Bathe: 2.5\u00a0ms, ωΔt")
    assert short_cell(_decision(step_size=float("nan"))) == "–"
