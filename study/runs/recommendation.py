"""``study.recommend``: the cheapest schemes for an allowed error."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from study import io
from study.algebra.scalars import is_number
from study.analysis.duration import FREE, round_down, round_up, step_exponent, step_over
from study.analysis.recommendation import Recommended, chosen, over_duration, table_of_assessment
from study.registry import UnknownName, did_you_mean
from study.runs.needs import MOTION, NO_VALUE, UNCERTAIN, ranked
from study.words import listed, percent, step_with_unit


def recommend(
    what: str | xr.Dataset,
    *,
    allowed_error: float,
    quantity: str | None = None,
    duration: float | None = None,
    folder: str | Path = io.RESULTS,
) -> pd.DataFrame:
    r"""List the schemes of an assessment, the fastest first, with the step size at which each keeps an allowed error.

    For a problem of the study, the answer is that of the datasets ``needs`` and ``decisions``: the first scheme of
    each kind is the decision, with the fewest evaluations of the force, or with the shortest computing time for 100
    and more unknowns. Unless ``duration`` exceeds that of the runs, no number is interpolated or extrapolated: step
    sizes, errors and numbers of force evaluations are taken from runs. A recommended step size has two digits, or
    for a problem of the study the number of steps in a period; with a record of ground motion the step size is an
    integer fraction or multiple of the time between samples. All smaller step sizes that were tried keep the error
    too, on problems of the study with a record those that divide the spacing. The recommended step size also keeps
    the error from other starts: on problems of the study those of ``needs``, which the notes count, otherwise, except
    for a program or more than 1,000 unknowns, with initial values and load one percent smaller or larger.

    Parameters
    ----------
    what
        Dataset of :func:`study.assess`, its file, ``NAME.nc``, or a name: of an assessment in the section ``assess`` of
        the configuration, of a file ``NAME.nc`` in ``folder`` or in the present folder, or of a problem of the dataset
        ``needs``, such as ``softening`` or ``records``. Fewer schemes of ``needs`` are compared by giving it with them,
        those of OpenSees, Abaqus and LS-DYNA as ``needs.sel(problem="softening", scheme=needs.in_codes == 1)``.
    allowed_error
        Allowed error as a fraction, 0.01 for one percent, of the value that the coordinate ``relative_to`` of the
        assessment states. It must be one of the errors that were assessed.
    quantity
        Quantity that must keep the error. The default is the first quantity of the assessment, which is
        ``displacement`` if the assessment was given no quantities. For a problem of the study it is the displacement,
        or the peak drift under records.
    duration
        Duration in s over which the error must be kept, by default that of the runs. A shorter one keeps the step for
        a quantity along time from the time on at which its largest value is reached, to which errors are relative; for
        others it is refused. Over a longer duration the step follows from that of the runs by the law

        .. math::

            \Delta t(n) = \Delta t(n_0)\,(n_0/n)^a

        with the number n of periods and the order p of the scheme. For the motion, a = 1/p if the scheme keeps the
        energy, as symplectic, symmetric and conserving schemes do. If it dissipates, a is the larger of 1/p and 2/q
        with its order of loss q. For the energy, a = 0 or 1/q. No run confirms such a step, and the verdict
        is ``extrapolated``. If the errors of period and energy of a scheme that dissipates cancel over the runs, the
        longer run may have twice the allowed error. The law holds for free vibration without damping, load, memory and
        kinks that is not chaotic.
    folder
        Folder of the results, which contains the dataset of a named assessment, and ``needs.nc``.

    Returns
    -------
    pandas.DataFrame
        One row for each ``scheme``, the fastest first; schemes without a recommended step size are last. Schemes whose
        times differ by less than their spread are ordered by the number of internal forces, or of steps if forces are
        not counted. The printed table begins with the answer in words. Printed step sizes are never rounded up.

        ``kind``
            ``implicit`` or ``explicit``; ``unknown`` for a program's own scheme.
        ``step_size``
            The recommended step size, in s.
        ``largest_step_size``
            The largest step size tried that keeps the error with a margin for scatter, in s. All smaller step sizes
            tried keep the error. ``step_size`` is this value, rounded down.
        ``omega_step``
            Δt·ω, with the highest circular frequency ω of small motions about points of the reference's motion.
        ``steps``
            Number of steps of the run with this step size.
        ``error``
            Error of this run.
        ``most_wrong``, ``most_wrong_error``
            The quantity with the largest error in this run, and its error. A run may keep the energy although its
            displacement is wrong.
        ``seconds``, ``seconds_spread``
            Computing time of all steps of this run, and its interquartile range, in s. A call of
            :func:`study.run` adds less than a millisecond.
        ``ties_with_fastest``
            Whether this time exceeds the shortest time by at most the mean of both interquartile ranges, so that the
            times do not decide which scheme is faster.
        ``force_evaluations``
            Number of internal forces evaluated in this run.
        ``force_evaluations_per_time``
            Number of internal forces evaluated per second of simulated time, in 1/s.
        ``steps_tried``, ``largest_error``
            Number of step sizes tried between a twentieth of ``step_size`` and ``step_size``, which all keep the error,
            and the largest error among these runs. For a problem of the study, the number of all step sizes tried up to
            ``step_size``, and the largest error of the recommended one from all starts.
        ``verdict``
            How the search for the step size ended.
        ``tolerance``, ``controlled_force_evaluations``, ``control_over_equal``
            Only if the assessment had a controller: the tolerance that keeps the error, the number of internal forces
            evaluated in the run with this tolerance, without a trial run, and the ratio of this number to
            ``force_evaluations``. If the ratio is below one, controlled steps are cheaper.

        For a problem of the study, the rows are those of ``needs`` with steps that divide the spacing of a record, kind
        by kind, and in each kind the cheapest scheme first. The columns are ``kind``, ``step_size``, ``omega_step``,
        ``steps_per_period``, ``error``, ``force_evaluations_per_time``, ``steps_tried``, ``largest_error`` and
        ``verdict``, and ``seconds_per_time``, the computing time over simulated time, if it decides the order.

        Over a longer duration than that of the runs, the columns are ``kind``, ``step_size``, ``omega_step``,
        ``steps``, ``force_evaluations``, ``exponent`` a, ``step_size_of_runs``, the step size that was run, and
        ``verdict``. The scheme with the fewest evaluations is first.

    Raises
    ------
    FileNotFoundError
        If there is no dataset of that name; the message gives the command that makes it.
    KeyError
        If the assessment has no such quantity.
    TypeError, ValueError
        If an argument is invalid, a name is that of a problem and of a file, ``allowed_error`` is not one that was
        assessed, or ``duration`` exceeds that of the runs and the law does not hold for the problem.

    Examples
    --------
    >>> study.recommend("softening", allowed_error=0.01)[["kind", "steps_per_period"]]  # doctest: +SKIP
    """
    if not is_number(allowed_error):
        raise TypeError(f"allowed_error must be a number, not {allowed_error!r}.")
    if not isinstance(what, str | xr.Dataset):
        raise TypeError(
            "recommend takes the dataset that study.assess returns, or the name of an assessment in the configuration, "
            f"not {type(what).__name__}: {what!r}."
        )
    if not isinstance(quantity, str | None):
        raise TypeError(f"quantity must be a name, not {quantity!r}.")
    if duration is not None and not (is_number(duration) and 0 < duration < np.inf):
        raise ValueError(f"duration must be a positive number of seconds, not {duration!r}.")
    dataset = _opened(what, Path(folder)) if isinstance(what, str) else what
    if {"problem", "condition"} <= {*dataset.dims}:
        raise ValueError(
            "the dataset has the needs of all problems: give the name of one, of "
            f"{listed(map(str, dataset.problem.values))}."
        )
    if "condition" in dataset.dims:
        table, known = _table_of_needs(dataset, allowed_error, quantity), dataset.duration.item()
        free = bool(dataset.free_vibration)
        scaled_from = dataset.time_scale.item() if free else np.nan
    else:
        table, known = table_of_assessment(dataset, allowed_error, quantity), dataset.attrs["duration"]
        free = bool(dataset.attrs.get("free_vibration")) and known == dataset.attrs["duration_requested"]
        # assessments of earlier versions lack it
        known_from = dataset.get("scaled_from", xr.full_like(dataset.quantity, np.nan, float))
        scaled_from = known_from.sel(quantity=table.attrs["quantity"]).item()
    if duration is None or duration == known or scaled_from <= duration < known:
        return table
    quantity, schemes = table.attrs["quantity"], dataset.scheme_title.to_series()
    if duration < known:
        raise ValueError(
            f"the runs last {known:.4g} s, and their errors of '{quantity}' do not bound those of a run of "
            f"{duration:.4g} s: assess the problem with this duration."
        )
    if not free or np.isnan(scaled_from):
        raise ValueError(
            f"the runs last {known:.4g} s, and steps are extrapolated to {duration:.4g} s only for quantities along "
            f"time and for runs of at least a period of {FREE} that is not chaotic: assess the problem with this "
            "duration."
        )
    if "condition" in dataset.dims:
        law = dataset.exponent.sel(quantity=quantity).to_series()
        finer = (duration / known) ** dataset.exponent
        longer = dataset.assign({name: dataset[name] * finer for name in ("force_evaluations", "seconds")})
        table = table.loc[_table_of_needs(longer, allowed_error, quantity).index]
        scale = dataset.time_scale.item()
        steps = [
            scale / round_up(scale / step_over(step, law[name], known, duration)) if step > 0 else np.nan
            for name, step in table.step_size.items()
        ]
        order = np.arange(len(steps))
    else:
        orders = zip(dataset.order.values, dataset.order_of_loss.values, strict=True)
        law = pd.Series([step_exponent(p, q, quantity) for p, q in orders], schemes.index)
        steps = [
            round_down(step_over(step, law[name], known, duration)) if step > 0 else np.nan
            for name, step in table.step_size.items()
        ]
        forces = (table.force_evaluations_per_time * table.step_size).to_numpy() / steps
        order = np.argsort(forces, kind="stable")  # schemes without a step are last
    step_size = pd.Series(steps, table.index).iloc[order]
    return over_duration(table, schemes, law, step_size, allowed_error, known, duration)


def _opened(name: str, folder: Path) -> xr.Dataset:
    """The dataset that a name or a file stands for: an assessment, or else the needs on a problem of the study."""
    if name.endswith(".nc"):
        for file in (Path(name), folder / name):
            if file.exists():
                return io.read(file)
        raise FileNotFoundError(f"there is no file '{name}'; `study assess --output {name}` writes it.")
    if (configured := folder / "assessment" / f"{name}.nc").exists():
        return io.read(configured)
    assessment = next(filter(Path.exists, [folder / f"{name}.nc", Path(f"{name}.nc")]), None)
    if assessment and not (folder / "needs.nc").exists():
        return io.read(assessment)
    needed = io.open_dataset("needs", folder)
    is_problem = name in needed.problem.values
    if assessment and is_problem:
        raise ValueError(
            f"{name!r} is a problem of the study and the file '{assessment}'. Give '{assessment}' for the file, or "
            f"study.open_dataset('needs').sel(problem={name!r}) for the problem."
        )
    if assessment:
        return io.read(assessment)
    if is_problem:
        return needed.sel(problem=name)
    raise UnknownName(
        f"there is no assessment and no problem {name!r} in '{folder}'; "
        f"{did_you_mean(name, needed.problem.values.tolist())}"
    )


def _table_of_needs(needed: xr.Dataset, error: float, quantity: str | None) -> pd.DataFrame:
    """The table for a problem of the study, from its needs over (scheme, quantity, allowed_error, condition)."""
    needed = needed.sel(condition="practice")
    if (needed.verdict == UNCERTAIN).all():
        raise ValueError(f"no scheme has a step on the {needed.problem_title.item()}: no reference is certain enough.")
    has = (needed.verdict != NO_VALUE).any(["scheme", "allowed_error"])
    known = sorted(needed.quantity.values[has.values].tolist(), key=lambda name: name not in MOTION)
    if not known:
        raise ValueError(f"no scheme can be run on the {needed.problem_title.item()}.")
    quantity, ordered = chosen(needed, known, error, quantity)
    best = ranked(ordered)
    ordered = ordered.sel(scheme=[*best, *(name for name in ordered.scheme.values if name not in best)])
    words = np.array([word.replace("_", " ") for word in needed.verdict.flag_meanings.split()])
    table = Recommended(
        {
            "kind": np.where(ordered.explicit == 1, "explicit", "implicit"),
            "step_size": ordered.step_size,
            "omega_step": ordered.omega_step,
            "steps_per_period": ordered.steps_per_period,
            "error": ordered.error,
            "force_evaluations_per_time": ordered.force_evaluations / ordered.duration,
            "steps_tried": ordered.smaller_steps + 1,
            "largest_error": ordered.largest_error,
            **({"seconds_per_time": ordered.seconds / ordered.duration} if ordered.cost == "seconds" else {}),
            "verdict": words[ordered.verdict.values],
        },
        index=pd.Index(ordered.scheme.values, name="scheme"),
    )
    firsts = table.loc[best].groupby("kind", sort=False).head(1)
    titles = ordered.scheme_title.to_series()
    answer = [
        f"{percent(error)} of {quantity}, {row.kind}: {titles[name]}, {step_with_unit(row.step_size)}"
        for name, row in firsts.iterrows()
    ]
    starts = ordered.starts.item()
    table.attrs = {
        "quantity": quantity,
        "answer": answer or [f"{percent(error)} of {quantity}: no scheme was found"],
        "notes": [
            f"Runs on the {ordered.problem_title.item()} last {ordered.decided.item():g} times "
            f"{ordered.time_scale.item():.4g} s, "
            f"from {f'{starts:.0f} starts' if starts > 1 else 'one start'}. "
            f"{'Computing times' if ordered.cost.item() == 'seconds' else 'Evaluations of the force'} decide "
            "the order of all schemes that were run, also of those that few programs have."
        ],
    }
    return table
