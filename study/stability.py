"""What becomes of a run at a step size that may be too large: when its energy leaves, and how fast neighbours part."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from study.march import NEWTON_FAILED, NOT_FINITE
from study.observers import Reduction

#: Within this part of its height above rest the energy is accurate; below this part of it a run is at rest.
ACCURATE = AT_REST = 0.01
#: An energy of so many times its height has grown.
GROWN = 100.0
#: Neighbours that part by more than e to this power in a period are chaotic. Over N periods regular ones part in
#: proportion to time, by about ln N / N.
CHAOTIC = 0.1

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


class _Events(NamedTuple):
    """First times of what can happen to an energy, infinite where it did not."""

    inaccurate: jax.Array
    at_rest: jax.Array
    crossed: jax.Array
    grown: jax.Array


class EnergyEvents(Reduction):
    """When the height of the energy above rest left its first value, was lost, or grew; and when u crossed the hill.

    The height is H = E − E_rest with the energy of the nearest rest. An inaccurate run has |H − H₀| > 0.01 H₀, one at
    rest stays below 0.01 H₀ from then on, one that has grown had H > 100 H₀. A run crosses the hill of a double well at
    u = 0 though its energy is below it.

    Parameters
    ----------
    rest
        E_rest.
    """

    rest: float

    variables = {
        "max_height_error": {"long_name": "largest error of the energy over its height above rest", "units": "percent"},
        "inaccurate_from": {"long_name": "first time with an error of the energy of more than 1 percent", "units": "s"},
        "at_rest_from": {"long_name": "time from which on less than 1 percent of the energy is left", "units": "s"},
        "crossed_at": {"long_name": "first time on the other side of u = 0", "units": "s"},
        "grown_from": {"long_name": "first time with a hundred times the energy", "units": "s"},
    }
    needs_energy = True

    def start(self, problem, state):
        never = jnp.full((), jnp.inf)
        height = problem.energy(state.u, state.v) - self.rest
        return height, state.u, jnp.zeros(()), _Events(*[never] * 4)

    def update(self, carried, problem, state, t, effort):
        height, u0, error, first = carried
        now = problem.energy(state.u, state.v) - self.rest
        change = jnp.abs(now - height)

        def at(event):
            return jnp.where(event, t, jnp.inf)

        lost = now < AT_REST * height
        return (
            height,
            u0,
            jnp.maximum(error, change),
            _Events(
                inaccurate=jnp.minimum(first.inaccurate, at(change > ACCURATE * height)),
                at_rest=jnp.where(lost, jnp.minimum(first.at_rest, t), jnp.inf),
                crossed=jnp.minimum(first.crossed, at(state.u * u0 < 0)),
                grown=jnp.minimum(first.grown, at(now > GROWN * height)),
            ),
        )

    def result(self, carried, problem, state):
        height, _, error, first = carried
        return dict(zip(self.variables, (100 * error / height, *first), strict=True))


class LyapunovExponent(Reduction):
    """Largest Lyapunov exponent of the numerical map over the run, of a :class:`study.Linearised` scheme."""

    variables = {
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"}
    }

    def start(self, problem, state):
        return jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        return t

    def result(self, carried, problem, state):
        return {"lyapunov_exponent": state.growth / carried}
