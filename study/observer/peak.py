"""The largest displacement of a run, at the steps and between them."""

import jax.numpy as jnp

from study.observer.base import Reduction


class Peak(Reduction):
    r"""Largest absolute displacement of each unknown, at the steps and between them.

    Within a step the displacement is the cubic with the displacements and velocities at both ends,

    .. math::

        u(s) = u_0 + s\,[d_0 + s\,(3 \Delta - 2 d_0 - d_1 + s\,(d_0 + d_1 - 2 \Delta))], \quad 0 \le s \le 1

    with :math:`\Delta = u_1 - u_0` and :math:`d = \Delta t\,\dot u`. At the steps alone the peak of an oscillation of
    circular frequency ω is missed by up to :math:`(\omega \Delta t)^2/8` of its size.
    """

    variables = {
        "peak": {"long_name": "largest displacement, of the cubic Hermite interpolant of the steps", "units": "1"}
    }

    def start(self, problem, state):
        return (jnp.zeros(()), state.u, state.v), jnp.abs(state.u)

    def update(self, carried, problem, state, t, effort):
        (before, u, v), peak = carried
        way, start, end = state.u - u, (t - before) * v, (t - before) * state.v
        square, cube = 3 * way - 2 * start - end, start + end - 2 * way
        # both roots of start + 2 square s + 3 cube s², without cancellation
        q = -square - jnp.copysign(jnp.sqrt(jnp.maximum(square**2 - 3 * cube * start, 0.0)), square)
        for root in (q / (3 * cube), start / q):
            # every s within the step is a valid candidate, so that NaN, as from a step at rest, may become zero
            s = jnp.clip(jnp.nan_to_num(root), 0.0, 1.0)
            peak = jnp.maximum(peak, jnp.abs(u + s * (start + s * (square + s * cube))))
        return (t, state.u, state.v), jnp.maximum(peak, jnp.abs(state.u))

    def result(self, carried, problem, state):
        return {"peak": carried[1]}
