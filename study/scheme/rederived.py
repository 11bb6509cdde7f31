"""A scheme that discards its algorithmic acceleration: a mistake, kept to measure the accuracy that it costs."""

from typing import ClassVar

import equinox as eqx

from study.mechanics.balance import acceleration
from study.scheme.base import Scheme, Wrapper


class Rederived(Wrapper):
    r"""Another scheme, whose acceleration is recomputed from the equation of motion after every step.

    .. math::

        M \ddot u_1 \leftarrow f(t_1) - C \dot u_1 - p(u_1)

    An α-method balances the forces within the step, and its acceleration belongs to the time of this balance. The
    acceleration of the equation of motion belongs to the end of the step, so the method drops to first order. Carries
    the state of the wrapped scheme; one additional force and one additional solution with M per step.

    Parameters
    ----------
    scheme
        A scheme whose state has an acceleration ``a``.

    References
    ----------
    S. Erlicher, L. Bonaventura, O. S. Bursi, The analysis of the generalized-α method for non-linear dynamic problems,
    Comput. Mech. 28(2), 2002, 83-104.
    """

    scheme: Scheme
    title: str = eqx.field(default="Rederived", static=True)

    family: ClassVar[str] = "Rederived"
    source: ClassVar[str] = "Erlicher et al. (2002)"
    doi: ClassVar[str] = "10.1007/s00466-001-0273-z"
    order = 1
    order_with_damping = 1
    stability_limit = None
    needs_mass = True
    acceleration_offset = 0.0

    def start(self, problem, u0, v0, dt):
        return self.scheme.start(problem, u0, v0, dt)

    def step(self, problem, state, t, dt):
        new, effort = self.scheme.step(problem, state, t, dt)
        return new._replace(a=acceleration(problem, t + dt, new.u, new.v)), effort
