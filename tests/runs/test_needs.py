"""Which step keeps an error, and which scheme is the cheapest, from made-up runs."""

import numpy as np
import pytest
import xarray as xr

from study.runs.needs import (
    CONDITIONS,
    VERDICTS,
    decisions,
    dominated,
    joined_needs,
    keeps,
    keeps_part,
    needs,
    ranked,
)
from tests.runs.made_up import runs, with_kinds

NAN = np.nan
FINE = [[0.2, 0.05, 0.005, 0.0005]] * 3


def _steps(needed: xr.Dataset, condition="practice", quantity="displacement") -> np.ndarray:
    case = needed.sel(condition=condition, quantity=quantity)
    return case.steps_per_period.transpose("scheme", "allowed_error").values


def test_an_error_that_is_small_by_cancellation_at_one_duration_is_not_kept():
    """Bathe's scheme and average acceleration with as many solves in a period of the softening spring."""
    periods = np.array([50.0, 100.0, 200.0])
    bathe, average = np.array([0.0043, 0.0075, 0.075]), np.array([0.005, 0.0095, 0.022])
    assert [bool(keeps(bathe, periods, n, 0.01)) for n in periods] == [True, False, False]
    assert [bool(keeps(average, periods, n, 0.01)) for n in periods] == [True, True, False]
    failed = np.array([[0.001, NAN, NAN], [0.001, 0.002, np.inf]])
    assert not keeps(failed, periods, 50.0, 0.01).any()


@pytest.mark.parametrize(("periods", "error"), [(10.0, 0.011), (10.0, np.inf), (20.0, 0.05)])
def test_another_start_breaks_an_error_also_over_another_duration(periods, error):
    lengths = [runs(FINE).assign_coords(periods=[length]) for length in (10.0, 20.0)]
    both = xr.concat(lengths, "periods", data_vars="minimal", coords="minimal", compat="override")
    other = both.largest_error.copy(deep=True)
    other.loc[{"periods": periods, "size": 2, "quantity": "displacement"}] = error
    needed = needs(both.assign(largest_error=other), [0.01])
    assert _steps(needed)[:, 0].tolist() == [64] * 3 and _steps(needs(both, [0.01]))[:, 0].tolist() == [32] * 3


def test_all_finer_steps_must_keep_the_error():
    accident = [[0.05, 0.2, 0.05, 0.005], [NAN, 0.05, 0.05, 0.05], [0.05, 0.05, 0.05, 0.2]]
    needed = needs(runs(accident), [0.1, 0.01])
    np.testing.assert_array_equal(_steps(needed), [[32, 64], [16, NAN], [NAN, NAN]])
    first = needed.sel(scheme="cheap", condition="practice", quantity="displacement", allowed_error=0.1)
    assert first.error == 0.05 and first.smaller_steps == 1 and first.step_size == 2 / 32
    # ten periods of two seconds with 32 steps of one force
    assert first.force_evaluations == 320 and first.duration == 20 and first.omega_step == 6 / 32


def test_a_step_that_was_not_tried_does_not_count():
    tried = np.array([[1, 1, 0, 1], [0, 0, 0, 0], [1, 1, 1, 1]])
    needed = needs(runs([[0.05, 0.05, NAN, 0.05], [NAN] * 4, [NAN] * 4], tried=tried), [0.1, 0.01])
    np.testing.assert_array_equal(_steps(needed), [[8, NAN], [NAN, NAN], [NAN, NAN]])
    verdict = needed.verdict.sel(condition="practice", quantity="displacement")
    words = [[VERDICTS[k] for k in row] for row in verdict.transpose("scheme", "allowed_error").values]
    # all runs of the last scheme failed
    finest = "not_even_the_finest_step"
    assert words == [["already_the_coarsest_step", finest], ["no_value", "no_value"], [finest, finest]]
    assert (
        needs(runs(FINE, uncertainty=0.0011), [0.01]).verdict.isel(quantity=0) == VERDICTS.index("below_the_reference")
    ).all()


def test_only_quantities_and_conditions_that_were_searched_have_needs():
    """Only this test catches needs of the velocity, whose steps are not searched, and bounds without a quantity."""
    assert needs(runs(FINE), [0.1]).quantity.values.tolist() == ["displacement"]
    records = runs(FINE, problem="records").isel(quantity=[0]).assign_coords(quantity=["peak drift"])
    names = [VERDICTS[k] for k in needs(records, [0.1]).verdict.sel(scheme="cheap", quantity="peak drift").values.flat]
    assert dict(zip(CONDITIONS, names, strict=True)) == {
        "practice": "found",
        "any_step": "found",
        "whole_motion": "no_value",
    }


def test_a_kind_without_a_scheme_has_a_decision_without_a_name():
    needed = with_kinds(joined_needs([needs(runs(FINE), [0.1])]))
    explicit = decisions(needed.isel(scheme=np.flatnonzero(needed.explicit == 0))).sel(kind="explicit")
    assert (explicit.scheme == "").all() and (explicit.verdict == VERDICTS.index("no_value")).all()
    no_codes = decisions(needed.assign_coords(in_codes=("scheme", [0, 0, 0])))
    assert (no_codes.scheme.sel(filter="codes") == "").all() and (no_codes.scheme.sel(filter="all") != "").all()


