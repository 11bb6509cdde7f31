"""What becomes of a run at a step size that may be too large."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from scipy import optimize

from study.march import NEWTON_FAILED, NOT_FINITE
from study.observers import Record, Reduction
from study.problem import Problem

#: Within this part of its height above rest the energy is accurate; below this part of it a run is at rest.
ACCURATE = AT_REST = 0.01
#: An energy of so many times its height has grown.
GROWN = 100.0
#: Errors of the energy in percent by which steps are called fine enough.
LEVELS = (1, 5, 10)
#: How a run can end, from the best to the worst.
OUTCOMES = (
    "accurate",
    "bounded",
    "damped_to_rest",
    "in_the_wrong_well",
    "chaotic",
    "growing",
    "newton_not_converged",
    "not_finite",
)


#: What of it an event tells, the worse ones last.
_EVENTS = {
    "bounded": "inaccurate_from",
    "damped_to_rest": "at_rest_from",
    "in_the_wrong_well": "crossed_at",
    "chaotic": "apart_from",
    "growing": "grown_from",
}


class _Events(NamedTuple):
    """First times of what can happen to a run, infinite where it did not."""

    inaccurate: jax.Array
    at_rest: jax.Array
    grown: jax.Array
    crossed: jax.Array | None


class Fate(Reduction):
    """What becomes of the energy, and of the place of a run.

    The height of the energy is H = E − E_rest. An inaccurate run has |H − H₀| > 0.01 H₀, one at rest stays below
    0.01 H₀ from then on, one that has grown had H > 100 H₀.

    Parameters
    ----------
    rest
        E_rest, the potential energy of the rest that the run swings about.
    hill
        Potential energy at u = 0 where that is a hill between two wells, which no run from below it should cross.
    """

    rest: float = eqx.field(converter=np.float64)
    hill: float | None = eqx.field(
        default=None, converter=lambda energy: None if energy is None else np.float64(energy)
    )

    variables = {
        "max_energy_error": {"long_name": "largest error of the energy over its height above rest", "units": "percent"},
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
        "inaccurate_from": {"long_name": "first time with an error of the energy of more than 1 percent", "units": "s"},
        "at_rest_from": {"long_name": "time from which on less than 1 percent of the energy is left", "units": "s"},
        "grown_from": {"long_name": "first time with a hundred times the energy", "units": "s"},
        "crossed_at": {"long_name": "first time on the other side of a hill that is too high", "units": "s"},
    }
    needs_energy = True

    @classmethod
    def of(cls, problem: Problem) -> "Fate":
        """For a problem with one unknown: the rest downhill of u₀, and the hill at u = 0 if there is one."""
        potential = jax.jit(problem.potential)  # type: ignore[arg-type]
        u0 = float(problem.u0)
        rest = optimize.minimize_scalar(potential, bracket=(u0, 0.99 * u0), tol=1e-12).fun
        hill, start = potential(0.0), potential(u0)
        return cls(rest, hill if hill - rest > AT_REST * (start - rest) else None)

    def start(self, problem, state):
        never = jnp.full((), jnp.inf)
        height = problem.energy(state.u, state.v) - self.rest
        events = _Events(never, never, never, None if self.hill is None else never)
        return height, jnp.zeros(()), jnp.zeros((), int), events

    def update(self, carried, problem, state, t, effort):
        height, error, iterations, first = carried
        now = problem.energy(state.u, state.v) - self.rest
        change = jnp.abs(now - height)

        def first_time(event, before):
            return jnp.where(event & (before == jnp.inf), t, before)

        lost = now < AT_REST * height
        return (
            height,
            jnp.maximum(error, change),
            jnp.maximum(iterations, effort.iterations),
            _Events(
                inaccurate=first_time(change > ACCURATE * height, first.inaccurate),
                at_rest=jnp.where(lost, jnp.minimum(first.at_rest, t), jnp.inf),
                grown=first_time(now > GROWN * height, first.grown),
                crossed=None
                if self.hill is None
                else first_time(self._is_beyond(problem, state, height), first.crossed),
            ),
        )

    def _is_beyond(self, problem, state, height):
        """Whether the run is on the other side though its first energy does not reach the hill."""
        return (state.u * problem.u0 < 0) & (height + self.rest < self.hill)

    def result(self, carried, problem, state):
        height, error, iterations, first = carried
        values = dict(zip(self.variables, (100 * error / height, iterations, *first), strict=True))
        return {name: value for name, value in values.items() if value is not None}


class Excursions(Reduction):
    """When the error of the energy over its height above rest first went beyond 1, 5 and 10 percent.

    Parameters
    ----------
    rest
        E_rest, as in :class:`Fate`.
    """

    rest: float = eqx.field(converter=np.float64)

    variables = {
        f"beyond_{level}_percent": {
            "long_name": f"first time with an error of the energy of more than {level} percent",
            "units": "s",
        }
        for level in LEVELS
    }
    needs_energy = True

    def start(self, problem, state):
        return problem.energy(state.u, state.v) - self.rest, (jnp.full((), jnp.inf),) * len(LEVELS)

    def update(self, carried, problem, state, t, effort):
        height, first = carried
        change = jnp.abs(problem.energy(state.u, state.v) - self.rest - height)
        return height, tuple(
            jnp.where((change > level / 100 * height) & (before == jnp.inf), t, before)
            for level, before in zip(LEVELS, first, strict=True)
        )

    def result(self, carried, problem, state):
        return dict(zip(self.variables, carried[1], strict=True))


class Height(Record):
    """Height of the energy above rest along time, over that at the start.

    Parameters
    ----------
    rest
        E_rest, as in :class:`Fate`.
    """

    rest: float = eqx.field(converter=np.float64)

    variables = {"height": {"long_name": "height of the energy above rest over that at the start", "units": "1"}}
    needs_energy = True

    def sample(self, problem, initial, state):
        first, now = (problem.energy(at.u, at.v) - self.rest for at in (initial, state))
        return {"height": now / first}


def outcomes(runs: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """How each lane ended, as a place in ``OUTCOMES``, and when that began, NaN for accurate ones, both (lanes,).

    Parameters
    ----------
    runs
        What ``study.run`` made of an ensemble under :class:`Fate` and :class:`study.observers.LyapunovExponent`.
    """
    outcome, at = np.zeros(runs.sizes["lane"], np.int8), np.full(runs.sizes["lane"], np.nan)
    for name, event in _EVENTS.items():
        if event in runs:
            times = runs[event].values
            happened = np.isfinite(times)
            outcome[happened], at[happened] = OUTCOMES.index(name), times[happened]
    outcome[runs.status == NEWTON_FAILED] = OUTCOMES.index("newton_not_converged")
    outcome[runs.status == NOT_FINITE] = OUTCOMES.index("not_finite")
    return outcome, at
