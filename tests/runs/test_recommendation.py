"""Recommendations from made-up needs, and from a made-up assessment with known step sizes and computing times."""

import shutil

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import study
from study.analysis.recommendation import _ranked
from study.assessment.report import answer
from study.runs.needs import NO_VALUE, UNCERTAIN, decisions
from tests import small_results


@pytest.fixture
def assessed():
    return small_results.assessment()


def test_the_fastest_scheme_is_first_and_those_without_a_step_are_last(assessed):
    table = study.recommend(assessed, allowed_error=0.01)
    assert table.index.tolist() == ["central_difference", "average_acceleration"]
    assert table.step_size.tolist() == [0.005, 0.01] and table.steps.tolist() == [2000, 1000]
    assert table.largest_step_size.tolist() == [1.05 * 0.005, 1.05 * 0.01]
    assert table.omega_step.tolist() == [0.015, 0.03] and table.kind.tolist() == ["explicit", "implicit"]
    assert table["seconds"].tolist() == pytest.approx([10e-6, 50e-6]) and set(table.verdict) == {"found"}
    without = study.recommend(assessed, allowed_error=0.01, quantity="energy")
    assert without.verdict.tolist() == ["found", "not even the finest step"] and without.step_size.isna().tolist()[1]


def test_the_other_errors_at_a_step_are_stated(assessed):
    table = study.recommend(assessed, allowed_error=0.01, quantity="energy")
    assert table.most_wrong.iloc[0] == "displacement" and table.most_wrong.isna().iloc[1]
    assert table.most_wrong_error.iloc[0] == pytest.approx(100 * 0.004)
    assert "with Δt = 0.004 s (2500 steps, 12.5 µs), but displacement is wrong by 40\u00a0%." in answer(
        assessed, "energy", 0.01
    )
    assessed.error[:] = 0.1
    assert "wrong by" not in answer(assessed, "energy", 0.01)


def test_times_within_their_spreads_tie(assessed):
    assert study.recommend(assessed, allowed_error=0.01).ties_with_fastest.tolist() == [True, False]
    assessed.seconds_spread.loc[{"scheme": "average_acceleration"}] = 90e-6
    assert study.recommend(assessed, allowed_error=0.01).ties_with_fastest.tolist() == [True, True]


def test_times_within_their_spread_are_ranked_by_counts(assessed):
    """48.3 ± 102 µs does not distinguish a scheme from 12.4 µs: the number of forces decides, or of steps."""
    assessed.seconds.values[:], assessed.seconds_spread.values[:] = [[[12.4e-6]], [[48.3e-6]]], [[[1e-6]], [[102e-6]]]
    assert study.recommend(assessed, allowed_error=0.1, quantity="energy").index[0] == "average_acceleration"
    assessed.force_evaluations.loc[{"scheme": "central_difference"}] = 10.0
    table = study.recommend(assessed, allowed_error=0.1, quantity="energy")
    assert table.index[0] == "central_difference" and table.ties_with_fastest.all()
    assert "do not distinguish it from Average acceleration; the number of evaluations decides." in answer(
        assessed, "energy", 0.1
    )
    # at equal numbers the smaller error decides, not the noise of the times
    assessed.force_evaluations[:] = 10.0
    for first, errors in (("average_acceleration", [0.01, 0.02]), ("central_difference", [0.02, 0.01])):
        both = xr.DataArray(errors, dims="scheme").broadcast_like(assessed.recommended_error)
        assessed["recommended_error"] = both.transpose(*assessed.recommended_error.dims).copy(deep=True)
        assert study.recommend(assessed, allowed_error=0.1, quantity="energy").index[0] == first
        assert answer(assessed, "energy", 0.1).endswith("the number of evaluations decides, then the error.")
    assessed.force_evaluations[:] = float("nan")
    assert (
        study.recommend(assessed, allowed_error=0.01).index[0] == "average_acceleration"
    )  # 1,000 steps instead of 2,000
    assessed.seconds_spread[:] = 1e-6
    assert study.recommend(assessed, allowed_error=0.01).index[0] == "average_acceleration"
    assessed.seconds.loc[{"scheme": "central_difference"}] = 1e-6
    assert study.recommend(assessed, allowed_error=0.01).index[0] == "central_difference"


