"""Errors of steps under records of several spacings and spectra, as predicted from the power of each record."""

from fractions import Fraction
from typing import Any, ClassVar, NotRequired

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study import io
from study.algebra.arrays import Scalar
from study.analysis.record_error import record_error as predicted
from study.declaration.experiment import experiment, progress
from study.declaration.options import Count, Folder, RecordDuration, RecordPeriods, Schemes, Sizes, section
from study.experiments import coordinates
from study.marching.run import sweep
from study.mechanics.ground import GroundMotion
from study.observer.base import Reduction
from study.observer.peak import Peak
from study.problem.inelastic import DAMPING_RATIO, yielding_oscillator

#: Steps over the spacing of a record: first those that divide it, then those that pass over samples.
RATIOS = [Fraction(text) for text in "1/4 1/2 1 2/5 3/5 3/4 5/6 4/3 2 5/2 4".split()]
#: Smallest step in s, and largest step times the circular frequency of the oscillator.
SMALLEST, LARGEST = 0.002, 0.7
#: Largest distance from a sample, over the spacing, of the end of a step that counts as at the sample.
ON_A_SAMPLE = 1e-6
#: Schemes whose errors are predicted.
PREDICTED = ("average_acceleration", "central_difference")
#: Yield force that no motion reaches.
STRONG = 1e9


class _Shaking(eqx.Module):
    """The load of a unit mass on moving ground, with the exact displacement at the samples of the record.

    All lanes share the tables. A lane takes its ``row`` of the straight lines between the samples of all loads, which
    are ``spacing`` apart, and its ``motion`` of the exact displacements, which are ``known_spacing`` apart.
    """

    lines: jax.Array
    known: jax.Array
    row: Any
    spacing: Any
    motion: Any
    known_spacing: Any

    def __call__(self, t: Scalar) -> Scalar:
        place = t / self.spacing
        index = jnp.clip(place, 0, self.lines.shape[1] - 1).astype(int)
        at_zero, slope = self.lines[self.row.astype(int), index]
        return -(at_zero + slope * place)

    def error(self, t: Scalar, u: Scalar) -> Scalar:
        """Error of the displacement at a sample of the record; NaN at other times and after the record."""
        place = t / self.known_spacing
        nearest = jnp.round(place)
        within = jnp.clip(nearest, 0, self.known.shape[1] - 1)
        at_a_sample = (jnp.abs(place - nearest) < ON_A_SAMPLE) & (nearest == within)
        known = self.known[self.motion.astype(int), within.astype(int)]
        return jnp.where(at_a_sample, jnp.abs(u - known), jnp.nan)


class _ErrorAtSamples(Reduction):
    """Largest error of the displacement over the steps that end at a sample of the record."""

    variables: ClassVar = {"error_at_samples": {"long_name": "largest error of the displacement", "units": "m"}}

    def start(self, problem, state):
        return jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        return jnp.fmax(carried, problem.load.error(t, state.u))

    def result(self, carried, problem, state):
        return {"error_at_samples": carried}


def averaged(ground: GroundMotion, dt: float) -> np.ndarray:
    """Exact mean of the acceleration over the time ``dt`` about each multiple of ``dt``, at t = 0 over ``dt/2``."""
    a, spacing = np.asarray(ground.acceleration), float(ground.dt)
    at_samples = np.append(0.0, np.cumsum(spacing * (a[:-1] + a[1:]) / 2))

    def velocity(t):
        t = np.clip(t, 0.0, ground.duration)
        i = np.minimum((t / spacing).astype(int), len(a) - 2)
        within = t - i * spacing
        return at_samples[i] + a[i] * within + (a[i + 1] - a[i]) / spacing * within**2 / 2

    t = dt * np.arange(int(ground.duration / dt) + 2)
    return (velocity(t + dt / 2) - velocity(t - dt / 2)) / np.where(t > 0, dt, dt / 2)


def _above(ground: GroundMotion, frequency: float) -> float:
    """Root of the share of the power of the samples above a frequency in Hz."""
    power = np.abs(np.fft.rfft(ground.acceleration)) ** 2
    above = np.fft.rfftfreq(len(ground.acceleration), float(ground.dt)) > frequency
    return float(np.sqrt(power[above].sum() / power.sum()))


@section
class _RecordError(TypedDict):
    spacings: Sizes
    corners: Sizes
    kappas: Sizes
    seeds: Count
    duration: RecordDuration
    periods: RecordPeriods
    reduction: Count
    schemes: Schemes
    folder: NotRequired[Folder]


