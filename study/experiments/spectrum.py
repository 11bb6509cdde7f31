"""The steps that schemes need for the peak drift of oscillators that yield under a record."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import FallingSizes, RecordDuration, RecordPeriods, Reductions, Schemes, Tolerance
from study.experiments import coordinates
from study.marching.run import run
from study.mechanics.ground import GroundMotion
from study.observer.motion import Quantity
from study.problem.inelastic import yielding_under_record
from study.scheme.named import schemes as schemes_by_name


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    runs = len(options["schemes"]) * len(options["periods"]) * len(options["reductions"])
    return runs * sum(options["duration"] / dt for dt in options["step_sizes"])


def _check(options: Options, configuration: Mapping) -> str | None:
    for dt in options["step_sizes"]:
        if abs(options["duration"] / dt - round(options["duration"] / dt)) > 1e-9:
            return f"step_sizes: {dt:g} s does not divide the duration of {options['duration']:g} s."
    return None


@experiment("spectrum", reads=lambda options: ["reference/spectrum"], check=_check, steps=_number_of_steps)
def spectrum(
    periods: RecordPeriods,
    reductions: Reductions,
    duration: RecordDuration,
    schemes: Schemes,
    step_sizes: FallingSizes,
    allowed_error: Tolerance,
) -> xr.Dataset:
    """Measure the error of the peak drift at each step, and the largest step that keeps it below the allowed one.

    The step and all finer ones must do so. The peak of a run is that of its steps. ``step_needed`` is NaN if not even
    the finest step is enough, or if a scheme takes its force from a potential. ``spacing`` is that of the record.
    """
    exact = io.open_dataset("reference/spectrum")
    lanes = xr.broadcast(xr.DataArray(step_sizes, dims="step_size"), exact.period, exact.yield_force)
    dt, period, strength = (lane.transpose("step_size", "period", "reduction").values.ravel() for lane in lanes)
    peak = Quantity(lambda u: u, name="drift", reduce="peak")
    shape = (len(schemes), len(step_sizes), len(periods), len(reductions))
    error = np.full(shape, np.nan)
    for s, scheme in enumerate(schemes):
        if schemes_by_name[scheme].refusal(yielding_under_record(1.0, 1.0)):
            continue
        progress(f"peak drifts by {scheme}")
        ds = run(
            yielding_under_record,
            scheme,
            over={"period": period, "yield_force": strength},
            dt=dt,
            steps=np.round(duration / dt).astype(int),
            observe=[peak],
            on_failure="ignore",
        )
        found = ds.drift.where(ds.status == 0).values.reshape(shape[1:])
        error[s] = np.abs(found / exact.peak_drift.values - 1)
    keeps = np.logical_and.accumulate((error <= allowed_error)[:, ::-1], axis=1)[:, ::-1]
    first = np.argmax(keeps, axis=1)
    needed = np.where(keeps.any(axis=1), np.array(step_sizes)[first], np.nan)
    dims = ("scheme", "step_size", "period", "reduction")
    return xr.Dataset(
        {
            "error": (dims, error, {"long_name": "relative error of the peak drift", "units": "1"}),
            "step_needed": ((dims[0], *dims[2:]), needed, {"long_name": "largest step within the error", "units": "s"}),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "step_size": ("step_size", step_sizes, {"long_name": "step", "units": "s"}),
            "period": exact.period,
            "reduction": exact.reduction,
            "ductility": exact.ductility,
            "spacing": ((), float(GroundMotion.el_centro().dt), {"long_name": "spacing of the record", "units": "s"}),
            "allowed_error": ((), allowed_error, {"long_name": "allowed error of the peak drift", "units": "1"}),
        },
        attrs={"title": "Steps that schemes need for the peak drift of yielding oscillators under a record"},
    )
