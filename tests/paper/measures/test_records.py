"""Numbers of the laws of records, on made-up datasets."""

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from paper.claims import records
from paper.measures.record_error import order, scatter, square_of_step
from paper.measures.shares import share_of_runs
from paper.measures.what_moves import choice_spread, coarsest_step, median_changes, record_changes, single_changes
from paper.numbers.what_moves import what_moves_numbers
from paper.tables.what_moves import tabulate


def _errors(load=0.0, averaged=0.0):
    """Errors of second order, with a part of the load at steps that do not divide."""
    ratio, spacing = np.array([0.25, 0.5, 1.0, 0.4, 0.6, 0.75]), np.array([0.01, 0.02])
    step = ratio * spacing[:, None]
    passes, period_error = np.array([0, 0, 0, 1, 1, 1]), step[:, None] ** 2 * np.array([5.0, 20.0])[:, None]
    shape = ("scheme", "record", "period", "ratio")
    error = np.stack([period_error + load * passes, period_error + averaged * passes], axis=-1)
    return xr.Dataset(
        {
            "error": ((*shape, "load"), error[None]),
            "period_error": (shape, period_error[None]),
            "predicted_error": (shape, (period_error + load * passes)[None]),
            "power_above": (("record", "ratio"), step),
        },
        {
            "scheme": ["average_acceleration"],
            "load": ["samples", "averages"],
            "period": [1.0, 0.5],
            "ratio": ratio,
            "divides": ("ratio", 1 - passes),
            "step_size": (("record", "ratio"), step),
        },
    )


def test_a_power_law_has_its_order_and_no_scatter():
    errors = _errors().isel(scheme=0)
    assert scatter(errors, errors.predicted_error) == pytest.approx(0, abs=1e-12)
    assert scatter(errors, square_of_step(errors)) == pytest.approx(0, abs=1e-12)
    assert scatter(errors, errors.power_above) > 0.2
    assert order(errors, "samples", True) == pytest.approx(2)
    assert order(_errors(load=0.1).isel(scheme=0), "samples", False) < 0.2


@pytest.mark.parametrize("load, averaged, holds", [(0.3, 0.0, True), (0.3, 0.3, False), (0.0, 0.0, False)])
def test_the_mean_of_the_load_is_judged_at_steps_that_pass_over_samples(load, averaged, holds):
    assert records.mean_load_restores(_errors(load, averaged)).holds == holds


def test_a_prediction_holds_within_a_tenth():
    assert records.period_and_load_decide(_errors(load=0.1)).holds
    larger = _errors(load=0.1).assign(error=lambda ds: 1.2 * ds.error)
    assert not records.period_and_load_decide(larger).holds
    assert not records.power_above_decides(_errors(load=0.1)).holds


def test_the_interval_of_a_share_is_that_of_the_mean_over_the_records():
    kept = xr.DataArray(
        np.repeat([[1.0, 1.0, 0.0, 1.0]] * 3 + [[1.0, 0.0, 0.0, 1.0]], 2, axis=0), dims=("record", "ratio")
    )
    interval = stats.ttest_1samp(kept.mean("ratio"), 0.0).confidence_interval(0.95)
    assert share_of_runs(kept) == pytest.approx((11 / 16, *interval))
    # if no record has both outcomes: the share at which as many successes have a probability of 2.5 %
    share, low, high = share_of_runs(kept.where(kept == 1, 1.0))
    assert (share, high) == (1.0, 1.0) and low == pytest.approx(0.025 ** (1 / kept.sizes["record"]))


def _moves(step):
    """Four records whose values change by a step, and by a tenth with less damping."""
    values = np.array([1.0, 2.0, 3.0, 10.0])
    data = np.stack([values, values * (1 + step), values * 0.9])[:, None]
    dims, names = ("variant", "period", "record"), ("collapse_intensity", "peak_drift", "residual_drift")
    coords = {"variant": ["reference", "spacing", "damping"], "period": [1.0], "record": list("abcd")}
    return xr.Dataset({name: (dims, data) for name in names}, coords)


def test_medians_change_by_the_step_and_choices_by_the_records():
    moves = _moves(0.01)
    medians = median_changes(moves.peak_drift).isel(period=0)
    assert medians.change.values == pytest.approx([0, 0.01, -0.1])
    assert medians.low.values == pytest.approx([0, 0.01, -0.1]) and medians.high.values == pytest.approx(
        [0, 0.01, -0.1]
    )
    assert 0 < choice_spread(moves.peak_drift, 40).item() < choice_spread(moves.peak_drift, 4).item()
    assert record_changes(moves.peak_drift).sel(variant="spacing").values == pytest.approx(0.01)
    assert record_changes(moves.residual_drift).isel(variant=2, period=0).values == pytest.approx(
        [0.04, 0.08, 0.12, 0.4]
    )