def test_a_noisy_time_places_no_scheme_before_a_faster_one_with_fewer_forces():
    """``noisy`` ties with ``explicit``, from which ``fast`` differs. It is slower than ``fast`` and has more forces."""
    rows = {"explicit": (1.0, 0.1, 10), "fast": (1.5, 0.1, 20), "noisy": (2.0, 3.0, 30)}
    table = pd.DataFrame.from_dict(rows, "index", columns=["seconds", "seconds_spread", "force_evaluations"])
    assert _ranked(table.assign(step_size=1.0, error=0.0)) == ["explicit", "fast", "noisy"]


def _with_step(assessed, step):
    """The assessment with one recommended step for all schemes, quantities and errors."""
    steps = assessed.recommended_step_size.copy(data=np.full(assessed.recommended_step_size.shape, step))
    return assessed.assign(recommended_step_size=steps).assign_coords(
        step_size=[step, 1.0, 2.0, 3.0][: assessed.sizes["step_size"]]
    )


def test_what_is_printed_can_be_typed_back(assessed):
    assessed = _with_step(assessed, 3.6e-6).assign_attrs(duration=0.0999972)
    assessed["highest_frequency"], assessed.largest_step_size[:] = float("nan"), 3.8666251e-6
    table = study.recommend(assessed, allowed_error=0.01)
    text = table[["step_size", "largest_step_size", "omega_step", "steps", "seconds"]].to_string()
    row = text.splitlines()[-1].split()
    assert row[1:5] == ["3.6e-06", "3.86e-06", "–", "27777"] and float(row[1]) == 3.6e-6
    assert "NaN" not in text and "nan" not in text
    assert str(table).startswith("1 % of displacement: Central difference, 3.6 µs\n")
    assert all(name in str(table).split() for name in table.columns)
    assert table.step_size.dtype == float and table.head(1).to_string().startswith("1 % of")
    assert "<p>1\u00a0% of displacement: " in table._repr_html_()


def test_a_fraction_of_a_spacing_is_printed_as_such(assessed):
    assessed = _with_step(assessed, 0.02 / 3).assign_attrs(spacing=0.02)
    text = study.recommend(assessed, allowed_error=0.01)[["step_size"]].to_string()
    assert text.splitlines()[0].endswith("20/3 ms") and text.splitlines()[-1].split()[-1] == "0.02/3"


def test_a_scheme_that_was_asked_for_is_compared(assessed):
    remark = "Central difference is unstable without damping at every step"
    assessed.attrs |= {"asked_for": "central_difference", "remarks": remark}
    compared = "1\u00a0% of displacement, Central difference: 5\u00a0ms, 2 × the forces of Average acceleration"
    table = study.recommend(assessed, allowed_error=0.01)
    *requested, best = table.attrs["answer"]
    assert requested == [remark, compared] and best == "1\u00a0% of displacement, best: Central difference, 5\u00a0ms"
    assert str(table).count(remark) == 1
    assessed.attrs["asked_for"] = "average_acceleration"
    none = "1\u00a0% of energy, Average acceleration: no step was found (not even the finest step)"
    assert study.recommend(assessed, allowed_error=0.01, quantity="energy").attrs["answer"][0] == none


def test_a_name_stands_for_the_dataset_of_that_name(assessed, tmp_path):
    small_results.write_to(tmp_path)
    by_name = study.recommend("mine", allowed_error=0.1, quantity="energy", folder=tmp_path)
    pd.testing.assert_frame_equal(by_name, study.recommend(assessed, allowed_error=0.1, quantity="energy"))


def test_a_name_of_a_problem_and_of_a_file_is_refused(assessed, tmp_path, monkeypatch):
    small_results.write_to(tmp_path)
    shutil.copy(tmp_path / "assessment" / "mine.nc", tmp_path / "softening.nc")
    with pytest.raises(ValueError, match=r"'softening' is a problem of the study and the file '.*softening\.nc'"):
        study.recommend("softening", allowed_error=0.1, folder=tmp_path)
    monkeypatch.chdir(tmp_path)
    by_file = study.recommend("softening.nc", allowed_error=0.1, quantity="energy")
    pd.testing.assert_frame_equal(by_file, study.recommend(assessed, allowed_error=0.1, quantity="energy"))


