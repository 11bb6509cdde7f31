"""The numbers printed in 1996: all 98 cells with the paper's step sizes."""

import numpy as np
import pytest

import study
from paper.published import once, printed_cpu_times, printed_energy_errors, same, twice
from study.problem.named import printed_periods

PRINTED = printed_energy_errors()


#: The one cell that no rounding explains: printed 36.0, computed 35.904.
ODD = ("softening", 50, "wilson_theta")


def _error(problem, steps, scheme):
    """Largest energy error in percent."""
    ds = study.run(
        problem, scheme, dt=printed_periods[problem] / steps, steps=100 * steps, observe=["max_energy_error"]
    )
    return 100 * ds.max_energy_error


@pytest.mark.slow
@pytest.mark.parametrize("problem", ["hardening", "softening"])
@pytest.mark.parametrize("scheme_name", PRINTED.scheme.values)
def test_every_cell_agrees_with_the_print(problem, scheme_name):
    for steps in PRINTED.steps_per_period.values:
        printed = PRINTED.sel(problem=problem, steps_per_period=steps, scheme=scheme_name)
        ours = _error(problem, steps, scheme_name)
        if (problem, steps, scheme_name) == ODD:
            assert ours.item() == pytest.approx(35.904, abs=5e-4)
            continue
        assert abs(ours - printed) <= 0.06
        assert same(twice(ours), printed)


def test_one_printed_cell_decides_the_start_of_houbolt():
    for start, digit in {
        "linear_acceleration": 97.3,
        "central_difference": 97.4,
        "taylor": 97.4,
        "exact": 97.4,
    }.items():
        ds = study.run(
            "hardening", study.Houbolt(start_by=start), dt=0.15 / 20, steps=2000, observe=["max_energy_error"]
        )
        assert same(twice(100 * ds.max_energy_error), digit), start


def test_printed_tables_are_whole():
    assert PRINTED.size == 98 and np.isfinite(PRINTED).all()
    assert list(PRINTED.scheme.values) == list(study.schemes)[:7]
    assert printed_cpu_times().size == 14


@pytest.mark.parametrize(
    "value, rounded_once, rounded_twice",
    [(35.904, 35.9, 35.9), (39.4477, 39.4, 39.5), (0.0489, 0.0, 0.1), (7.05, 7.1, 7.1)],
)
def test_rounding(value, rounded_once, rounded_twice):
    value = PRINTED[0, 0, 0].copy(data=value)
    assert same(once(value), rounded_once) and same(twice(value), rounded_twice)