def test_the_interval_of_single_changes_covers_in_at_least_95_percent_and_no_wider_one_is_needed():
    """The number of 100 records below the change that 90 % do not exceed is binomial."""
    reference = xr.DataArray(np.ones((1, 100)), dims=("period", "record"))
    drift = xr.concat(
        [reference, reference + np.arange(1.0, 101.0)], xr.IndexVariable("variant", ["reference", "step"])
    )
    single = single_changes(drift.rename("peak_drift")).sel(variant="step").isel(period=0)
    below = stats.binom(100, 0.9)
    assert single.change == 90
    assert below.cdf(single.low - 1) <= 0.025 < below.cdf(single.low)
    assert below.sf(single.high - 1) <= 0.025 < below.sf(single.high - 2)


def test_where_both_motions_collapse_under_all_records_no_single_change_is_known():
    drift = xr.DataArray(np.full((2, 1, 9), np.inf), dims=("variant", "period", "record"))
    drift = drift.assign_coords(variant=["reference", "step"]).rename("peak_drift")
    assert single_changes(drift).to_array().isnull().all()


@pytest.mark.parametrize(
    "changes, coarsest",
    [
        ([0.01, 0.02, 0.05, 0.2], 2.0),
        ([0.01, 0.2, 0.05, 0.2], 1.0),
        ([0.01, 0.02, 0.05, 0.09], 4.0),
        ([0.2, 0.01, 0.01, 0.01], np.nan),
        ([0.01, np.inf, 0.05, 0.2], np.nan),  # where a median is a collapse, no change is known
    ],
)
def test_the_coarsest_step_and_all_finer_ones_move_the_median_less_than_damping(changes, coarsest):
    values = np.array([1.0, 2.0, 3.0, 10.0]) * (1 + np.array([0.0, *changes, -0.1]))[:, None]
    variants = ["reference", "spacing", "off", "two", "four", "damping"]
    coords = {"variant": variants, "period": [1.0], "ratio": ("variant", [0.25, 1.0, 4 / 3, 2.0, 4.0, 0.25])}
    peaks = xr.DataArray(values[:, None], coords, ("variant", "period", "record"))
    assert coarsest_step(peaks) == pytest.approx(coarsest, nan_ok=True)


@pytest.mark.parametrize("step, holds", [(0.01, True), (0.2, False)])
def test_the_step_is_compared_with_damping_and_choice(step, holds):
    assert records.step_moves_least(_moves(step)).holds == holds


@pytest.mark.parametrize("strength, most", [(0.85, True), (0.05, False)])
def test_the_choice_of_records_is_compared_with_the_other_changes(strength, most):
    moves = _moves(0.01)
    others = moves.sel(variant=["reference"] * 4).assign_coords(variant=["strength", "off", "two", "four"])
    moves = xr.concat([moves, others * xr.DataArray([strength, 1.0, 1.0, 1.0], dims="variant")], "variant")
    moves = moves.assign_coords(ratio=("variant", [0.25, 1.0, 0.25, 0.25, 4 / 3, 2.0, 4.0]))
    counts = {"runs": 7, "failed": 0}
    numbers = what_moves_numbers(
        moves.assign(counts).assign_coords(
            scheme="average_acceleration",
            spacing=0.01,
            parts=4,
            intensity=3.0,
            hardening=0.02,
            p_delta=0.06,
            collapse=24.5,
        )
    )
    # the medians of forty of the four records differ by more than the damping of a tenth
    assert numbers["moves_step_is_least"] and numbers["moves_choice_is_most"] == most
    assert numbers["moves_peak_coarsest"] == "4 times the spacing"


def test_the_table_of_medians_has_the_range_over_the_periods():
    """The step adds one percent to all drifts at one period, and two at the other."""
    moves = xr.concat([_moves(0.01), _moves(0.02).assign_coords(period=[0.2])], "period")
    table = tabulate(moves.assign_coords(variant_title=("variant", [f"with {name}" for name in moves.variant.values])))
    row = table.set_index("Change").loc["With spacing"]
    assert row["Peak drift"] == "+1.0 to +2.0"
    assert "With reference" not in [*table["Change"]] and table["Change"].iloc[-1] == "Choice of 40 records"


def test_a_median_over_collapses_is_no_drift_and_is_named():
    moves = _moves(0.01)
    collapsing = xr.concat([moves, moves.assign_coords(period=[0.2])], "period")
    for name in ("peak_drift", "residual_drift"):
        collapsing[name].loc[{"period": 0.2, "record": ["b", "c", "d"]}] = np.inf
    finding = records.step_moves_least(collapsing)
    assert finding.holds and "at the period of 0.2 s most motions collapse" in finding.qualification
    assert np.isnan(median_changes(collapsing.peak_drift).change.sel(period=0.2)).all()
    assert not records.step_moves_least(moves).qualification


def test_a_period_at_which_one_variant_collapses_has_no_change_of_drift():
    drift = _moves(0.01).peak_drift
    collapsing = drift.where((drift.variant != "damping") | (drift.record == "a"), np.inf)
    assert median_changes(collapsing).to_array().isnull().all() and choice_spread(collapsing, 4).isnull().all()
    assert median_changes(drift).change.notnull().all() and choice_spread(drift, 4).notnull().all()
