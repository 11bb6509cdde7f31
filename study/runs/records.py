"""Errors of the peak drift of oscillators that yield under records, at steps that divide the spacing and at others."""

from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import RecordDuration, RecordPeriods, Records, Reductions, Schemes, Size, Tolerance
from study.experiments import coordinates
from study.io import flags
from study.marching.result import COMPLETED, STATUSES_OR_NOT_RUN
from study.marching.run import sweep
from study.mechanics.ground import GroundMotion
from study.observer.diagnostics import Evaluations
from study.observer.peak import Peak
from study.problem.inelastic import DAMPING_RATIO, SPACING, yielding_under_record
from study.runs.needs import COSTS
from study.runs.schema import described
from study.scheme.named import schemes as schemes_by_name
from study.sizes import largest_size
from study.words import percent

#: Largest ratio of neighbouring step sizes of the grid.
RATIO = 1.2
#: Numbers of steps in the spacing of a record that are tried, and numbers of spacings in a step.
DIVIDING = (1, 2, 3, 4, 5, 8, 10, 20, 40)
NOT_RUN = STATUSES_OR_NOT_RUN.index("not_run")


def steps_tried(coarsest: float, finest: float) -> tuple[np.ndarray, np.ndarray]:
    """Descending step sizes, and whether each is commensurate with the record.

    Commensurate step sizes are fractions and multiples of the spacing of the record's samples by the numbers in
    ``DIVIDING``. They are merged with a grid of step sizes in a constant ratio.
    """
    whole = np.array(DIVIDING, float)
    commensurate = np.append(SPACING / whole, SPACING * whole[1:])
    commensurate = commensurate[(commensurate >= finest * (1 - 1e-9)) & (commensurate <= coarsest * (1 + 1e-9))]
    grid = np.geomspace(coarsest, finest, int(np.ceil(np.log(coarsest / finest) / np.log(RATIO))) + 1)
    grid = grid[~np.isclose(grid[:, None], commensurate).any(axis=1)]
    steps = np.sort(np.append(commensurate, grid))[::-1]
    return steps, np.isin(steps, commensurate)


def _counts(duration: float, steps: np.ndarray) -> np.ndarray:
    """Number of steps of each size after which a run reaches or passes the duration."""
    return np.ceil(duration / steps - 1e-9).astype(int)


def _check(options: Options, configuration: Mapping) -> str | None:
    if options["finest"] >= options["coarsest"]:
        return f"finest: {options['finest']:g} s must be less than the coarsest step, {options['coarsest']:g} s."
    return None


def as_runs(spectrum: xr.Dataset, uncertainty: float) -> xr.Dataset:
    """The runs in the form of ``runs/PROBLEM``, over the duration of the records.

    ``uncertainty`` is the largest relative one of the exact peak drifts.

    The error of the peak drift is the largest over all periods and ratios of elastic force to strength. The first
    record takes the place of the problem's own start, and the others those of other starts. Counts are the means over
    all runs, and the status is that of a run that failed, if one did.
    """
    each, scale, dt = ["record", "period", "reduction"], spectrum.period.min().item(), spectrum.step_size.values
    duration = spectrum.duration.item() / scale
    status = spectrum.status.max(each).drop_attrs().reset_coords(drop=True)
    by_record = spectrum.peak_drift_error.max(each[1:], skipna=False).expand_dims(quantity=["peak drift"])
    largest = by_record.fillna(np.inf).max("record").where(status != NOT_RUN)
    steps = spectrum.duration / spectrum.step_size
    ds = xr.Dataset({name: spectrum[f"{name}_per_step"].mean(each) * steps for name in COSTS})
    ds = ds.assign(error=by_record.isel(record=0, drop=True), largest_error=largest, status=status)
    ds = ds.reset_coords(drop=True).expand_dims(periods=[duration]).assign(tried=(status != NOT_RUN).astype(np.int8))
    ds = ds.assign(uncertainty=("quantity", [uncertainty]))
    ds = ds.rename(step_size="size").drop_vars("size").drop_attrs()
    return described(
        ds.assign_coords(
            step_size=("size", dt), steps_per_period=("size", scale / dt), proposed=("size", np.ones(len(dt), np.int8))
        ),
        "largest relative error of the peak drift over all oscillators",
        time_scale=scale,
        time_scale_name="shortest period",
        decided=duration,
        highest_frequency=2 * np.pi / scale,
        spacing=spectrum.spacing.item(),
        free_vibration=0,
        has_kinks=1,
        unknowns=1,
        starts=int(np.prod([spectrum.sizes[name] for name in each])),
        problem="records",
        problem_title=f"oscillators of {scale:g} to {spectrum.period.max().item():g} s with "
        f"{percent(spectrum.damping_ratio.item())} damping under records",
    ).assign_attrs(reference="motions by pieces that are exact for linear accelerations")


