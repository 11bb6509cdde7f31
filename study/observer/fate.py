"""What becomes of the energy of a run, and of its place."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scipy import optimize

from study.observer.base import Record, Reduction
from study.problem.definition import Problem
from study.problem.named import problems

#: Within this part of its height above rest the energy is accurate; below this part of it a run is at rest.
ACCURATE = AT_REST = 0.01

#: An energy of so many times its height has grown.
GROWN = 100.0

#: A minimum of the potential so many times as far as the start is none.
FARTHEST = 1e6

#: Errors of the energy in percent by which steps are called fine enough.
LEVELS = (1, 5, 10)


class _Events(NamedTuple):
    """When what can happen to a run did, infinite where it did not."""

    inaccurate: jax.Array
    at_rest: jax.Array
    grown: jax.Array
    crossed: jax.Array | None


class Fate(Reduction):
    """What becomes of the energy, and of the place of a run.

    The height of the energy is H = E − E_rest. An inaccurate run has |H − H₀| > 0.01 H₀; one at rest stays below
    0.01 H₀ from then on; one that has grown stays above a hundred times H₀, or the barrier's height if that is more.
    A run that starts at rest has no H₀, and an error that is not a number.

    Parameters
    ----------
    rest
        E_rest, the potential energy of the rest that the run swings about.
    barrier
        Potential energy at u = 0 where that is a barrier between two wells, which no run from below it should cross.
    """

    rest: float = eqx.field(converter=np.float64)
    barrier: float | None = eqx.field(
        default=None, converter=lambda energy: None if energy is None else np.float64(energy)
    )

    variables = {
        "max_height_error": {"long_name": "largest error of the energy over its height above rest", "units": "percent"},
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
        "inaccurate_from": {"long_name": "first time with an error of the energy of more than 1 percent", "units": "s"},
        "at_rest_from": {"long_name": "time from which on less than 1 percent of the energy is left", "units": "s"},
        "grown_from": {"long_name": "time from which on there is a hundred times the energy", "units": "s"},
        "crossed_at": {"long_name": "first time beyond a barrier that is too high", "units": "s"},
    }
    needs_energy = True

    @classmethod
    def of(cls, problem: str | Problem) -> "Fate":
        """For a problem with one unknown: the rest downhill of u₀, and the barrier at u = 0 if there is one.

        Raises
        ------
        ValueError
            If the problem has several unknowns, damping or a load, which change its energy, no potential, or a
            potential without a minimum downhill of u₀.
        """
        problem = problems[problem] if isinstance(problem, str) else problem
        if np.ndim(problem.u0):
            raise ValueError(f"the fate of '{problem.title}' is not told: it has more than one unknown.")
        if problem.damping is not None or problem.load is not None:
            raise ValueError(f"the fate of '{problem.title}' is not told: damping or a load change its energy.")
        if problem.potential is None:
            raise ValueError(f"the fate of '{problem.title}' needs Problem(potential=...), which it was made without.")
        potential = jax.jit(problem.potential)
        u0 = float(problem.u0)
        try:
            found = optimize.minimize_scalar(potential, bracket=(u0, 0.99 * u0 if u0 else 0.01), tol=1e-12)
        except RuntimeError:
            found = optimize.OptimizeResult(fun=-np.inf)
        if not np.isfinite(found.fun) or abs(found.x) > FARTHEST * max(abs(u0), 1):
            raise ValueError(f"the potential of '{problem.title}' has no minimum downhill of u0 = {u0:g}.")
        barrier, start = potential(0.0), potential(u0)
        return cls(found.fun, barrier if barrier - found.fun > AT_REST * (start - found.fun) else None)

    def start(self, problem, state):
        if jnp.ndim(state.u):
            raise ValueError(f"the fate of '{problem.title}' is not told: it has more than one unknown.")
        never = jnp.full((), jnp.inf)
        height = problem.energy(state.u, state.v) - self.rest
        side, crossed = (None, None) if self.barrier is None else (state.u, never)
        return (height, side), jnp.zeros(()), jnp.zeros((), int), _Events(never, never, never, crossed)

    def update(self, carried, problem, state, t, effort):
        (height, side), error, iterations, first = carried
        # over that at the start: as XLA repeats no division, the energy is not made again for every event
        now = (problem.energy(state.u, state.v) - self.rest) / height
        change = jnp.abs(now - 1)

        def first_time(event, before):
            return jnp.where(event & (before == jnp.inf), t, before)

        def since(event, before):
            return jnp.where(event, jnp.minimum(before, t), jnp.inf)

        much, crossed = 1.0, None
        if self.barrier is not None:
            much = jnp.maximum(1.0, (self.barrier - self.rest) / height)
            crossed = first_time((state.u * side < 0) & (height + self.rest < self.barrier), first.crossed)
        events = _Events(
            inaccurate=first_time(change > ACCURATE, first.inaccurate),
            at_rest=since(now < AT_REST, first.at_rest),
            grown=since(now > GROWN * much, first.grown),
            crossed=crossed,
        )
        iterations = jnp.maximum(iterations, effort.iterations)
        return (height, side), jnp.maximum(error, change), iterations, events

    def result(self, carried, problem, state):
        _, error, iterations, first = carried
        values = dict(zip(self.variables, (100 * error, iterations, *first), strict=True))
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
        change = jnp.abs((problem.energy(state.u, state.v) - self.rest) / height - 1)
        return height, tuple(
            jnp.where((change > level / 100) & (before == jnp.inf), t, before)
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
