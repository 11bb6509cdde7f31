"""``study.recommend``: the cheapest scheme for an allowed error."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from study import io
from study.registry import UnknownName, did_you_mean
from study.scheme.named import schemes

#: Datasets that tell what the schemes need on a problem of the study.
READS = ("work_precision", "accuracy", "neighbours")


def _fewest_steps(steps: np.ndarray, error: np.ndarray, allowed: float) -> int | None:
    """Place of the fewest steps per period from which on every run keeps the error; None if the finest does not."""
    above = np.flatnonzero(~(error <= allowed))  # a failed run, NaN, counts as above
    first = above[-1] + 1 if above.size else 0
    return int(first) if first < len(steps) else None


def _scale(error: xr.DataArray) -> float:
    """Size of a fraction of one in the units of the error."""
    return 100.0 if error.units == "percent" else 1.0


def _sizes(data: xr.Dataset, measure: str) -> xr.DataArray:
    """Sizes of the errors; those within ten times the uncertainty of the reference count as that large."""
    size = abs(data[measure])
    return size.where(
        data.flagged.sel(measure=measure) != 1, np.maximum(size, 10 * data.uncertainty.sel(measure=measure))
    )


def _with_ties(table: pd.DataFrame) -> pd.DataFrame:
    """The table by time, with a column that tells which times tie with the least: their interquartile ranges meet."""
    table = table.sort_values("time")
    slower_by = table["time"] - table["time"].iloc[:1].squeeze()
    ties = slower_by <= (table["time_spread"] + table["time_spread"].iloc[:1].squeeze()) / 2
    table.insert(table.columns.get_loc("time_spread") + 1, "ties_with_fastest", ties)
    return table


def candidates(
    accuracy: xr.Dataset,
    neighbours: xr.Dataset,
    work: xr.Dataset,
    problem: str,
    error: float,
    measure: str,
    periods: int,
) -> pd.DataFrame:
    """The table that :func:`recommend` returns, without rows if no scheme keeps the error.

    Parameters
    ----------
    accuracy, neighbours, work
        Datasets ``accuracy``, with the errors at every step that was tried, ``neighbours``, with those from starts
        beside it, and ``work_precision``, with the times.
    """
    runs = accuracy.sel({"problem": problem, "periods": periods})
    allowed, scale = error * _scale(accuracy[measure]), _scale(accuracy[measure])
    sizes = _sizes(runs, measure).transpose("scheme", "steps_per_period")
    beside = _sizes(neighbours.sel({"problem": problem, "periods": periods}), measure)
    # a failed run, NaN, is the worst
    worst = xr.concat([sizes, beside.max("start", skipna=False)], "start", join="inner").max("start", skipna=False)
    tried = runs.steps_per_period.values
    rows = {}
    for name in work.scheme.values:
        place = _fewest_steps(tried, worst.sel(scheme=name).values, allowed)
        if place is None:
            continue
        steps = int(tried[place])
        scheme = work.sel(problem=problem, scheme=name)
        timed = scheme.sel(steps_per_period=steps, method="nearest")
        iterations = runs.newton_iterations.sel(scheme=name, steps_per_period=steps).item()
        in_all = steps * periods
        rows[name] = {
            "steps_per_period": steps,
            "number_of_steps": in_all,
            "error": sizes.sel(scheme=name).values[place] / scale,
            "time": 1e-9 * timed.median_time_per_step.item() * in_all,
            "time_spread": 1e-9 * timed.spread_of_time_per_step.item() * in_all,
            "force_evaluations": scheme.forces_per_step.item() * in_all
            + scheme.forces_per_iteration.item() * iterations,
            "verdict": "found" if place else "already the coarsest step",
        }
    columns = ["steps_per_period", "number_of_steps", "error", "time", "time_spread", "force_evaluations", "verdict"]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=columns).rename_axis("scheme")
    return _with_ties(table)


def of_assessment(assessed: xr.Dataset, error: float, quantity: str | None = None) -> pd.DataFrame:
    """The table that :func:`recommend` returns for a dataset of :func:`study.assess`."""
    if "recommended_dt" not in assessed:
        raise ValueError("recommend takes the name of a problem of the study, or a dataset of study.assess.")
    known = assessed.quantity.values.tolist()
    quantity = known[0] if quantity is None else quantity
    if quantity not in known:
        raise UnknownName(f"the assessment has no quantity {quantity!r}; {did_you_mean(quantity, known)}")
    limits = assessed.allowed_error.values
    if not np.isclose(limits, error, rtol=1e-9, atol=0).any():
        raise ValueError(
            f"error must be one that was assessed, {', '.join(f'{one:g}' for one in limits)}, not {error:g}; assess "
            "with errors=[...] for others."
        )
    one = assessed.sel(quantity=quantity).sel(allowed_error=error, method="nearest")
    words = np.array([word.replace("_", " ") for word in one.verdict.flag_meanings.split()])
    steps = np.floor(assessed.attrs["duration"] / one.recommended_dt * (1 + 1e-9))
    table = pd.DataFrame(
        {
            "kind": one.kind,
            "step_size": one.recommended_dt,
            "omega_step": one.recommended_dt * assessed.highest_frequency.item(),
            "number_of_steps": steps,
            "error": one.recommended_error,
            "time": one.time,
            "time_spread": one.time_spread,
            "force_evaluations": one.force_evaluations,
            "forces_per_time": one.force_evaluations / (steps * one.recommended_dt),
            "steps_tried": one.steps_tried,
            "worst_error": one.worst_error,
            "verdict": words[one.verdict.values],
        },
        index=pd.Index(one.scheme.values, name="scheme"),
    )
    return _with_ties(table)


def of_the_study(problem: str, error: float, quantity: str, periods: float, folder: str | Path) -> pd.DataFrame:
    """The table that :func:`recommend` returns for a problem of the study."""
    work, accuracy, neighbours = (io.open_dataset(name, folder) for name in READS)
    for name, known in ((problem, neighbours.problem.values), (quantity, accuracy.measure.values)):
        if name not in known:
            kind = "problem" if name == problem else "quantity"
            raise UnknownName(f"the work-precision data have no {kind} {name!r}; {did_you_mean(str(name), known)}")
    lengths = neighbours.periods.values.tolist()
    if periods not in lengths:
        raise ValueError(f"periods must be one of those that were run, {', '.join(map(str, lengths))}, not {periods}.")
    if not error > 0:
        raise ValueError(f"error must be greater than zero, not {error}.")
    table = candidates(accuracy, neighbours, work, problem, error, quantity, int(periods))
    if table.empty:
        finest = _sizes(accuracy.sel(problem=problem, periods=periods).isel(steps_per_period=-1), quantity).values
        if np.isnan(finest).all():
            raise ValueError(f"{quantity} is not measured over {periods} periods, which are too short for it.")
        raise ValueError(
            f"no scheme keeps {quantity} to {error:g} over {periods:g} periods of '{problem}' with up to "
            f"{accuracy.steps_per_period.values[-1]} steps per period; the smallest error is "
            f"{np.nanmin(finest) / _scale(accuracy[quantity]):.1e}."
        )
    table.insert(0, "kind", ["explicit" if schemes[name].explicit else "implicit" for name in table.index])
    return table


def recommend(
    what: str | xr.Dataset,
    *,
    error: float,
    quantity: str | None = None,
    periods: float = 100,
    folder: str | Path = io.RESULTS,
) -> pd.DataFrame:
    """List the schemes that keep an error within a bound, the cheapest first.

    No number is interpolated: steps, errors and forces are those of runs. Of an assessment the step is one with two
    digits, or a whole part or multiple of the spacing of a record, that keeps the error as all random finer steps that
    :func:`study.assess` tried do, and from starts one percent below and above. For the name of a problem of the study
    the runs are those of the datasets ``accuracy``, ``neighbours`` and ``work_precision``, the step is the largest from
    which on every finer one of these keeps the error, and a scheme that misses the bound at the finest step is left
    out. A time is that of a step, measured at that or the nearest step size, times the number of steps.

    Parameters
    ----------
    what
        Dataset of :func:`study.assess`, or name of a problem of the study.
    error
        Largest allowed error as a fraction, also for errors in percent: 0.01 is one percent.
    quantity
        What must keep the error: a quantity of the assessment, by default the first; of a problem of the study an error
        of the dataset ``accuracy``, by default ``max_trajectory_error``.
    periods
        Length of the run in periods, one of those of the dataset ``neighbours``; only for a problem of the study.
    folder
        Folder of the results; only for a problem of the study.

    Returns
    -------
    pandas.DataFrame
        By ``scheme``, the fastest first; those of an assessment for which no step was found are last.

        ``kind``
            ``implicit`` or ``explicit``.
        ``step_size`` of an assessment, ``steps_per_period`` of a problem of the study
            The step, in s.
        ``omega_step``
            Δt·ω, with the highest circular frequency ω of small motions about any point of the reference's motion; of
            an assessment.
        ``number_of_steps``
            Steps of the run.
        ``error``
            Error at that step.
        ``time``, ``time_spread``
            Time of all steps in s and its interquartile range. A call of :func:`study.run` adds less than a
            millisecond.
        ``ties_with_fastest``
            Whether the interquartile ranges of this time and the least one meet.
        ``force_evaluations``
            Internal forces of the run.
        ``forces_per_time``
            Internal forces over the time that is run, in 1/s; of an assessment.
        ``steps_tried``, ``worst_error``
            Steps tried from a twentieth of the step up to it, all of which kept the error, and the largest error among
            them as a fraction of the allowed one; of an assessment.
        ``verdict``
            How the search for the step ended.

    Raises
    ------
    FileNotFoundError
        If the dataset does not exist; the message gives the command that makes it.
    KeyError
        If the dataset has no such problem or quantity.
    TypeError
        If an argument is no name or no number.
    ValueError
        If no scheme keeps the error, or no run has the length; the message states what was measured.

    Examples
    --------
    >>> study.recommend("hardening", error=0.01, periods=100).head(2)  # doctest: +SKIP
                   kind  steps_per_period  ...  force_evaluations verdict
    scheme                                 ...
    kahan_li8  explicit                10  ...            17000.0   found
    rk4        explicit                96  ...            38400.0   found
    """
    for name, number in (("error", error), ("periods", periods)):
        if isinstance(number, bool) or not isinstance(number, int | float | np.number):
            raise TypeError(f"{name} must be a number, not {number!r}.")
    if isinstance(what, xr.Dataset):
        return of_assessment(what, error, quantity)
    if not isinstance(what, str):
        raise TypeError(
            "recommend takes the name of a problem of the study, or the dataset that study.assess returns for a "
            f"problem of your own, not a {type(what).__name__}."
        )
    return of_the_study(what, error, quantity or "max_trajectory_error", periods, folder)
