"""Events that decide the outcome of a run: its energy becomes inaccurate, decays or grows, or u crosses a barrier."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.jit import jit
from study.keywords import KeywordsOnly
from study.mechanics.definition import Problem
from study.observer.base import Record, Reduction
from study.problem.named import problems

#: Largest |H − H₀|/H₀ of an accurate run, and largest H/H₀ of a run at rest. H is the height of the energy above the
#: energy of the rest position.
ACCURATE = AT_REST = 0.01

#: A run has grown if the height of its energy above the rest position exceeds this multiple of the height at the start,
#: or of the height of the barrier if that is larger.
GROWN = 100.0

#: Minima at a distance from u₀ of more than this multiple of max(|u₀|, 1) are not found.
FARTHEST = 1e6


def _refusal(problem: Problem) -> str | None:
    """One sentence on why the outcome of runs of the problem is undefined; None if it is defined."""
    if np.ndim(problem.u0):
        return f"'{problem.title}' has more than one unknown; outcomes and step bounds are defined for one."
    if problem.damping is not None or problem.load is not None:
        return f"'{problem.title}' is no free motion: damping or a load change its energy."
    if problem.potential is None:
        return f"'{problem.title}' needs Problem(potential=...), which it was made without."
    return None


def _rest_of(problem: Problem) -> float:
    """The nearest minimum of the potential downhill of u₀, where the force changes its sign.

    Places at distances from u₀ that grow by 0.3 % are searched, so that the search does not pass a singularity of the
    potential.

    Raises
    ------
    ValueError
        If there is none.
    """
    from scipy import optimize  # here, as this import takes a third of the time of importing the study

    u0 = float(problem.u0)
    force = jit(jax.vmap(problem.static_force))
    downhill = -1.0 if force(np.array([u0])).item() > 0 else 1.0
    places = u0 + downhill * max(abs(u0), 1) * np.geomspace(1 / FARTHEST, FARTHEST, 10_000)
    forces = np.asarray(force(places)) * downhill
    beyond = np.nonzero(~(forces <= 0))[0]  # a force that underflows to zero far away is no minimum
    if not len(beyond) or np.isnan(forces[beyond[0]]):
        raise ValueError(f"the potential of '{problem.title}' has no minimum downhill of u0 = {u0:g}.")
    inner, outer = places[beyond[0] - 1] if beyond[0] else u0, places[beyond[0]]
    precision = 1e-16 * abs(outer - u0)
    return optimize.brentq(lambda u: force(np.array([u])).item(), inner, outer, xtol=precision, maxiter=1000)


class _Events(NamedTuple):
    """Times of the events; the time of an event that did not happen is infinite."""

    inaccurate: jax.Array
    at_rest: jax.Array
    grown: jax.Array
    crossed: jax.Array | None


class OutcomeObserver(KeywordsOnly, Reduction):
    r"""Times at which a run becomes inaccurate, comes to rest, grows or crosses a barrier.

    The time of an event that does not happen is infinite. The events are defined by the height H = E − E_rest of the
    energy above the energy of the rest position. A run is

    - inaccurate from the first time with :math:`|H - H_0| > 0.01 H_0`;
    - at rest from the last time at which H falls below 0.01 H₀ and stays there;
    - grown from the last time at which H exceeds :math:`100 \max(H_0, H_\text{barrier})` and stays there;
    - across the barrier from the first time on the other side of u = 0, if H₀ < H_barrier.

    The problem must have one unknown, a potential, and neither damping nor load, which change the energy. For a run
    that starts at rest, H₀ = 0 and the relative error of H is NaN.

    Parameters
    ----------
    rest
        E_rest, the potential energy of the rest position about which the run oscillates.
    barrier
        Potential energy at u = 0 if a barrier there separates two wells; None without a barrier. A run that starts
        below this energy should not cross the barrier.
    rest_at
        Displacement of the rest position.
    """

    rest: float = eqx.field(converter=np.float64)
    barrier: float | None = eqx.field(
        default=None, converter=lambda energy: None if energy is None else np.float64(energy)
    )
    rest_at: float = eqx.field(default=0.0, converter=np.float64)

    variables = {
        "max_height_error": {"long_name": "largest error of the energy over its height above rest", "units": "1"},
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
        "inaccurate_from": {"long_name": "first time with an error of the energy of more than 1 percent", "units": "s"},
        "at_rest_from": {"long_name": "time from which on less than 1 percent of the energy is left", "units": "s"},
        "grown_from": {"long_name": "time from which on there is a hundred times the energy", "units": "s"},
        "crossed_at": {"long_name": "first time beyond a barrier that is too high", "units": "s"},
    }
    needs_energy = True

    @classmethod
    def of(cls, problem: str | Problem) -> "OutcomeObserver":
        """The observer of a problem, with the rest position in the minimum of the potential downhill of u₀.

        The barrier is the potential at u = 0, if its height above the minimum exceeds 1 % of the height at u₀.

        Raises
        ------
        KeyError
            If there is no problem of that name.
        TypeError
            If ``problem`` is neither a problem nor a name.
        ValueError
            If the problem has several unknowns, damping, a load or no potential, or if the potential has no minimum
            downhill of u₀.
        """
        if not isinstance(problem, str | Problem):
            raise TypeError(f"OutcomeObserver.of takes a problem or its name, not {problem!r}.")
        problem = problems[problem] if isinstance(problem, str) else problem
        if refusal := _refusal(problem):
            raise ValueError(refusal)
        rest_at = _rest_of(problem)
        barrier, start, rest = (float(problem.stored_energy(jnp.asarray(u, float))) for u in (0, problem.u0, rest_at))
        is_barrier = barrier - rest > AT_REST * (start - rest)
        return cls(rest=rest, barrier=barrier if is_barrier else None, rest_at=rest_at)

    def refusal(self, problem):
        return _refusal(problem)

    def start(self, problem, state):
        never = jnp.full((), jnp.inf)
        height = problem.energy(state.u, state.v) - self.rest
        side, crossed = (None, None) if self.barrier is None else (state.u, never)
        return (height, side), jnp.zeros(()), jnp.zeros((), int), _Events(never, never, never, crossed)

    def update(self, carried, problem, state, t, effort):
        (height, side), error, iterations, first = carried
        # H/H₀ rather than H: XLA does not repeat a division, and so computes the energy once for all events
        energy = (problem.energy(state.u, state.v) - self.rest) / height
        change = jnp.abs(energy - 1)

        def first_time(event, before):
            return jnp.where(event & (before == jnp.inf), t, before)

        def since(event, before):
            return jnp.where(event, jnp.minimum(before, t), jnp.inf)

        highest: float | jax.Array = 1.0
        crossed = None
        if self.barrier is not None:
            highest = jnp.maximum(1.0, (self.barrier - self.rest) / height)
            crossed = first_time((state.u * side < 0) & (height + self.rest < self.barrier), first.crossed)
        events = _Events(
            inaccurate=first_time(change > ACCURATE, first.inaccurate),
            at_rest=since(energy < AT_REST, first.at_rest),
            grown=since(energy > GROWN * highest, first.grown),
            crossed=crossed,
        )
        iterations = jnp.maximum(iterations, effort.iterations)
        return (height, side), jnp.maximum(error, change), iterations, events

    def result(self, carried, problem, state):
        _, error, iterations, first = carried
        values = dict(zip(self.variables, (error, iterations, *first), strict=True))
        return {name: value for name, value in values.items() if value is not None}


class Height(Record):
    """H/H₀ along time, with the height H = E − E_rest of the energy above the energy of the rest position.

    Parameters
    ----------
    rest
        E_rest, as in :class:`OutcomeObserver`.
    """

    rest: float = eqx.field(converter=np.float64)

    variables = {"height": {"long_name": "height of the energy above rest over that at the start", "units": "1"}}
    needs_energy = True

    def sample(self, problem, initial, state, t):
        first, height = (problem.energy(motion.u, motion.v) - self.rest for motion in (initial, state))
        return {"height": height / first}
