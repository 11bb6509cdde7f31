"""The recommendation, on data whose errors and costs are known."""

import numpy as np
import pytest
import xarray as xr

import study
from study import io
from study.analysis.recommendation import candidates

STEPS = np.array([8, 16, 32, 64, 128])


def _beside(ds):
    """The errors from starts beside that of the data, which are the same."""
    return ds.expand_dims(start=["below", "above"])


@pytest.fixture
def data(monkeypatch):
    """A cheap scheme of order two and an expensive one of order four; errors grow with the length of the run."""
    steps = xr.DataArray(STEPS.astype(float), dims="steps_per_period")
    periods = xr.DataArray([1.0, 10.0, 100.0], dims="periods")
    errors = xr.concat([1.0 * steps**-2.0 * periods, 10.0 * steps**-4.0 * periods], "scheme").expand_dims(problem=1)
    errors = errors.transpose("problem", "scheme", "steps_per_period", "periods").assign_attrs(units="1")
    cost = xr.DataArray([10.0, 40.0], dims="scheme").expand_dims(problem=1, steps_per_period=5).copy()
    ds = xr.Dataset(
        {
            "max_trajectory_error": errors,
            "max_energy_error": (100 * errors).assign_attrs(units="percent"),
            "flagged": xr.zeros_like(errors, int).expand_dims(measure=2).copy(),
            "uncertainty": xr.zeros_like(errors[:, 0, 0]).expand_dims(measure=2).copy(),
            "newton_iterations": xr.zeros_like(errors) + 3 * STEPS[:, None] * periods.values,
            "median_time_per_step": cost,
            "spread_of_time_per_step": cost / 100,
        },
        {
            "problem": ["spring"],
            "scheme": ["houbolt", "rk4"],
            "steps_per_period": STEPS,
            "periods": [1, 10, 100],
            "measure": ["max_trajectory_error", "max_energy_error"],
            "forces_per_step": ("scheme", [1, 4]),
            "forces_per_iteration": ("scheme", [2, 0]),
        },
    )
    monkeypatch.setattr(io, "open_dataset", lambda name, folder: _beside(ds) if name == "neighbours" else ds)
    return ds


def test_the_steps_are_the_fewest_that_were_run_and_kept_the_error(data):
    # the power laws ask for 31.6 and 10 steps in a period
    table = study.recommend("spring", error=0.01, periods=10)
    assert table.index.tolist() == ["houbolt", "rk4"]
    assert table.steps_per_period.to_dict() == {"houbolt": 32, "rk4": 16}
    assert table.number_of_steps.to_dict() == {"houbolt": 320, "rk4": 160}
    assert table.error["houbolt"] == pytest.approx(10 / 32**2) and table.error["rk4"] == pytest.approx(100 / 16**4)
    assert table.time["houbolt"] == pytest.approx(10e-9 * 10 * 32)
    # those of the step, and of its three Newton iterations
    assert table.force_evaluations.to_dict() == {"houbolt": (1 + 2 * 3) * 320, "rk4": 4 * 160}
    assert table.verdict.tolist() == ["found", "found"]


def test_the_time_of_a_step_that_was_not_timed_is_that_of_the_nearest(data):
    timed = data.sel(steps_per_period=[8, 128]).copy(deep=True)
    timed.median_time_per_step.loc[{"steps_per_period": 128}] = 1e6
    table = candidates(data, _beside(data), timed, "spring", 0.01, "max_trajectory_error", 10)
    assert table.time["rk4"] == pytest.approx(40e-9 * 10 * 16)


def test_times_within_their_spreads_tie(data):
    assert study.recommend("spring", error=0.01, periods=10).ties_with_fastest.tolist() == [True, False]
    data.spread_of_time_per_step.loc[{"scheme": "rk4"}] = 40.0
    assert study.recommend("spring", error=0.01, periods=10).ties_with_fastest.tolist() == [True, True]


