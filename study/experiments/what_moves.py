"""Collapse, drift and residual drift of a yielding mass with P-Δ: by step, by damping, by strength and by record."""

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jax import lax

from study.algebra.arrays import Scalar
from study.declaration.experiment import experiment, progress
from study.declaration.options import Count, Length, RecordDuration, RecordPeriods, SchemeName, Size
from study.marching.run import sweep
from study.materials import Elastoplastic, elastoplastic
from study.mechanics.definition import Problem
from study.observer.base import Reduction
from study.observer.peak import Peak
from study.problem.records import point_source

#: Ratio of the stiffness after yield to the elastic one, and the part of the elastic stiffness that P-Δ takes away.
HARDENING, P_DELTA = 0.02, 0.06
#: Displacement over that at yield beyond which the static force pushes the mass away: the collapse.
COLLAPSE = (1 - HARDENING) / (P_DELTA - HARDENING)
#: Intensities tried before bisection, as elastic force over strength. A mass that collapses may survive a larger
#: intensity. Between fewer intensities so many first collapses are missed that medians change by more than one percent.
TRIED = np.geomspace(1.5, 40.0, 40)
#: Number of bisections between the first intensity tried that leads to collapse and the one before.
BISECTIONS = 7
#: Ranges of the corner frequency in Hz and of the decay κ in s, from which each record draws its own.
CORNERS, KAPPAS = (0.1, 1.0), (0.01, 0.06)


class Variant(NamedTuple):
    """What differs from the reference: step over the spacing of the records, damping ratio, and factor of strength.

    A ratio of zero stands for the step of the reference.
    """

    title: str
    ratio: float = 0.0
    damping: float = 0.05
    strength: float = 1.0


#: Variants by name; the first is the reference.
VARIANTS = {
    "reference": Variant("reference"),
    "spacing": Variant("step 1 spacing", 1.0),
    "off": Variant("step 1⅓ spacings", 4 / 3),
    "two": Variant("step 2 spacings", 2.0),
    "four": Variant("step 4 spacings", 4.0),
    "damping": Variant("damping 3.5 %", damping=0.035),
    "strength": Variant("strength −10 %", strength=0.9),
}


class _Residual(Reduction):
    """Displacement at which the mass rests after the run, over the plastic displacement at its end."""

    variables: ClassVar = {"residual": {"long_name": "residual drift", "units": "m"}}

    def start(self, problem, state):
        return jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        return (1 - HARDENING) / (1 - P_DELTA) * state.history

    def result(self, carried, problem, state):
        return {"residual": jnp.abs(carried)}


class _Record(eqx.Module):
    """Load of a unit mass on moving ground; all lanes share the samples of all records."""

    samples: jax.Array
    spacing: float
    record: Any
    scale: Any

    def __call__(self, t: Scalar) -> Scalar:
        place = t / self.spacing
        last = self.samples.shape[1] - 2
        before = jnp.floor(jnp.clip(place, 0, last))
        at = self.record.astype(int), before.astype(int)
        start, end = lax.dynamic_slice(self.samples, at, (1, 2))[0].astype(float)
        return -self.scale * jnp.where(place < last + 1, start + (place - before) * (end - start), 0.0)


class _WithWeight(eqx.Module):
    """The force of a spring, less the P-Δ effect of the weight."""

    spring: Elastoplastic

    @property
    def history(self) -> Any:
        return self.spring.history

    def __call__(self, u, v, history):
        p, history = self.spring(u, v, history)
        return p - P_DELTA * self.spring.stiffness * u, history


