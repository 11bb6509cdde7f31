"""A scheme that forgets its algorithmic acceleration: a mistake, kept to show what it costs."""

from typing import ClassVar

import equinox as eqx

from study.equilibrium.balance import acceleration
from study.scheme.base import Scheme


class Rederived(Scheme):
    """Another scheme whose acceleration is taken from the equation of motion after every step.

    M ü₁ ← f(t₁) − C u̇₁ − p(u₁)

    An α-method balances at a time within the step, and its acceleration belongs to that time; re-derived at the end of
    the step it is a different one, and the method is of first order.

    Parameters
    ----------
    scheme
        A scheme whose state has an acceleration ``a``.

    References
    ----------
    S. Erlicher, L. Bonaventura, O. S. Bursi, The analysis of the generalized-α method for non-linear dynamic problems,
    Comput. Mech. 28, 2002, 83-104.
    """

    scheme: Scheme
    title: str = eqx.field(default="Rederived", kw_only=True, static=True)

    family: ClassVar[str] = "Rederived"
    source: ClassVar[str] = "Erlicher et al. (2002)"
    doi: ClassVar[str] = "10.1007/s00466-001-0273-z"
    order = 1

    @property
    def explicit(self) -> bool:
        return self.scheme.explicit

    def start(self, problem, u0, v0, dt):
        return self.scheme.start(problem, u0, v0, dt)

    def step(self, problem, state, t, dt):
        new, effort = self.scheme.step(problem, state, t, dt)
        return new._replace(a=acceleration(problem, t + dt, new.u, new.v)), effort