def test_percent_is_understood(data):
    same = study.recommend("spring", error=0.01, periods=10, quantity="max_energy_error")
    xr.testing.assert_allclose(
        same.drop(columns="verdict").to_xarray(),
        study.recommend("spring", error=0.01, periods=10).drop(columns="verdict").to_xarray(),
    )


def test_nothing_is_interpolated_or_extrapolated(data):
    assert study.recommend("spring", error=1e-5, periods=10).index.tolist() == ["rk4"]
    coarsest = study.recommend("spring", error=100.0, periods=10)
    assert coarsest.steps_per_period.tolist() == [8, 8] and set(coarsest.verdict) == {"already the coarsest step"}
    with pytest.raises(
        ValueError, match=r"no scheme keeps max_trajectory_error to 1e-09 over 10 .* the smallest error is 3.7e-07"
    ):
        study.recommend("spring", error=1e-9, periods=10)
    assert candidates(data, _beside(data), data, "spring", 1e-9, "max_trajectory_error", 10).empty
    with pytest.raises(ValueError, match="periods must be one of those that were run, 1, 10, 100, not 3"):
        study.recommend("spring", error=0.01, periods=3)


def test_flagged_errors_count_as_the_uncertainty_of_the_reference(data):
    data.flagged.loc[{"measure": "max_trajectory_error", "scheme": "rk4"}] = 1
    data.uncertainty.loc[{"measure": "max_trajectory_error"}] = 1e-3
    assert study.recommend("spring", error=0.02, periods=1).steps_per_period["rk4"] < 128
    assert "rk4" not in study.recommend("spring", error=0.009, periods=1).index


def test_missing_measures_are_reported(data):
    data.max_trajectory_error[:] = np.nan
    with pytest.raises(ValueError, match="max_trajectory_error is not measured over 10 periods"):
        study.recommend("spring", error=0.01, periods=10)


def test_an_error_that_falls_and_rises_again_counts_by_its_finer_steps(data):
    data.max_trajectory_error.loc[{"scheme": "houbolt", "steps_per_period": 8}] = 1e-9  # an accident of coarse steps
    data.max_trajectory_error.loc[{"scheme": "rk4", "steps_per_period": 16}] = np.nan  # a failure
    table = study.recommend("spring", error=0.01, periods=10)
    assert table.steps_per_period.to_dict() == {"houbolt": 32, "rk4": 32}


@pytest.mark.parametrize("error", [1.0, np.nan])
def test_a_step_must_keep_the_error_from_starts_beside_it_too(data, error):
    beside = _beside(data).copy(deep=True)
    beside.max_trajectory_error.loc[{"start": "above", "scheme": "houbolt", "steps_per_period": 32}] = error
    table = candidates(data, beside, data, "spring", 0.01, "max_trajectory_error", 10)
    assert table.steps_per_period.to_dict() == {"houbolt": 64, "rk4": 16}
    assert table.error["houbolt"] == pytest.approx(10 / 64**2)


@pytest.mark.parametrize(
    "arguments, error, sentence",
    [
        ({"what": "sprin"}, KeyError, "have no problem 'sprin'; did you mean 'spring'?"),
        ({"quantity": "max_energy"}, KeyError, "no quantity 'max_energy'; did you mean 'max_energy_error'?"),
        ({"error": 0.0}, ValueError, "error must be greater than zero, not 0.0."),
        ({"error": "0.1"}, TypeError, "error must be a number, not '0.1'."),
        ({"periods": True}, TypeError, "periods must be a number, not True."),
        ({"what": None}, TypeError, "recommend takes the name of a problem of the study, or the dataset"),
        ({"error": float("nan")}, ValueError, "error must be greater than zero, not nan."),
    ],
)
def test_mistakes_get_a_sentence(data, arguments, error, sentence):
    with pytest.raises(error) as caught:
        study.recommend(**({"what": "spring", "error": 0.01} | arguments))
    assert sentence in str(caught.value)
