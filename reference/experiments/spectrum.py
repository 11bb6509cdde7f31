"""Peak drifts of oscillators that yield under records, for several periods and strengths."""

import numpy as np
import xarray as xr

from reference import bilinear
from study.declaration.experiment import experiment, progress
from study.declaration.options import RecordDuration, RecordPeriods, Records, Reductions
from study.problem.inelastic import ground_motions, yielding_under_record

#: Numbers of equal parts of the interval between two samples, in each of which events are sought. Peaks are computed
#: with both numbers. The difference of the two peaks gives the uncertainty.
PLACES = (5, 8)

#: Yield force that no motion reaches.
STRONG = 1e9


def _options(configuration) -> dict:
    return {key: configuration["spectrum"][key] for key in ("records", "periods", "reductions", "duration")}


@experiment("reference/spectrum", section="spectrum", options=_options)
def spectrum(records: Records, periods: RecordPeriods, reductions: Reductions, duration: RecordDuration) -> xr.Dataset:
    """Compute exact peak drifts for all records, periods and reductions of the strength.

    The strength is the yield force. It is the largest force of the elastic oscillator divided by the reduction. At a
    reduction of 1 no oscillator yields. Motions end at ``duration``. After the end of a shorter record, the ground
    acceleration is zero.
    """
    grounds = ground_motions(records)
    spacing = float(grounds[0].dt)
    t = spacing * np.arange(round(duration / spacing) + 1)
    ground = np.stack([np.interp(t, record.kinks, record.acceleration, right=0.0) for record in grounds])
    problems = [yielding_under_record(grounds[0], period, STRONG) for period in periods]
    springs = [problem.force for problem in problems]
    stiffness = np.tile([float(spring.stiffness) for spring in springs], records)  # type: ignore[attr-defined]
    damping = np.tile([float(problem.damping) for problem in problems], records)  # type: ignore[arg-type]
    hardening = float(springs[0].hardening)  # type: ignore[attr-defined]
    samples = np.repeat(ground, len(periods), axis=0)

    def peaks(strength, places):
        return bilinear.motions(samples, spacing, stiffness, damping, strength, hardening, places)[0]

    strong = np.full(len(stiffness), STRONG)
    elastic_forces = stiffness * peaks(strong, PLACES[0])
    strengths = [strong if reduction == 1 else elastic_forces / reduction for reduction in reductions]
    solutions = []
    for reduction, yield_forces in zip(reductions, strengths, strict=True):
        progress(f"peak drifts at a reduction of {reduction:g}")
        solutions.append([peaks(yield_forces, places) for places in PLACES])
    dims, shape = ("record", "period", "reduction"), (records, len(periods), len(reductions))
    peak, refined = (x.reshape(shape) for x in np.transpose(solutions, (1, 2, 0)))
    strength = np.transpose(strengths).reshape(shape)
    uncertainty = np.maximum(np.abs(peak - refined), np.spacing(peak))
    ductility = np.where(strength < STRONG, peak * stiffness.reshape(shape[:2])[..., None] / strength, 1.0)
    return xr.Dataset(
        {
            "peak_drift": (dims, peak, {"long_name": "peak drift", "units": "m"}),
            "peak_drift_uncertainty": (dims, uncertainty, {"long_name": "uncertainty of the peak drift", "units": "m"}),
            "yield_force": (dims, strength, {"long_name": "force at yield over the mass", "units": "m s-2"}),
            "ductility": (dims, ductility, {"long_name": "peak drift over the drift at yield", "units": "1"}),
            "ground": (("record", "t"), ground, {"long_name": "acceleration of the ground", "units": "m s-2"}),
        },
        coords={
            "record": ("record", [record.title for record in grounds], {"long_name": "record"}),
            "period": ("period", periods, {"long_name": "period of small motions", "units": "s"}),
            "reduction": ("reduction", reductions, {"long_name": "elastic force over strength", "units": "1"}),
            "t": ("t", t, {"long_name": "time", "units": "s"}),
        },
        attrs={"title": "Peak drift of yielding oscillators under El Centro, 1940, and stochastic records"},
    )
