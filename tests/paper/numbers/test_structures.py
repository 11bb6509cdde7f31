"""Numbers of the text on structures, from made-up runs with known errors."""

import numpy as np
import pytest
import xarray as xr

from paper.claims.structures import SAMPLES_OF_SAWTOOTH, sawtooth
from paper.numbers.structures import _accurate_unbalanced, _between, _fails_in_longer_runs, _limits, _plateaus
from paper.tables import models
from study.runs.needs import decisions, joined_needs, needs
from tests.runs.made_up import runs, with_kinds


def test_a_smooth_velocity_is_no_alternating_one():
    angle = 2 * np.pi * np.arange(21) / 20
    smooth, alternating = 1.2 * np.sin(angle), (-1.0) ** np.arange(21)
    velocity = xr.DataArray([smooth, smooth + 0.3 * alternating], dims=("scheme", "t"))
    none, some = sawtooth(velocity)
    # the tenth difference leaves sin¹⁰(π/20) of a sine
    assert none == pytest.approx(1.2 * np.sin(np.pi / 20) ** 10, rel=1e-6) and some == pytest.approx(0.3)
    shortest = np.append(np.zeros(3), [0.5, -0.5, 0.5, -0.5])
    assert len(shortest) == 1 + SAMPLES_OF_SAWTOOTH and sawtooth(xr.DataArray([shortest], dims=("scheme", "t"))) == 0.5


def _structures(gauss, bathe):
    errors = (("problem", "scheme", "steps_per_period"), [[gauss, bathe]])
    coordinates = {"problem": ["stiff_soft"], "scheme": ["gauss4", "bathe"], "steps_per_period": [10, 20, 40, 80]}
    return xr.Dataset({"sampled_displacement_error": errors}, coordinates)


def test_errors_that_no_finer_step_reduces_are_a_range():
    # the coarser half of the steps does not count, and neither does which of the others comes last
    plateaus = _plateaus(_structures([0.4, 1e-5, 3.2e-4, 2.5e-4], [0.05, 0.01, 1.6e-4, 1.6e-4]))
    assert plateaus == {
        "plateau_gauss4": "0.025 to 0.032",
        "plateau_bathe": "0.016",
        "plateau_from": "40",
        "plateau_to": "80",
    }
    assert set(_plateaus(_structures([0.4, 0.1, 0.02, 0.005], [0.4, 0.1, 0.02, 0.005])).values()) == {None}


def _decided():
    accurate = [[0.2, 0.05, 0.005, 0.0005], [0.2] * 4, [0.05, 0.05, 0.005, 0.005]]
    return decisions(with_kinds(joined_needs([needs(runs(accurate, problem="elastic_pendulum"), [0.1, 0.01, 0.001])])))


def test_a_scheme_with_an_accurate_displacement_may_fail_by_its_balance():
    """A scheme that keeps the displacement and fails by its energies, named at steps at which it does not."""
    # the only implicit scheme keeps one percent with 32 steps
    assert _accurate_unbalanced(_decided(), {"stiff": (40.0, 80.0)}) == {
        "accurate_unbalanced": "Stiff",
        "accurate_unbalanced_limit": "between 40 and 80",
    }
    for limits in ({"stiff": (16.0, 20.0)}, {"stiff": (np.nan, np.nan)}, {}):
        assert _accurate_unbalanced(_decided(), limits)["accurate_unbalanced"] is None


def _pendulum():
    """Runs of two schemes; the finest step of the first was not tried."""
    energy = [[[0.3, 0.3], [0.01, 0.2], [0.01, 0.05], [0.01, 9.0]], [[0.3, 0.3], [0.3, 0.3], [0.3, 0.3], [0.3, 0.3]]]
    status = [[[0, 0], [1, 1], [0, 0], [0, 0]], [[0, 0]] * 4]
    return xr.Dataset(
        {
            "error": (("scheme", "size", "periods", "quantity"), np.array(energy)[..., None]),
            "status": (("scheme", "size", "periods"), status),
            "tried": (("scheme", "size"), [[1, 1, 1, 0], [1, 1, 1, 1]]),
        },
        {
            "scheme": ["average_acceleration", "gauss4"],
            "quantity": ["energy"],
            "periods": [1.0, 1.5],
            "steps_per_period": ("size", [10.0, 20.0, 30.0, 80.0]),
        },
    )


def test_the_longest_runs_fail_by_status_or_balance():
    assert _fails_in_longer_runs(_pendulum()) == {
        "fails_longer_to": "20",
        "fails_longer_limit": "between 20 and 30",
        "fails_longer_periods": "1.5",
    }


def test_a_limit_lies_between_neighbours_of_all_steps_tried():
    schemes, steps = ["average_acceleration", "gauss4", "energy_momentum"], [10, 20, 40]
    imbalance = [[0.3, 0.3, 0.01], [0.3, 0.01, 0.01], [0.01, 0.01, 0.01]]
    structures = xr.Dataset(
        {
            "max_energy_imbalance": (("problem", "scheme", "steps_per_period"), [imbalance]),
            "status": (("problem", "scheme", "steps_per_period"), np.zeros((1, 3, 3), int)),
        },
        {"problem": ["elastic_pendulum"], "scheme": schemes, "steps_per_period": steps},
    ).assign_coords(periods=("problem", [1.0]))
    limits = _limits(structures, _pendulum())
    # the second dataset has a step between those of the first, and all steps of Gauss' method fail in it
    assert {name: _between(limit) for name, limit in limits.items()} == {
        "average_acceleration": "between 20 and 30",
        "gauss4": "above 80",
        "energy_momentum": None,
    }
    assert _between(_limits(structures.assign_coords(periods=("problem", [3.0])), _pendulum())["gauss4"]) == (
        "between 10 and 20"
    )
    # on another structure Gauss' method alone fails, with 10 and 20 steps
    truss = structures.assign_coords(problem=["spinning_truss"]).copy(deep=True)
    truss.max_energy_imbalance[:] = [[[0.01, 0.01, 0.01], [0.3, 0.3, 0.01], [0.01, 0.01, 0.01]]]
    both = xr.concat([structures, truss], "problem").assign_coords(periods=("problem", [3.0, 1.0]))
    limits = _limits(both, _pendulum())
    assert [_between(limits[name]) for name in schemes] == ["between 20 and 40", "between 20 and 40", None]


@pytest.mark.parametrize(
    ("problem", "stated"), [("yielding", "yieldinging thing, 10 periods"), ("records", "recordsing thing")]
)
def test_the_answers_state_the_duration_that_was_run(problem, stated):
    decided = _decided().assign_coords(problem=[problem], problem_title=("problem", [f"{problem}ing thing"]))
    decided = decided.assign_coords(quantity=["peak drift" if problem == "records" else "displacement"])
    limits = xr.Dataset(
        {"stability_limit": (("scheme", "damping_ratio"), [[2.0]])},
        {"scheme": ["explicit_scheme"], "damping_ratio": [0.0]},
    )
    (row,) = models.tabulate(decided, limits).to_dict("records")
    assert row["Measured on"] == stated
