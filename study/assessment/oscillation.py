"""Period, phase and amplitude of free oscillations, as quantities of an assessment."""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr

from study.algebra.jit import jit
from study.assessment.solution import DenseSolution
from study.mechanics.definition import Problem
from study.observer.base import Reduction
from study.observer.errors import AmplitudeDecay, PeriodError

#: Variables of a run that hold the errors of the quantities, by the quantity's name.
QUANTITIES = {"period": "period_elongation", "phase": "phase_error", "amplitude": "amplitude_decay"}

#: Long names of the quantities.
TITLES = {
    name: (PeriodError.variables | AmplitudeDecay.variables)[variable]["long_name"]
    for name, variable in QUANTITIES.items()
}

#: Values to which the errors of the quantities are relative, in words.
RELATIVE_TO = {
    "period": "relative to the period",
    "phase": "delays at the end in periods",
    "amplitude": "losses of amplitude in an oscillation",
}

#: Fewest upward crossings of a reference whose period, phase and amplitude are assessed.
FEWEST = 3


class Oscillation(eqx.Module):
    """The reference of a free oscillation, from which errors of period, phase and amplitude are measured.

    Attributes
    ----------
    period
        Mean time between upward crossings of ``level``.
    level, rest
        Mean of the largest and the smallest displacement, and displacement of equilibrium.
    crossing
        Time of the first upward crossing, in periods.
    crossings
        Number of upward crossings.
    """

    # arrays, because other values of an array need no compilation
    period: jax.Array
    level: jax.Array
    rest: jax.Array
    crossing: jax.Array
    crossings: jax.Array

    def observers(self, dt: jax.Array) -> tuple[PeriodError, AmplitudeDecay]:
        """Observers of a run with the step ``dt``."""
        return PeriodError(self.level, self.crossing, self.period / dt, dt), AmplitudeDecay(self.rest, dt)


class OscillationErrors(Reduction):
    """Errors of period, phase and amplitude in runs with different step sizes."""

    oscillation: Oscillation

    needs_equal_steps = True
    variables = PeriodError.variables | AmplitudeDecay.variables

    def start(self, problem, state):
        dt = jnp.full((), jnp.nan)
        return dt, tuple(observer.start(problem, state) for observer in self.oscillation.observers(dt))

    def update(self, carried, problem, state, t, effort):
        dt, inner = carried
        dt = jnp.where(jnp.isnan(dt), t, dt)  # the step size is the time at which the first step ends
        pairs = zip(self.oscillation.observers(dt), inner, strict=True)
        return dt, tuple(observer.update(c, problem, state, t, effort) for observer, c in pairs)

    def result(self, carried, problem, state):
        dt, inner = carried
        pairs = zip(self.oscillation.observers(dt), inner, strict=True)
        return {name: x for observer, c in pairs for name, x in observer.result(c, problem, state).items()}


def _upward_crossings(solution: DenseSolution, level: float) -> np.ndarray:
    """Times at which the displacement crosses a level upwards, on the interpolant."""
    from scipy.optimize import brentq  # imported here, because the import is slow

    u = solution.u
    places = np.flatnonzero((u[:-1] < level) & (u[1:] >= level))
    return np.array(
        [
            brentq(lambda t: float(solution.at(np.array([t]))[0][0]) - level, *solution.t[[i, i + 1]], xtol=1e-15)
            for i in places
        ]
    )


@partial(jit, compiler=eqx.filter_jit)
def _force(problem: Problem, u):
    return problem.static_force(u)


def oscillation(problem: Problem, solution: DenseSolution) -> Oscillation | None:
    """The oscillation of a solution, or None.

    It is None if the problem has several unknowns, if its energy is not constant, if the solution crosses the mean of
    its extremes upwards fewer than three times, or if no equilibrium lies between the extremes.
    """
    if np.ndim(problem.u0) or not problem.conservative:
        return None
    from scipy.optimize import brentq

    low, high = solution.u.min(), solution.u.max()
    level = float(low + high) / 2
    times = _upward_crossings(solution, level)

    def force(u):
        return float(_force(problem, np.float64(u)))

    ends = force(low), force(high)
    if len(times) < FEWEST or not ends[0] < 0 < ends[1]:
        return None
    period = float((times[-1] - times[0]) / (len(times) - 1))
    rest = brentq(force, low, high, xtol=1e-14)
    return Oscillation(*map(jnp.asarray, (period, level, rest, times[0] / period, len(times))))


def uncertainties(first: Oscillation, second: Oscillation, displacement: float) -> dict[str, float]:
    """Uncertainty of each quantity, from the oscillations of two solutions.

    ``displacement`` is an upper bound of the uncertainty of u, relative to its size.
    """
    period, crossings = float(abs(first.period - second.period) / first.period), int(first.crossings)
    return {"period": period, "phase": period * crossings, "amplitude": displacement / crossings}


def errors(runs: xr.Dataset) -> dict[str, np.ndarray]:
    """Absolute errors of period, phase and amplitude, in runs that :class:`OscillationErrors` observed."""
    return {name: np.abs(runs[variable].values) for name, variable in QUANTITIES.items() if variable in runs}
