"""The steps that schemes need for the peak drift of oscillators that yield under records."""

from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import RecordDuration, RecordPeriods, Records, Reductions, Schemes, Size, Tolerance
from study.experiments import coordinates
from study.marching.run import sweep
from study.mechanics.ground import GroundMotion
from study.observer.diagnostics import Evaluations
from study.observer.peak import Peak
from study.problem.inelastic import SPACING, yielding_under_record
from study.scheme.named import schemes as schemes_by_name

#: Largest ratio of neighbouring step sizes of the grid.
RATIO = 1.2
#: Numbers of steps in the spacing of a record that are tried, and numbers of spacings in a step.
DIVIDING = (1, 2, 3, 4, 5, 8, 10, 20, 40)


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


def _needed(error: xr.DataArray, allowed: float) -> xr.DataArray:
    """Largest step size that keeps the allowed error, as all smaller step sizes do; NaN if the smallest does not."""
    kept = error.sortby("step_size") <= allowed
    kept = kept.copy(data=np.logical_and.accumulate(kept.values, axis=kept.get_axis_num("step_size")))
    return kept.step_size.where(kept).max("step_size")


@experiment("spectrum", reads=lambda options: ["reference/spectrum"], check=_check)
def spectrum(
    records: Records,
    periods: RecordPeriods,
    reductions: Reductions,
    duration: RecordDuration,
    schemes: Schemes,
    coarsest: Size,
    finest: Size,
    allowed_error: Tolerance,
) -> xr.Dataset:
    """Measure the error of the peak drift for each step size, and the largest step size that keeps the allowed error.

    ``step_needed`` is the largest step size that keeps the allowed error, as all smaller step sizes do. It is given
    among all step sizes tried, and among the step sizes commensurate with the record. It is NaN if not even the
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
        found = ds.peak.where(ds.status == 0).values.reshape(error.shape[1:])
        error[s] = np.abs(found / exact.peak_drift.values - 1)
        for name, values in counts.items():
            values[s] = (ds[name].values / _counts(duration, dt)).reshape(found.shape)
    of_error = {"long_name": "relative error of the peak drift, at the steps and between them", "units": "1"}
    of_runs = xr.Dataset(
        {
            "error": (("scheme", *dims), error, of_error),
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
            "commensurate": (
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
            "spacing": ((), SPACING, {"long_name": "spacing of the record", "units": "s"}),
            "allowed_error": ((), allowed_error, {"long_name": "allowed error of the peak drift", "units": "1"}),
        },
        attrs={"title": "Steps that schemes need for the peak drift of yielding oscillators under records"},
    )
    needed = [_needed(some, allowed_error) for some in (of_runs.error, of_runs.error[:, commensurate])]
    tried = xr.IndexVariable("tried", ["all", "commensurate"], {"long_name": "steps tried"})
    size = {"long_name": "largest step that keeps the error, as all finer ones do", "units": "s"}
    return of_runs.assign(step_needed=xr.concat(needed, tried).assign_attrs(size))