@pytest.mark.slow
def test_a_problem_of_the_study_has_the_decisions_as_its_first_rows(tmp_path):
    small_results.write_to(tmp_path)
    needed = small_results.needed()
    decided = decisions(needed).sel(problem="softening", filter="all")
    for quantity, error in (("displacement", 0.1), ("displacement", 0.01)):
        table = study.recommend("softening", allowed_error=error, quantity=quantity, folder=tmp_path)
        for kind in ("explicit", "implicit"):
            decision = decided.sel(quantity=quantity, allowed_error=error, kind=kind)
            first = table[table.kind == kind].iloc[0]
            assert (first.name, first.step_size, first.force_evaluations_per_time) == (
                decision.scheme.item(),
                decision.step_size.item(),
                (decision.force_evaluations / decision.duration).item(),
            )
    # 16 steps of one force and 8 of two tie, and the names stand in the order of their needs
    table = study.recommend("softening", allowed_error=0.1, folder=tmp_path)
    assert table.index.tolist() == ["cheap", "dear", "stiff"] and table.steps_per_period.tolist() == [16, 8, 16]
    text = str(table)
    assert text.startswith("10 % of displacement, explicit: Cheap, 0.125 s\n10 % of displacement, implicit: Stiff")
    assert "Runs on the softeninging thing last 10 times 2 s, from one start." in text
    assert (
        study.recommend("softening", allowed_error=0.01, folder=tmp_path).verdict["dear"] == "not even the finest step"
    )
    pd.testing.assert_frame_equal(table, study.recommend(needed.sel(problem="softening"), allowed_error=0.1))
    known_to_codes = needed.sel(problem="softening", scheme=needed.in_codes == 1)
    assert study.recommend(known_to_codes, allowed_error=0.1).index.tolist() == ["dear", "stiff"]


def test_a_longer_duration_extrapolates_the_steps_of_a_free_vibration(assessed):
    """The step of both schemes, of second order, falls with the root of the duration, from 10 s to 90 s."""
    assessed.attrs |= {"free_vibration": 1, "duration_requested": 10.0}
    known = study.recommend(assessed, allowed_error=0.01)
    table = study.recommend(assessed, allowed_error=0.01, duration=90)
    assert table.step_size.to_dict() == {"average_acceleration": 0.0033, "central_difference": 0.0016}
    assert table.step_size_of_runs.to_dict() == known.step_size.to_dict() and set(table.verdict) == {"extrapolated"}
    assert table.steps.tolist() == [27273, 56250] and table.exponent.tolist() == [0.5, 0.5]
    assert table.force_evaluations["central_difference"] == pytest.approx(200 * 0.005 / 0.0016 * 90)
    assert str(table).startswith(
        "1 % of displacement over 90 s, implicit: Average acceleration, 3.3 ms (extrapolated)\n"
    )
    assert "No run of 90 s confirms them." in str(table)
    pd.testing.assert_frame_equal(study.recommend(assessed, allowed_error=0.01, duration=5), known)
    without = assessed.copy(deep=True)
    without.recommended_step_size.loc[{"scheme": "average_acceleration"}] = np.nan
    last = study.recommend(without, allowed_error=0.01, duration=90)
    assert last.index.tolist() == ["central_difference", "average_acceleration"] and np.isnan(last.step_size.iloc[1])
    energy = study.recommend(assessed, allowed_error=0.1, quantity="energy", duration=90)
    assert energy.step_size.to_dict() == energy.step_size_of_runs.to_dict()


def test_another_duration_keeps_the_value_to_which_errors_are_relative(assessed):
    """A step of 40 % error: over the first seconds the motion is far smaller than over the run that was assessed."""
    assessed.attrs |= {"free_vibration": 1, "duration_requested": 10.0}
    later = assessed.assign_coords(scaled_from=("quantity", [6.0, 0.0]))
    for duration, quantity in ((6.0, "displacement"), (2.0, "energy")):
        known = study.recommend(later, allowed_error=0.1, quantity=quantity)
        shorter = study.recommend(later, allowed_error=0.1, quantity=quantity, duration=duration)
        pd.testing.assert_frame_equal(shorter, known)
    with pytest.raises(ValueError, match="their errors of 'displacement' do not bound those of a run of 5 s"):
        study.recommend(later, allowed_error=0.1, duration=5)
    phase = assessed.assign_coords(scaled_from=("quantity", [np.inf, 0.0]))  # may be larger in a shorter run
    with pytest.raises(ValueError, match="do not bound those of a run of 9.9 s"):
        study.recommend(phase, allowed_error=0.1, duration=9.9)
    assert set(study.recommend(phase, allowed_error=0.1, duration=90).verdict) == {"extrapolated"}
    final = assessed.assign_coords(scaled_from=("quantity", [np.nan, 0.0]))
    for without in (final, assessed.drop_vars("scaled_from")):
        for duration, sentence in ((5, "do not bound those"), (90, "only for quantities along time")):
            with pytest.raises(ValueError, match=sentence):
                study.recommend(without, allowed_error=0.1, duration=duration)


