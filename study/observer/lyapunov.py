"""The largest Lyapunov exponent of the numerical map."""

import jax.numpy as jnp

from study.observer.base import Reduction

#: A perturbation that has grown by so many powers of two was of round-off and is of the size of the motion.
APART = 33


class LyapunovExponent(Reduction):
    """Largest Lyapunov exponent of the numerical map over the run, and when neighbours are far apart.

    λ = ln |δ(t)|/t with the distance δ of displacement and velocity of :class:`study.schemes.Linearised`, whose
    displacement is of length one at the start. A regular motion has λ of the order of ln t/t. Neighbours are far apart
    where a component of δ is 2³³ times as large, 8.6e9.
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
