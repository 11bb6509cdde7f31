"""Compensated summation: each step corrects the round-off of the previous addition."""

from typing import Any, ClassVar

import equinox as eqx

from study.algebra.arrays import Vector
from study.algebra.elementwise import compensated_sum
from study.mechanics.state import Effort
from study.scheme.base import OneStep, Wrapper, WrapperState


class Summed(WrapperState):
    """State of the wrapped scheme, and the round-off of the last additions to u and u̇, each of shape () or (n,)."""

    inner: Any
    lost_u: Vector
    lost_v: Vector


class Compensated(Wrapper):
    r"""Another scheme with compensated summation of displacement and velocity.

    .. math::

        y &= \Delta u - \text{lost}, \quad u_1 = u_0 + y \\
        \text{lost} &= (u_1 - u_0) - y

    and the same for u̇, where Δu is the increment of the step and lost is the round-off of the last addition. Order and
    stability are those of the wrapped scheme. Carries the state of the wrapped scheme and the round-off of both sums;
    as many forces per step as the wrapped scheme.

    Parameters
    ----------
    scheme
        A scheme whose step adds increments to displacement and velocity: any one-step scheme of the study.

    Raises
    ------
    TypeError
        If ``scheme`` is not a :class:`study.OneStep`.

    References
    ----------
    W. Kahan, Further remarks on reducing truncation errors, Commun. ACM 8(1), 1965, 40.
    """

    scheme: OneStep
    title: str = eqx.field(default="Compensated", static=True)

    family: ClassVar[str] = "Compensated"
    source: ClassVar[str] = "Kahan (1965)"
    doi: ClassVar[str] = "10.1145/363707.363723"

    def __check_init__(self):
        if not isinstance(self.scheme, OneStep):
            raise TypeError(
                f"Compensated takes a study.OneStep, whose step adds to u and u̇, not "
                f"{getattr(self.scheme, 'title', self.scheme)!r}."
            )

    def start(self, problem, u0, v0, dt):
        inner, effort = self.scheme.start(problem, u0, v0, dt)
        return Summed(inner, 0 * u0, 0 * v0), effort

    def step(self, problem, state, t, dt) -> tuple[Summed, Effort]:
        increment, effort = self.scheme.increment(problem, state.inner, t, dt)
        u, lost_u = compensated_sum(state.u, increment.u, state.lost_u)
        v, lost_v = compensated_sum(state.v, increment.v, state.lost_v)
        return Summed(increment._replace(u=u, v=v), lost_u, lost_v), effort
