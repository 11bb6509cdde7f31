"""``study.recommend``: the cheapest scheme for an allowed error."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from study import io
from study.algebra.scalars import is_number
from study.registry import UnknownName, did_you_mean


def recommend(
    what: str | xr.Dataset, *, error: float, quantity: str | None = None, folder: str | Path = io.RESULTS
) -> pd.DataFrame:
    """List the schemes of an assessment, the fastest first, with the step size at which each keeps an allowed error.

    No number is interpolated: step sizes, errors and numbers of force evaluations are taken from runs. A recommended
    step size has two digits; with a record of ground motion it is an integer fraction or multiple of the time between
    samples. All smaller step sizes that :func:`study.assess` tried keep the error too. Except for a program or more
    than 1,000 unknowns, the recommended step size also keeps the error if initial values and load are one percent
    smaller or larger.

    Parameters
    ----------
    what
        Dataset of :func:`study.assess`, or the name of an assessment in the section ``assess`` of the configuration.
        The study has the assessments ``hardening`` and ``softening``, each over a hundred periods.
    error
        Allowed error, as a fraction of the largest value of the quantity: 0.01 is one percent. It must be one of the
        errors that were assessed.
    quantity
        Quantity of the assessment that must keep the error. The default is its first quantity, which is
        ``displacement`` if the assessment was given no quantities.
    folder
        Folder of the results, which contains the dataset of a named assessment.

    Returns
    -------
    pandas.DataFrame
        One row for each ``scheme``, the fastest first; schemes without a recommended step size are last.

        ``kind``
            ``implicit`` or ``explicit``; ``unknown`` for a program's own scheme.
        ``step_size``
            The recommended step size, in s.
        ``largest_step``
            The largest step size tried that keeps the error with a margin for scatter, in s. All smaller step sizes
            tried keep the error. ``step_size`` is this value, rounded down.
        ``omega_step``
            Δt·ω, with the highest circular frequency ω of small motions about points of the reference's motion.
        ``number_of_steps``
            Number of steps of the run with this step size.
        ``error``
            Error of this run.
        ``most_wrong``, ``most_wrong_error``
            The quantity with the largest error in this run, and its error. A run may keep the energy although its
            displacement is wrong.
        ``time``, ``time_spread``
            Computing time of all steps of this run, and its interquartile range, in s. A call of
            :func:`study.run` adds less than a millisecond.
        ``ties_with_fastest``
            Whether this time exceeds the shortest time by at most the mean of both interquartile ranges.
        ``force_evaluations``
            Number of internal forces evaluated in this run.
        ``forces_per_time``
            Number of internal forces evaluated per second of simulated time, in 1/s.
        ``steps_tried``, ``worst_error``
            Number of step sizes tried between a twentieth of ``step_size`` and ``step_size``, which all keep the error.
            ``worst_error`` is the largest error among these runs, as a fraction of the allowed error.
        ``verdict``
            How the search for the step size ended.
        ``tolerance``, ``controlled_force_evaluations``, ``control_over_equal``
            Only if the assessment had a controller: the tolerance that keeps the error, the number of internal forces
            evaluated in the run with this tolerance, and the ratio of this number to ``force_evaluations``. If the
            ratio is below one, controlled steps are cheaper.

    Raises
    ------
    FileNotFoundError
        If there is no dataset of that name; the message gives the command that makes it.
    KeyError
        If the assessment has no such quantity.
    TypeError, ValueError
        If an argument is invalid, or the error is not one that was assessed.

    Examples
    --------
    >>> study.recommend("hardening", error=0.01, quantity="displacement").head(2)  # doctest: +SKIP
                   kind  step_size  ...  worst_error verdict
    scheme                          ...
    kahan_li8  explicit     0.0120  ...          0.9   found
    rk4        explicit     0.0014  ...          0.9   found
    """
    if not is_number(error):
        raise TypeError(f"error must be a number, not {error!r}.")
    if not isinstance(what, str | xr.Dataset):
        raise TypeError(
            "recommend takes the dataset that study.assess returns, or the name of an assessment in the configuration, "
            f"not a {type(what).__name__}."
        )
    assessed = io.open_dataset(f"assessment/{what}", folder) if isinstance(what, str) else what
    if "recommended_dt" not in assessed:
        raise ValueError("recommend takes a dataset of study.assess.")
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
    found = one.recommended_dt.dropna("scheme").reset_coords(drop=True)
    errors = assessed.error.sel(scheme=found.scheme, dt=found).to_pandas()
    table = pd.DataFrame(
        {
            "kind": one.kind,
            "step_size": one.recommended_dt,
            "largest_step": one.largest_dt,
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
    ).sort_values("time")
    if "tolerance" in assessed:
        table["tolerance"] = one.tolerance.to_series()
        table["controlled_force_evaluations"] = one.controlled_force_evaluations.to_series()
        table["control_over_equal"] = table["controlled_force_evaluations"] / table["force_evaluations"]
    table.insert(table.columns.get_loc("error") + 1, "most_wrong", errors.idxmax(axis=1))
    table.insert(table.columns.get_loc("most_wrong") + 1, "most_wrong_error", errors.max(axis=1))
    slower_by = table["time"] - table["time"].iloc[0]
    ties = slower_by <= (table["time_spread"] + table["time_spread"].iloc[0]) / 2
    table.insert(table.columns.get_loc("time_spread") + 1, "ties_with_fastest", ties)
    return table