@experiment("spectrum", "runs/records", reads=lambda options: ["reference/spectrum"], check=_check)
def spectrum(
    records: Records,
    periods: RecordPeriods,
    reductions: Reductions,
    duration: RecordDuration,
    schemes: Schemes,
    coarsest: Size,
    finest: Size,
    allowed_error: Tolerance,
) -> tuple[xr.Dataset, xr.Dataset]:
    """Measure the error of the peak drift for each step size, and the largest step size that keeps the allowed error.

    ``runs/records`` has the largest errors over all oscillators in the form of the runs of other problems.
    ``largest_step_size`` is the largest step size that keeps the allowed error, as all smaller step sizes do. It is
    given among all step sizes tried, and among the step sizes commensurate with the record. It is NaN if not even the
    smallest step size is enough, or if a scheme refuses the oscillators, for instance because it takes its force from a
    potential. A run ends with the step that reaches or passes the duration. After the duration the ground acceleration
    is zero.
    """
    exact = io.open_dataset("reference/spectrum")
    table: Any = jnp.asarray(exact.ground.values)

    def problem(record, period, yield_force):
        return yielding_under_record(GroundMotion(table[record.astype(int)], SPACING), period, yield_force)

    steps, commensurate = steps_tried(coarsest, finest)
    step_size = xr.DataArray(steps, dims="step_size", attrs={"long_name": "step", "units": "s"})
    number = xr.DataArray(np.arange(records), dims="record")
    dims = ("step_size", "record", "period", "reduction")
    lanes = xr.broadcast(step_size, number, exact.period, exact.yield_force)
    dt, record, period, strength = (lane.transpose(*dims).values.ravel() for lane in lanes)
    error = np.full((len(schemes), len(steps), *exact.peak_drift.shape), np.nan)
    status = np.full(error.shape, NOT_RUN, np.int8)
    counts = {name: np.full(error.shape, np.nan) for name in Evaluations.variables}
    for s, scheme in enumerate(schemes):
        if schemes_by_name[scheme].refusal(yielding_under_record(GroundMotion.el_centro(), 1.0, 1.0)):
            continue
        progress(f"peak drifts by {scheme}")
        ds = sweep(
            problem,
            scheme,
            over={"record": record, "period": period, "yield_force": strength},
            dt=dt,
            steps=_counts(duration, dt),
            observe=[Peak(), Evaluations()],
        )
        status[s] = ds.status.values.reshape(error.shape[1:])
        peaks = ds.peak.where(ds.status == COMPLETED).values.reshape(error.shape[1:])
        error[s] = np.abs(peaks / exact.peak_drift.values - 1)
        for name, values in counts.items():
            values[s] = (ds[name].values / _counts(duration, dt)).reshape(peaks.shape)
    error_attributes = {"long_name": "relative error of the peak drift, at the steps and between them", "units": "1"}
    runs = xr.Dataset(
        {
            "peak_drift_error": (("scheme", *dims), error, error_attributes),
            "status": (("scheme", *dims), status, flags("how the run ended", STATUSES_OR_NOT_RUN, np.int8)),
            **{
                f"{name}_per_step": (
                    ("scheme", *dims),
                    values,
                    {"long_name": f"{Evaluations.variables[name]['long_name']} per step", "units": "1"},
                )
                for name, values in counts.items()
            },
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "step_size": step_size,
            "divides": (
                "step_size",
                commensurate.astype(int),
                {
                    "long_name": "1 if the step is an integer fraction or multiple of the spacing of the records",
                    "units": "1",
                },
            ),
            "record": exact.record,
            "period": exact.period,
            "reduction": exact.reduction,
            "ductility": exact.ductility,
            "duration": ((), duration, {"long_name": "duration of the runs", "units": "s"}),
            "damping_ratio": ((), DAMPING_RATIO, {"long_name": "ratio of damping to critical damping", "units": "1"}),
            "spacing": ((), SPACING, {"long_name": "spacing of the record", "units": "s"}),
            "allowed_error": ((), allowed_error, {"long_name": "allowed error of the peak drift", "units": "1"}),
        },
        attrs={"title": "Steps that schemes need for the peak drift of yielding oscillators under records"},
    )
    kept = runs.peak_drift_error <= allowed_error
    needed = [largest_size(some, "step_size") for some in (kept, kept[:, commensurate])]
    condition = xr.IndexVariable("condition", ["any_step", "practice"], {"long_name": "condition on the steps"})
    size = {"long_name": "largest step that keeps the error, as all finer ones do", "units": "s"}
    largest = xr.concat(needed, condition)
    return runs.assign(largest_step_size=largest.where(largest > 0).assign_attrs(size)), as_runs(
        runs, (exact.peak_drift_uncertainty / exact.peak_drift).max().item()
    )