def test_conditions_choose_among_the_steps():
    needed = needs(runs(FINE, divides=[1, 0, 1, 1], velocity=[[0.8, 0.8, 0.8, 0.1]] * 3), [0.1])
    assert _steps(needed)[:, 0].tolist() == [32] * 3
    assert _steps(needed, "any_step")[:, 0].tolist() == [16] * 3
    assert _steps(needed, "whole_motion")[:, 0].tolist() == [64] * 3
    other_start = runs(FINE)
    other_start.largest_error.loc[{"quantity": "velocity"}] = np.array([0.8, 0.8, 0.8, 0.1])[:, None]
    assert _steps(needs(other_start, [0.1]), "whole_motion")[:, 0].tolist() == [64] * 3


def test_a_step_keeps_a_part_if_the_whole_motion_needs_another_one_or_has_none():
    needed = needs(runs(FINE, velocity=[[0.8, 0.8, 0.1, 0.1], [0.0] * 4, [0.8] * 4]), [0.1])
    assert keeps_part(needed).sel(quantity="displacement").values.ravel().tolist() == [True, False, True]
    records = runs(FINE, problem="records").isel(quantity=[0]).assign_coords(quantity=["peak drift"])
    assert not keeps_part(needs(records, [0.1])).any()


@pytest.fixture(scope="module")
def decided():
    other = runs([[0.2, 0.2, 0.05, 0.0005], [0.2, 0.01, 0.01, 0.001], [0.2] * 4], problem="mov")
    parts = [needs(ds, [0.1, 0.01]) for ds in (runs(FINE), other)]
    return decisions(with_kinds(joined_needs(parts)))


def test_a_decision_is_the_fewest_forces_of_its_kind(decided):
    selection = {"problem": "swing", "quantity": "displacement", "allowed_error": 0.1, "filter": "all"}
    explicit, implicit = (decided.sel(selection | {"kind": kind}) for kind in ("explicit", "implicit"))
    assert (explicit.scheme, implicit.scheme, implicit.scheme_title) == ("cheap", "stiff", "Stiff")
    assert explicit.steps_per_period == 16 and explicit.force_evaluations == 160
    assert decided.sel(selection | {"filter": "codes", "kind": "explicit"}).scheme == "dear"
    # 32 steps of one force and 16 of two tie, and the smaller error decides
    tied = decided.sel(selection | {"problem": "mov", "kind": "explicit"})
    assert tied.scheme == "dear" and tied.ties == 2
    nobody = decided.sel(selection | {"problem": "mov", "kind": "implicit"})
    assert nobody.scheme == "" and np.isnan(nobody.step_size)
    assert VERDICTS[nobody.verdict.item()] == "not_even_the_finest_step"


def test_computing_time_decides_for_many_unknowns():
    """The cheap scheme needs the fewest forces at equal steps, and the dear one the shortest time."""
    needed = joined_needs([needs(runs(FINE).assign_coords(unknowns=unknowns), [0.1]) for unknowns in (99, 100)])
    assert needed.cost.values.tolist() == ["force_evaluations", "seconds"]
    needed["seconds"] = needed.seconds.fillna(xr.DataArray([3.0, 2.0, 1.0], dims="scheme"))
    decided = decisions(with_kinds(needed)).sel(quantity="displacement", kind="explicit", filter="all")
    assert decided.scheme.squeeze().values.tolist() == ["cheap", "dear"]
    ordered = with_kinds(needed).sel(condition="practice", quantity="displacement").squeeze("allowed_error")
    assert [ranked(ordered.isel(problem=k)) for k in (0, 1)] == [["cheap", "dear", "stiff"], ["stiff", "dear", "cheap"]]


def test_of_two_kinds_that_tie_the_more_accurate_one_is_first():
    """The implicit scheme needs a twentieth more forces than the cheap explicit one, and has a smaller error."""
    needed = with_kinds(joined_needs([needs(runs(FINE), [0.1])])).sel(condition="practice", quantity="displacement")
    needed = needed.squeeze(["problem", "allowed_error"])
    forces = xr.DataArray([100.0, 150.0, 105.0], dims="scheme")
    for error, first in (([0.05, 0.01, 0.02], "stiff"), ([0.02, 0.01, 0.05], "cheap")):
        variant = needed.assign(force_evaluations=forces, error=("scheme", error), largest_error=("scheme", error))
        assert ranked(variant)[0] == first


def test_a_scheme_dominates_if_it_is_worse_in_nothing_and_better_in_something():
    of = xr.DataArray([[1.0, 2.0, np.inf], [3.0, 3.0, np.inf]], {"scheme": ["a", "b", "c"]}, ["respect", "scheme"])
    assert dominated(of, "b") == ["a"] and dominated(of, "a") == [] and dominated(of, "c") == ["a", "b"]
