"""The short table of recommendations."""

import pytest

from docs.decisions import _short_cell
from paper.picks import Pick


@pytest.mark.parametrize(
    "omega_step, printed", [(1.7e6, "1.7 × 10⁶"), (5e-5, "5 × 10⁻⁵"), (1700.0, "1700"), (0.0537, "0.054")]
)
def test_a_cell_states_the_product_of_frequency_and_step(omega_step, printed):
    picks = [Pick("Bathe", "≤ 10", "40 forces", omega_step, float("inf")), Pick("Park", "20", "40 forces", 1.0, 2.0)]
    assert _short_cell(picks).replace("\u00a0", " ") == f"Bathe: ≤ 10 steps, ωΔt = {printed}"


def test_a_step_in_seconds_is_not_a_number_of_steps():
    assert _short_cell([Pick("Bathe", "2.5 ms", "800 forces/s", 0.1, 2.0)]).startswith("Bathe: 2.5\u00a0ms, ωΔt")
    assert _short_cell([]) == "–"
