"""``study.recommend``: the cheapest scheme for an allowed error."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from study import datasets
from study.registry import UnknownName, did_you_mean


def _needed_steps(steps: np.ndarray, error: np.ndarray, allowed: float) -> float:
    """Fewest steps per period from which on the error stays within the allowed one; NaN if the data reach none.

    Between two step sizes, the logarithm of the error is interpolated linearly in that of the step.
    """
    above = np.flatnonzero(~(error <= allowed))  # a failed run, NaN, counts as above
    if not above.size:
        return steps[0]
    last = above[-1]
    if last == len(steps) - 1:
        return np.nan
    if not np.isfinite(error[last]) or error[last + 1] == 0:
        return steps[last + 1]
    between = np.log(allowed / error[last]) / np.log(error[last + 1] / error[last])
    return float(np.exp(np.interp(between, [0, 1], np.log(steps[last : last + 2]))))


def _over_periods(errors: xr.DataArray, periods: float) -> xr.DataArray:
    """Errors after ``periods`` periods; between measured lengths, logarithms are interpolated linearly."""
    lengths = errors.periods.values
    if periods in lengths:
        return errors.sel(periods=periods)
    upper = np.searchsorted(lengths, periods)
    part = np.log(periods / lengths[upper - 1]) / np.log(lengths[upper] / lengths[upper - 1])
    before, after = errors.isel(periods=upper - 1, drop=True), errors.isel(periods=upper, drop=True)
    return np.exp((1 - part) * np.log(before) + part * np.log(after))


def _scale(error: xr.DataArray) -> float:
    """Size of a fraction of one in the units of the error."""
    return 100.0 if error.units == "percent" else 1.0


def _sizes(data: xr.Dataset, measure: str) -> xr.DataArray:
    """Sizes of the errors; those within ten times the uncertainty of the reference count as that large."""
    size = abs(data[measure])
    return size.where(
        data.flagged.sel(measure=measure) != 1, np.maximum(size, 10 * data.uncertainty.sel(measure=measure))
    )


def candidates(data: xr.Dataset, problem: str, error: float, measure: str, periods: float) -> pd.DataFrame:
    """The table that :func:`recommend` returns, without rows if no scheme keeps the error."""
    one = data.sel(problem=problem)
    allowed = error * _scale(one[measure])
    sizes = _over_periods(_sizes(one, measure), periods).transpose("scheme", "steps_per_period").values
    steps = one.steps_per_period.values
    costs = [
        one[name].transpose("scheme", "steps_per_period").values
        for name in ("median_time_per_step", "force_evaluations_per_step")
    ]
    rows = {}
    for s, scheme in enumerate(one.scheme.values):
        needed = _needed_steps(steps, sizes[s], allowed)
        nanoseconds, forces = (np.interp(needed, steps, cost[s]) for cost in costs)
        rows[scheme] = {
            "steps_per_period": needed,
            "time": 1e-9 * nanoseconds * needed * periods,
            "force_evaluations": forces * needed * periods,
        }
    columns = ["steps_per_period", "time", "force_evaluations"]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
    return table.rename_axis("scheme").dropna().sort_values("time")


def of_assessment(assessed: xr.Dataset, error: float, quantity: str | None = None) -> pd.DataFrame:
    """The table that :func:`recommend` returns for a dataset of :func:`study.assess`."""
    if "recommended_dt" not in assessed:
        raise ValueError("recommend takes the name of a problem of the study, or a dataset of study.assess.")
    known = assessed.quantity.values.tolist()
    quantity = known[0] if quantity is None else quantity
    if quantity not in known:
        raise UnknownName(f"the assessment has no quantity {quantity!r}; {did_you_mean(quantity, known)}")
    limits = assessed.allowed_error.values
    if not np.any(limits <= error):
        raise ValueError(
            f"error must be one that was assessed, {', '.join(f'{one:g}' for one in limits)}, or larger, not "
            f"{error:g}; assess with errors=[...] for smaller ones."
        )
    one = assessed.sel(quantity=quantity, allowed_error=limits[limits <= error].max())
    words = np.array([word.replace("_", " ") for word in one.verdict.flag_meanings.split()])
    table = pd.DataFrame(
        {
            "dt": one.recommended_dt,
            "steps": np.round(assessed.attrs["duration"] / one.recommended_dt),
            "error": one.recommended_error,
            "time": one.time,
            "time_spread": one.time_spread,
            "force_evaluations": one.force_evaluations,
            "verdict": words[one.verdict.values],
        },
        index=pd.Index(one.scheme.values, name="scheme"),
    ).sort_values("time")
    fastest = table.iloc[0]
    slower_by = table["time"] - fastest["time"]
    table.insert(4, "ties_with_fastest", slower_by <= table["time_spread"] + fastest["time_spread"])
    return table


def recommend(
    what: str | xr.Dataset,
    *,
    error: float,
    quantity: str | None = None,
    measure: str = "max_trajectory_error",
    periods: float = 100,
    folder: str | Path = datasets.RESULTS,
) -> pd.DataFrame:
    """List the schemes that keep an error within a bound, the cheapest first.

    For a dataset of :func:`study.assess`, all steps and times are those of runs. For the name of a problem of the
    study, the dataset ``work_precision`` is interpolated in the step size and in the length of the run, and never
    extrapolated: a scheme that misses the bound at the finest step of the dataset is left out, and one that keeps it at
    the coarsest is listed with that.

    Parameters
    ----------
    what
        Dataset of :func:`study.assess`, or name of a problem in the dataset ``work_precision``.
    error
        Largest allowed error as a fraction, also for measures in percent: 0.01 is one percent.
    quantity
        Quantity of the assessment that must keep the error, by default the first.
    measure
        Measure of error, a variable of the dataset ``work_precision``.
    periods
        Length of the run in periods.
    folder
        Folder of the results.

    Returns
    -------
    pandas.DataFrame
        By ``scheme``. Of an assessment: ``dt``, ``steps``, the ``error`` at that step, ``time`` of the run in seconds
        with its spread, ``ties_with_fastest`` where the times differ by no more than their spreads,
        ``force_evaluations`` and ``verdict``; schemes for which no step was found are last. Of a problem of the study:
        ``steps_per_period``, ``time`` of all steps in seconds (a call of :func:`study.run` adds about a
        millisecond) and ``force_evaluations`` in them.

    Raises
    ------
    FileNotFoundError
        If the dataset does not exist; the message gives the command that makes it.
    KeyError
        If the dataset has no such problem or measure.
    TypeError
        If an argument is no name or no number.
    ValueError
        If error or length are out of the measured range, which the message states.

    Examples
    --------
    >>> study.recommend("hardening", error=0.01, periods=100).head(2)  # doctest: +SKIP
                     steps_per_period      time  force_evaluations
    scheme
    mclachlan4              12.917079  0.000051        6458.539738
    extrapolation12          8.000000  0.000099       17600.000000
    """
    for name, number in (("error", error), ("periods", periods)):
        if isinstance(number, bool) or not isinstance(number, int | float | np.number):
            raise TypeError(f"{name} must be a number, not {number!r}.")
    if isinstance(what, xr.Dataset):
        return of_assessment(what, error, quantity)
    if not isinstance(what, str):
        raise TypeError(
            "recommend takes the name of a problem of the study, or the dataset that study.assess returns for a "
            f"problem of your own, not {what!r}."
        )
    problem = what
    data = datasets.open("work_precision", folder)
    for name, known in ((problem, data.problem.values), (measure, data.measure.values)):
        if name not in known:
            kind = "problem" if name == problem else "measure of error"
            raise UnknownName(f"the work-precision data have no {kind} {name!r}; {did_you_mean(str(name), known)}")
    lengths = data.periods.values
    if not lengths.min() <= periods <= lengths.max():
        raise ValueError(f"periods must be within what was run, {lengths.min()} to {lengths.max()}, not {periods}.")
    if not error > 0:
        raise ValueError(f"error must be greater than zero, not {error}.")
    table = candidates(data, problem, error, measure, periods)
    if table.empty:
        finest = _over_periods(_sizes(data.sel(problem=problem).isel(steps_per_period=-1), measure), periods).values
        if np.isnan(finest).all():
            raise ValueError(f"{measure} is not measured over {periods} periods, which are too short for it.")
        raise ValueError(
            f"no scheme keeps {measure} to {error:g} over {periods:g} periods of '{problem}' with up to "
            f"{data.steps_per_period.values[-1]} steps per period; the smallest error is "
            f"{np.nanmin(finest) / _scale(data[measure]):.1e}."
        )
    return table