class _Oscillators:
    """Runs of the oscillators under all records, with strength 1 N per kg of mass and records of unit intensity."""

    def __init__(self, scheme: str, accelerations: np.ndarray, spacing: float):
        # in single precision the table of the full study is small enough for XLA to compile a march as one native loop
        samples, self.scheme, self.spacing = jnp.asarray(accelerations, jnp.float32), scheme, spacing
        self.duration, self.runs = spacing * (samples.shape[1] - 1), 0

        def problem(record, scale, period, damping, strength):
            frequency = 2 * jnp.pi / period
            spring = elastoplastic(stiffness=frequency**2, yield_force=strength, hardening=HARDENING)
            return Problem(
                _WithWeight(spring),
                0.0,
                damping=2 * damping * frequency,
                load=_Record(samples, spacing, record, scale),
                title="yielding oscillator with P-Δ",
            )

        self.problem = problem

    def run(self, dt: np.ndarray, **over: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Peak and residual drift, NaN where the run failed; all arguments are arrays of one shape."""
        shape = dt.shape
        ds = sweep(
            self.problem,
            self.scheme,
            over={name: value.ravel() for name, value in over.items()},
            dt=dt.ravel(),
            steps=np.ceil(self.duration / dt.ravel() - 1e-9).astype(int),
            observe=[Peak(), _Residual()],
            bound=np.inf,  # motions grow after a collapse
        )
        self.runs += dt.size
        completed = ds.status == 0
        return tuple(ds[name].where(completed).values.reshape(shape) for name in ("peak", "residual"))  # type: ignore[return-value]


def _collapse_intensity(collapses: Callable, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """First intensity tried at which the mass collapses, refined by bisection, and the number of failed runs.

    ``collapses`` is a function of intensities of shape (..., *shape) that returns 1, 0, or NaN for a failed run. The
    intensity is NaN where a run failed up to the first collapse, or nothing collapses.
    """
    collapsed = collapses(np.broadcast_to(TRIED.reshape(-1, *[1] * len(shape)), (len(TRIED), *shape)))
    failed = np.isnan(collapsed).sum(axis=0)
    first = (collapsed != 0).argmax(axis=0)  # a failed run ends the search, as a collapse does
    bracketed = (np.take_along_axis(collapsed, first[None], axis=0)[0] == 1) & (first > 0)
    low, high = np.where(bracketed, TRIED[first - 1], np.nan), np.where(bracketed, TRIED[first], np.nan)
    for _ in range(BISECTIONS):
        middle = np.sqrt(low * high)
        at_middle = collapses(np.where(np.isfinite(middle), middle, TRIED[0]))
        failed = failed + (np.isnan(at_middle) & np.isfinite(middle))
        low, high = np.where(at_middle == 1, low, middle), np.where(at_middle == 1, middle, high)
        low = np.where(np.isnan(at_middle), np.nan, low)
    return np.sqrt(low * high), failed


@experiment("what_moves")
def what_moves(
    scheme: SchemeName,
    records: Length,
    spacing: Size,
    duration: RecordDuration,
    periods: RecordPeriods,
    intensity: Size,
    parts: Count,
) -> xr.Dataset:
    """Measure the effect of step, damping, strength and record on collapse intensity, peak drift and residual drift.

    The oscillator has a unit mass, an elastoplastic spring, damping and the P-Δ effect of its weight. Every stochastic
    record has its own corner frequency and decay. Its intensity is the peak force of the elastic oscillator with 5 %
    damping, over the strength of the reference. The collapse intensity is the least one tried at which the displacement
    passes the point where the static force vanishes, refined by bisection. Drifts are those at ``intensity``.

    Parameters
    ----------
    parts
        Number of steps of the reference in the spacing of the records.

    Returns
    -------
    xarray.Dataset
        ``collapse_intensity``, ``peak_drift`` and ``residual_drift`` of shape (variant, period, record), NaN where a
        run failed; a drift is infinite after a collapse. ``failed`` counts failed runs, which are no collapses.
    """
    random = np.random.default_rng(records)
    corners = CORNERS[0] * (CORNERS[1] / CORNERS[0]) ** random.random(records)
    kappas = random.uniform(*KAPPAS, records)
    grounds = [
        point_source(10_000 + n, spacing, corner, kappa, duration)
        for n, (corner, kappa) in enumerate(zip(corners, kappas, strict=True))
    ]
    oscillators = _Oscillators(scheme, np.stack([ground.acceleration for ground in grounds]), spacing)
    shape = (len(VARIANTS), len(periods), records)
    variant_index, period_index, record = np.indices(shape)
    ratio = np.array([variant.ratio or 1 / parts for variant in VARIANTS.values()])[variant_index]
    damping, strength = (
        np.array([getattr(variant, name) for variant in VARIANTS.values()])[variant_index]
        for name in ("damping", "strength")
    )
    period = np.asarray(periods, float)[period_index]
    progress("intensities of the records")
    strong = {"record": record[0].astype(float), "scale": np.ones(shape[1:]), "period": period[0]}
    elastic, _ = oscillators.run(
        np.full(shape[1:], spacing / parts), **strong, damping=damping[0], strength=np.full(shape[1:], 1e9)
    )
    unit = 1 / ((2 * np.pi / period[0]) ** 2 * elastic)  # scale of a record of unit intensity

    def drifts(intensities):
        lanes = {
            "record": record.astype(float),
            "scale": intensities * unit,
            "period": period,
            "damping": damping,
            "strength": strength,
        }
        dt, *values = np.broadcast_arrays(ratio * spacing, *lanes.values())
        return oscillators.run(dt, **dict(zip(lanes, values, strict=True)))

    at_collapse = COLLAPSE * strength / (2 * np.pi / period) ** 2

    def collapses(intensities):
        peak, _ = drifts(intensities)
        return np.where(np.isnan(peak), np.nan, peak > at_collapse)

    progress("collapse intensities")
    collapse, failed = _collapse_intensity(collapses, shape)
    progress("drifts")
    peak, residual = drifts(np.full(shape, intensity))
    failed = failed + np.isnan(peak)
    collapsed = peak > at_collapse
    dims = ("variant", "period", "record")
    names = ("collapse_intensity", "peak_drift", "residual_drift")
    titles = ("elastic force over strength at collapse", "peak drift", "residual drift")
    values = (collapse, np.where(collapsed, np.inf, peak), np.where(collapsed, np.inf, residual))
    return xr.Dataset(
        {
            name: (dims, value, {"long_name": title, "units": "1" if name == names[0] else "m"})
            for name, title, value in zip(names, titles, values, strict=True)
        }
        | {
            "failed": (dims, failed, {"long_name": "number of failed runs", "units": "1"}),
            "runs": ((), oscillators.runs, {"long_name": "number of runs", "units": "1"}),
        },
        coords={
            "variant": ("variant", list(VARIANTS), {"long_name": "what differs from the reference"}),
            "variant_title": ("variant", [variant.title for variant in VARIANTS.values()], {"long_name": "title"}),
            "ratio": (
                "variant",
                [variant.ratio or 1 / parts for variant in VARIANTS.values()],
                {"long_name": "step over the spacing of the records", "units": "1"},
            ),
            "period": ("period", periods, {"long_name": "period of small motions", "units": "s"}),
            "record": ("record", [ground.title for ground in grounds], {"long_name": "record"}),
            "scheme": ((), scheme, {"long_name": "time integration scheme"}),
            "spacing": ((), spacing, {"long_name": "time between two samples of the records", "units": "s"}),
            "intensity": ((), intensity, {"long_name": "elastic force over strength of the drifts", "units": "1"}),
            "parts": ((), parts, {"long_name": "steps of the reference in the spacing of the records", "units": "1"}),
            "hardening": ((), HARDENING, {"long_name": "stiffness after yield over the elastic one", "units": "1"}),
            "p_delta": ((), P_DELTA, {"long_name": "loss of stiffness by P-Δ over the elastic one", "units": "1"}),
            "collapse": ((), COLLAPSE, {"long_name": "displacement at collapse over that at yield", "units": "1"}),
        },
        attrs={"title": "Collapse, drift and residual drift by step, damping, strength and record"},
    )
