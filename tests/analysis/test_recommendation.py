"""Recommendations from a made-up assessment with known step sizes and computing times."""

import pandas as pd
import pytest

import study
from study.assessment.report import answer
from tests import small_results


@pytest.fixture
def assessed():
    return small_results.assessment()


def test_the_fastest_scheme_is_first_and_those_without_a_step_are_last(assessed):
    table = study.recommend(assessed, error=0.01)
    assert table.index.tolist() == ["central_difference", "average_acceleration"]
    assert table.step_size.tolist() == [0.005, 0.01] and table.number_of_steps.tolist() == [2000, 1000]
    assert table.largest_step.tolist() == [1.05 * 0.005, 1.05 * 0.01]
    assert table.omega_step.tolist() == [0.015, 0.03] and table.kind.tolist() == ["explicit", "implicit"]
    assert table["time"].tolist() == pytest.approx([10e-6, 50e-6]) and set(table.verdict) == {"found"}
    without = study.recommend(assessed, error=0.01, quantity="energy")
    assert without.verdict.tolist() == ["found", "not even the finest step"] and without.step_size.isna().tolist()[1]


def test_the_other_errors_at_a_step_are_stated(assessed):
    table = study.recommend(assessed, error=0.01, quantity="energy")
    assert table.most_wrong.iloc[0] == "displacement" and table.most_wrong.isna().iloc[1]
    assert table.most_wrong_error.iloc[0] == pytest.approx(100 * 0.004)
    assert "with Δt = 0.004 s (2500 steps, 12.5 µs), where displacement is wrong by 40\u00a0%." in answer(
        assessed, "energy", 0.01
    )
    assessed.error[:] = 0.1
    assert "wrong by" not in answer(assessed, "energy", 0.01)


def test_times_within_their_spreads_tie(assessed):
    assert study.recommend(assessed, error=0.01).ties_with_fastest.tolist() == [True, False]
    assessed.time_spread.loc[{"scheme": "average_acceleration"}] = 90e-6
    assert study.recommend(assessed, error=0.01).ties_with_fastest.tolist() == [True, True]


def test_a_name_stands_for_the_dataset_of_that_name(assessed, tmp_path):
    small_results.write_to(tmp_path)
    by_name = study.recommend("softening", error=0.1, quantity="energy", folder=tmp_path)
    pd.testing.assert_frame_equal(by_name, study.recommend(assessed, error=0.1, quantity="energy"))


@pytest.mark.parametrize(
    "arguments, error, sentence",
    [
        ({"quantity": "energi"}, KeyError, "the assessment has no quantity 'energi'; did you mean 'energy'?"),
        ({"error": 0.05}, ValueError, "error must be one that was assessed, 0.1, 0.01, not 0.05; assess"),
        ({"error": float("nan")}, ValueError, "error must be one that was assessed, 0.1, 0.01, not nan; assess"),
        ({"error": "0.1"}, TypeError, "error must be a number, not '0.1'."),
        ({"what": None}, TypeError, "recommend takes the dataset that study.assess returns, or the name"),
        ({"what": small_results.energy_error()}, ValueError, "recommend takes a dataset of study.assess."),
    ],
)
def test_mistakes_get_a_sentence(assessed, arguments, error, sentence):
    with pytest.raises(error) as caught:
        study.recommend(**{"what": assessed, "error": 0.01} | arguments)
    assert sentence in str(caught.value)