@experiment(
    "record_error",
    model=_RecordError,
    options=lambda configuration: {"schemes": configuration["record_error"]["schemes"]},
    reads=lambda options: ["reference/record_error"],
)
def record_error(schemes: Schemes) -> xr.Dataset:
    """Measure errors of steps under the records of ``reference/record_error``, and predict them without a run.

    The oscillators are linear and yielding, from the rest of the section. The steps divide the spacing of the record or
    pass over samples. Linear oscillators also run under the mean of the load over each step.

    Returns
    -------
    xarray.Dataset
        ``error`` of the displacement along time over the peak, at the samples of the record at which a step ends, with
        the dimension ``load``; ``peak_error`` of linear and yielding oscillators; ``period_error``, ``load_error`` and
        ``predicted_error``, the results of :func:`study.record_error`. All have the shape (scheme, record, period,
        ratio); steps that are too small or too large are NaN, as are predictions for schemes without one.
    """
    exact = io.open_dataset("reference/record_error")
    spacings, periods = exact.spacing.values, exact.period.values
    grounds = [GroundMotion(a[np.isfinite(a)], dt) for a, dt in zip(exact.ground.values, spacings, strict=True)]
    ratios = np.array([float(ratio) for ratio in RATIOS])
    sizes = ratios * spacings[:, None]
    progress("means of the records over steps")
    means = [
        # a step that is too small gets no row of samples, which would be the longest
        averaged(ground, dt) if dt >= SMALLEST * (1 - 1e-9) else np.zeros(2)
        for ground, step_sizes in zip(grounds, sizes, strict=True)
        for dt in step_sizes
    ]
    rows = [*(ground.acceleration for ground in grounds), *means]
    lines = np.zeros((len(rows), max(map(len, rows)), 2))
    for row, samples in zip(lines, rows, strict=True):
        # after the last sample the lines are zero
        slope = np.diff(samples)
        row[: len(slope), 0], row[: len(slope), 1] = samples[:-1] - np.arange(len(slope)) * slope, slope
    tables = jnp.asarray(lines), jnp.asarray(exact.u.values.reshape(-1, exact.sizes["sample"]))

    def problem(row, spacing, motion, known_spacing, period, yield_force):
        return yielding_oscillator(
            period, yield_force, load=_Shaking(*tables, row, spacing, motion, known_spacing), title="oscillator"
        )

    shape = (len(grounds), len(periods), len(RATIOS))
    record, period_number, ratio_number = np.indices(shape)
    dt = sizes[record, ratio_number]
    tried = (dt >= SMALLEST * (1 - 1e-9)) & (2 * np.pi * dt / periods[period_number] <= LARGEST)
    record, period_number, ratio_number, dt = (x[tried] for x in (record, period_number, ratio_number, dt))
    strength = exact.yield_force.values[record, period_number]
    kinds = {  # rows of the table, their spacings, and strengths
        "samples": (record, spacings[record], np.full(len(dt), STRONG)),
        "averages": (len(grounds) + record * len(RATIOS) + ratio_number, dt, np.full(len(dt), STRONG)),
        "yielding": (record, spacings[record], strength),
    }
    error, peak_error = np.full((len(schemes), *shape, 2), np.nan), np.full((len(schemes), *shape, 2), np.nan)
    terms = np.full((3, len(schemes), *shape), np.nan)
    for s, scheme in enumerate(schemes):
        progress(f"errors of {scheme}")
        over = {
            "row": np.concatenate([row for row, _, _ in kinds.values()]),
            "spacing": np.concatenate([spacing for _, spacing, _ in kinds.values()]),
            "yield_force": np.concatenate([force for _, _, force in kinds.values()]),
            "motion": np.tile(record * len(periods) + period_number, 3),
            "known_spacing": np.tile(spacings[record], 3),
            "period": np.tile(periods[period_number], 3),
        }
        duration = np.array([ground.duration for ground in grounds])[record]
        ds = sweep(
            problem,
            scheme,
            over=over,
            dt=np.tile(dt, 3),
            steps=np.tile(np.ceil(duration / dt - 1e-9).astype(int), 3),
            observe=[Peak(), _ErrorAtSamples()],
            bound=np.inf,  # the search for the default bound would scan every load
        )
        peak, largest = (ds[name].where(ds.status == 0).values.reshape(3, -1) for name in ("peak", "error_at_samples"))
        linear_peak, yielding_peak = exact.peak_drift.values[record, period_number].T
        error[s, tried] = (largest[:2] / linear_peak).T
        peak_error[s, tried] = np.abs([peak[0] / linear_peak - 1, peak[2] / yielding_peak - 1]).T
        if scheme in PREDICTED:
            for i, j in np.argwhere(tried.any(axis=1)):
                at = tried[i, :, j]
                terms[:, s, i, at, j] = predicted(grounds[i], sizes[i, j], periods[at], scheme=scheme)
    high = np.array(
        [[_above(ground, 1 / (4 * dt)) for dt in step_sizes] for ground, step_sizes in zip(grounds, sizes, strict=True)]
    )
    dims = ("scheme", "record", "period", "ratio")
    return xr.Dataset(
        {
            "error": (
                (*dims, "load"),
                error,
                {"long_name": "largest error of the displacement of the linear oscillator over its peak", "units": "1"},
            ),
            "peak_error": ((*dims, "spring"), peak_error, {"long_name": "relative error of the peak", "units": "1"}),
            "period_error": (dims, terms[0], {"long_name": "predicted error by the error of the period", "units": "1"}),
            "load_error": (dims, terms[1], {"long_name": "predicted error by the load passed over", "units": "1"}),
            "predicted_error": (dims, terms[2], {"long_name": "predicted error", "units": "1"}),
            "power_above": (
                ("record", "ratio"),
                high,
                {"long_name": "root of the share of the power of the record above 1/(4Δt)", "units": "1"},
            ),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "record": exact.record,
            "origin": exact.origin,
            "spacing": exact.spacing,
            "duration": (
                "record",
                [float(ground.duration) for ground in grounds],
                {"long_name": "duration of the record", "units": "s"},
            ),
            "damping_ratio": ((), DAMPING_RATIO, {"long_name": "damping ratio of small motions", "units": "1"}),
            "period": exact.period,
            "spring": exact.spring,
            "ratio": ("ratio", ratios, {"long_name": "step over the spacing of the record", "units": "1"}),
            "divides": (
                "ratio",
                [int(ratio.numerator == 1) for ratio in RATIOS],
                {"long_name": "1 if the step divides the spacing of the record", "units": "1"},
            ),
            "load": ("load", ["samples", "averages"], {"long_name": "load of a step"}),
            "step_size": (("record", "ratio"), sizes, {"long_name": "step", "units": "s"}),
        },
        attrs={"title": "Errors of steps under records, measured and predicted from the power of each record"},
    )
