"""Peak drifts of oscillators that yield under a record, over their periods and their strengths."""

import numpy as np
import scipy.interpolate
import xarray as xr

from reference import piecewise
from reference.solution import Solution
from study.declaration.experiment import experiment, progress
from study.declaration.options import RecordDuration, RecordPeriods, Reductions
from study.problem.inelastic import yielding_under_record

#: Times of the exact motion in a second, between which its peak is that of a cubic polynomial.
TIMES_PER_SECOND = 200

#: Spacings at which exact pieces look for events; the difference of the peaks is their uncertainty.
PLACES = (50, 83)

#: A force at which nothing yields.
STRONG = 1e9


def _peak(solution: Solution, t: np.ndarray) -> float:
    """Largest displacement in size, of the cubic polynomials through displacements and velocities from rest on."""
    times, u, v = (np.append(0.0, x) for x in (t, solution.u, solution.v))
    between = scipy.interpolate.CubicHermiteSpline(times, u, v)
    turns = between.derivative().roots(extrapolate=False)
    return float(np.abs(np.append(u, between(turns[np.isfinite(turns)]))).max())


def _options(configuration) -> dict:
    return {key: configuration["spectrum"][key] for key in ("periods", "reductions", "duration")}


@experiment("reference/spectrum", section="spectrum", options=_options)
def spectrum(periods: RecordPeriods, reductions: Reductions, duration: RecordDuration) -> xr.Dataset:
    """Compute exact peak drifts over periods and reductions of the strength.

    The strength is the largest force of the elastic oscillator divided by the reduction; at 1 nothing yields.
    """
    t = np.arange(1, round(duration * TIMES_PER_SECOND) + 1) / TIMES_PER_SECOND
    shape = (len(periods), len(reductions))
    peak, strength, uncertainty = np.empty(shape), np.empty(shape), np.empty(shape)
    for p, period in enumerate(periods):
        progress(f"peak drifts at a period of {period:g} s")
        stiffness = (2 * np.pi / period) ** 2
        of_elastic = _peak(piecewise.trajectory(yielding_under_record(period, STRONG), t), t)
        for r, reduction in enumerate(reductions):
            strength[p, r] = stiffness * of_elastic / reduction if reduction > 1 else STRONG
            problem = yielding_under_record(period, strength[p, r])
            one, other = (_peak(piecewise.trajectory(problem, t, places), t) for places in PLACES)
            peak[p, r], uncertainty[p, r] = one, max(abs(one - other), np.spacing(one))
    dims = ("period", "reduction")
    elastic = peak * (2 * np.pi / np.array(periods)[:, None]) ** 2
    ductility = np.where(strength < STRONG, elastic / strength, 1.0)
    return xr.Dataset(
        {
            "peak_drift": (dims, peak, {"long_name": "peak drift", "units": "m"}),
            "peak_drift_uncertainty": (dims, uncertainty, {"long_name": "uncertainty of the peak drift", "units": "m"}),
            "yield_force": (dims, strength, {"long_name": "force at yield over the mass", "units": "m s-2"}),
            "ductility": (dims, ductility, {"long_name": "peak drift over the drift at yield", "units": "1"}),
        },
        coords={
            "period": ("period", periods, {"long_name": "period of small motions", "units": "s"}),
            "reduction": (
                "reduction",
                reductions,
                {"long_name": "elastic force over strength", "units": "1"},
            ),
        },
        attrs={"title": "Peak drift of yielding oscillators under the record of El Centro, 1940"},
    )