def test_a_problem_of_the_study_is_extrapolated_if_it_is_a_spring():
    needed = small_results.needed().sel(problem="softening")
    table = study.recommend(needed, allowed_error=0.1, duration=80)
    # 4 times the 20 s of the runs: 4^(2/5) with a dissipative scheme of fourth order, 4^(2/3) with one of second order
    exponents = {"cheap": 0.4, "dear": 2 / 3, "stiff": 2 / 3}
    known, scale = study.recommend(needed, allowed_error=0.1).step_size, needed.time_scale.item()
    for name, a in exponents.items():
        assert table.step_size[name] == pytest.approx(scale / np.ceil(scale / known[name] * 4**a))
    assert set(table.index) == {*exponents}
    with pytest.raises(ValueError, match="the runs last 20 s, and steps are extrapolated to 80 s only for .* free vib"):
        study.recommend(needed.assign_coords(free_vibration=0), allowed_error=0.1, duration=80)
    pd.testing.assert_frame_equal(
        study.recommend(needed, allowed_error=0.1, duration=scale), study.recommend(needed, allowed_error=0.1)
    )
    with pytest.raises(ValueError, match="do not bound those of a run of 1 s"):
        study.recommend(needed, allowed_error=0.1, duration=1)


def test_a_name_that_is_neither_an_assessment_nor_a_problem_is_told(tmp_path):
    small_results.write_to(tmp_path)
    with pytest.raises(KeyError, match="no assessment and no problem 'softning' in .*; did you mean 'softening'?"):
        study.recommend("softning", allowed_error=0.1, folder=tmp_path)


@pytest.mark.parametrize(
    "arguments, error, sentence",
    [
        ({"quantity": "energi"}, KeyError, "no step was sought for the quantity 'energi'; did you mean 'energy'?"),
        (
            {"allowed_error": 0.05},
            ValueError,
            "allowed_error must be one that was assessed, 0.1, 0.01, not 0.05; allowed_errors",
        ),
        (
            {"allowed_error": float("nan")},
            ValueError,
            "allowed_error must be one that was assessed, 0.1, 0.01, not nan; allowed_errors",
        ),
        ({"allowed_error": "0.1"}, TypeError, "allowed_error must be a number, not '0.1'."),
        ({"duration": 0}, ValueError, "duration must be a positive number of seconds, not 0."),
        (
            {"duration": 11},
            ValueError,
            "the runs last 10 s, and steps are extrapolated to 11 s only for",
        ),
        ({"quantity": 3}, TypeError, "quantity must be a name, not 3."),
        ({"what": small_results.needed()}, ValueError, "the needs of all problems: give the name of one, of softening"),
        (
            {
                "what": small_results.needed()
                .sel(problem="softening")
                .pipe(lambda ds: ds.assign(verdict=0 * ds.verdict + UNCERTAIN))
            },
            ValueError,
            "no scheme has a step on the softeninging thing: no reference is certain enough.",
        ),
        (
            {
                "what": small_results.needed()
                .sel(problem="softening")
                .pipe(lambda ds: ds.assign(verdict=0 * ds.verdict + NO_VALUE))
            },
            ValueError,
            "no scheme can be run on the softeninging thing.",
        ),
        ({"what": None}, TypeError, "recommend takes the dataset that study.assess returns, or the name"),
        ({"what": small_results.energy_error()}, ValueError, "recommend takes a dataset of study.assess, or the needs"),
    ],
)
def test_mistakes_get_a_sentence(assessed, arguments, error, sentence):
    with pytest.raises(error) as caught:
        study.recommend(**{"what": assessed, "allowed_error": 0.01} | arguments)
    assert sentence in str(caught.value)
