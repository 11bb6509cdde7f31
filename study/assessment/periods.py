"""Slow periods and high frequencies of a problem, which set the scales of duration and steps."""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.jit import jit
from study.algebra.scalars import is_number
from study.assessment.solution import DenseSolution
from study.marching.run import sweep
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.mechanics.frequencies import frequencies, highest_frequency
from study.mechanics.loads import record_of
from study.warn import warn
from study.words import printed, span

#: Default duration of a free oscillation, in periods.
PERIODS = 10

#: Run from which the period is estimated: number of steps in the slowest period of small motions, and length of the run
#: in such periods.
ESTIMATE = 100, 40

#: Largest number of points of the motion at which the highest frequency is sought, and largest product of this number
#: and the square of the number of unknowns.
MOST_STIFFNESSES, MOST_ENTRIES = 4096, 2e8

#: Round-off of the real or imaginary part of a root, as a part of its size.
ROUND_OFF = 1e-9
#: Largest number of unknowns of a problem whose damping ratios are computed.
MOST_OF_DAMPING = 300


def periods_of(problem: Problem) -> np.ndarray | None:
    """Periods of small motions: about the start or about u = 0, where the slowest is shorter; None without any."""
    oscillating = []
    for state in (problem.u0, np.zeros(np.shape(problem.u0))):
        values = frequencies(problem, state)
        if values is not None and np.any(moving := (values > 0) & np.isfinite(values)):
            oscillating.append(2 * np.pi / values[moving])
    return min(oscillating, key=np.max, default=None)


def slowest_period(problem: Problem) -> float | None:
    """The slowest of :func:`periods_of`.

    If small motions oscillate about neither state, it is 2π √(max |u₀| / max |ü₀|), or None if u₀ or ü₀ is zero.
    """
    periods = periods_of(problem)
    if periods is None:  # for example, if the start and u = 0 are maxima of the potential
        pull = np.abs(np.asarray(acceleration(problem, 0.0, problem.u0, problem.v0))).max()
        far = np.abs(problem.u0).max()
        return 2 * np.pi * float(np.sqrt(far / pull)) if far > 0 and pull > 0 else None
    return float(periods.max())


def _period(problem: Problem) -> float | None:
    """Approximate period of a free undamped oscillator of one unknown; None for other problems or without a period."""
    slowest = slowest_period(problem)
    if np.ndim(problem.u0) or not problem.conservative or slowest is None:
        return None
    ds = sweep(problem, "rk4", dt=slowest / ESTIMATE[0], steps=ESTIMATE[0] * ESTIMATE[1])
    u = ds.u.values - (ds.u.max().item() + ds.u.min().item()) / 2
    crossed = np.flatnonzero((u[:-1] < 0) & (u[1:] >= 0))
    return float(np.diff(ds.t.values[crossed]).mean()) if len(crossed) > 1 else None


def has_a_period(problem: Problem, duration: float) -> bool:
    """Whether a free motion lasts for a period, with several unknowns for the slowest one of small motions."""
    period = slowest_period(problem) if np.ndim(problem.u0) else _period(problem)
    return period is not None and duration >= period


def length_of(problem: Problem, duration: float | None) -> float:
    """Duration of the runs in s: the given one, or by default ten periods of a free undamped oscillator.

    Raises
    ------
    ValueError
        If the given duration is not a positive time, or if none is given and the problem has no period.
    """
    if duration is not None:
        if not (is_number(duration) and 0 < duration < np.inf):
            raise ValueError(f"duration must be a time in seconds greater than zero, not {duration!r}.")
        return float(duration)
    period = _period(problem)
    if period is None:
        raise ValueError(f"'{problem.title}' has no period that gives the length of the runs: give a duration.")
    return PERIODS * period


@partial(jit, compiler=eqx.filter_jit)
def _rates(problem: Problem):
    """∂ü/∂u and ∂ü/∂u̇ at u₀ and at rest."""
    return jax.jacfwd(lambda u, v: acceleration(problem, 0.0, u, v), (0, 1))(
        jnp.asarray(problem.u0), jnp.zeros(np.shape(problem.u0))
    )


def _damping_ratios(problem: Problem) -> str:
    """The damping ratios of small motions about the start, −Re λ/|λ| of the complex roots λ, in words; may be empty."""
    if problem.damping is None and not problem.takes_velocity:
        return "no damping"
    n = np.size(problem.u0)
    if problem.massless or n > MOST_OF_DAMPING:
        return ""
    u_rates, v_rates = (np.asarray(rate, float).reshape(n, n) for rate in _rates(problem.untitled()))
    if not np.isfinite(u_rates).all() or not np.isfinite(v_rates).all():
        return ""
    roots = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [u_rates, v_rates]]))
    roots = roots[np.abs(roots.imag) > ROUND_OFF * np.abs(roots)]
    if not roots.size:
        return "no small motion oscillates"
    ratios = -roots.real / np.abs(roots)
    ratios[np.abs(ratios) < ROUND_OFF] = 0.0
    if not ratios.any():
        return "no damping of small motions"
    grows = ", and small motions with a negative one grow" if ratios.min() < 0 else ""
    return f"damping ratios {printed(span(ratios, '.3g'))}{grows}"


def model_of(problem: Problem, duration: float, spacing: float | None) -> list[str]:
    """The model in two lines: unknowns, periods and duration; damping ratios and record."""
    n = np.size(problem.u0)
    periods = periods_of(problem)
    unknowns = f"{n:,} unknown{'s' * (n > 1)}"
    if periods is None:
        first = f"{unknowns}, {duration:.4g} s"
    else:
        count = float(f"{duration / periods.max():.3g}")
        periods_in_words = f"period{'s' * (n > 1)} of small motion {span(periods, '.3g')} s"
        duration_in_words = f"{duration:.4g} s are {count:,g} periods{' of the slowest' * (n > 1)}"
        first = f"{unknowns}, {periods_in_words}, {duration_in_words}"
    record = record_of(problem.load).get("record", "record")
    excitation = "no load" if problem.load is None else "a load"
    record_in_words = excitation if spacing is None else f"{record} with a spacing of {spacing:.6g} s"
    return [first, "; ".join(part for part in (_damping_ratios(problem), record_in_words) if part)]


def remark_on_record(problem: Problem, spacing: float | None) -> list[str]:
    """A remark, in a list, with a warning, if the slowest period of small motion is below the spacing of a record."""
    periods = periods_of(problem)
    if spacing is None or periods is None or periods.max() >= spacing:
        return []
    remark = (
        f"the slowest period of small motion of '{problem.title}', {periods.max():.3g} s, is below the spacing of the "
        f"record, {spacing:.6g} s: check the units of mass and stiffness"
    )
    warn(f"{remark}.")
    return [remark]


def highest_frequency_along(problem: Problem, motion: DenseSolution) -> float:
    """Highest circular frequency of small motions about points of the motion, including its largest displacement."""
    last, unknowns = len(motion.t) - 1, np.size(problem.u0)
    places = np.linspace(0, last, int(np.clip(MOST_ENTRIES // unknowns**2, 2, MOST_STIFFNESSES))).astype(int)
    farthest = np.abs(motion.u).reshape(last + 1, -1).max(axis=1).argmax()
    return highest_frequency(problem, motion.u[np.unique([*places, farthest])])
