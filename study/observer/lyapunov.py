"""The largest Lyapunov exponent of the numerical map."""

import jax.numpy as jnp

from study.observer.base import Reduction

#: log₂ of the growth that lifts round-off to the size of the motion.
APART = 33


class LyapunovExponent(Reduction):
    """Largest Lyapunov exponent of the numerical map, and the time from which on neighbours are far apart.

    λ = ln |δ(t)|/t, where δ is the distance in displacement and velocity that
    :class:`study.scheme.linearised.Linearised` carries; at the start, its displacement has length one. For regular
    motions λ is of the order of ln t/t. Neighbours are far apart if a component of δ has grown to 2³³ = 8.6e9.
    """

    variables = {
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"},
        "apart_from": {"long_name": "time from which on a perturbation is 8.6e9 times as large", "units": "s"},
    }
    needs_neighbour = True

    def start(self, problem, state):
        return jnp.zeros(()), jnp.full((), jnp.inf)

    def update(self, carried, problem, state, t, effort):
        _, first = carried
        return t, jnp.where(state.exponent >= APART, jnp.minimum(first, t), jnp.inf)

    def result(self, carried, problem, state):
        t, first = carried
        size = jnp.sqrt(jnp.sum(state.distance.u**2 + state.distance.v**2))
        growth = jnp.log(size) + jnp.log(2.0) * state.exponent.astype(size.dtype)
        return {"lyapunov_exponent": growth / t, "apart_from": first}
