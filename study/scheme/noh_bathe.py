"""The explicit method of Noh and Bathe, with two sub-steps and damping of high frequencies."""

import math
from typing import ClassVar

import equinox as eqx

from study.mechanics.balance import acceleration
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges


class NohBathe(OneStep):
    r"""The explicit method of Noh and Bathe, with the sub-steps h = pΔt and k = (1 − p)Δt.

    .. math::

        u_p &= u_0 + h \dot u_0 + \tfrac12 h^2 \ddot u_0 \\
        M \ddot u_p + C (\dot u_0 + h \ddot u_0) + p(u_p) &= f(t_0 + h) \\
        \dot u_p &= \dot u_0 + \tfrac12 h\,(\ddot u_0 + \ddot u_p) \\
        u_1 &= u_p + k \dot u_p + \tfrac12 k^2 \ddot u_p \\
        M \ddot u_1 + C (\dot u_p + k \ddot u_p) + p(u_1) &= f(t_1) \\
        \dot u_1 &= \dot u_p + k\,(q_0 \ddot u_0 + (\tfrac12 + q_1)\,\ddot u_p + q_2 \ddot u_1) \\
        q_1 &= \frac{1 - 2p}{2p(1 - p)}, \quad q_2 = \tfrac12 - p q_1, \quad q_0 = \tfrac12 - q_1 - q_2

    Second order; stable without damping for :math:`\omega\Delta t \le 2/\sqrt{(3p - 1)(1 - p)}` if p ≤ ¾, which is
    ωΔt ≤ 3.745 for p = 0.54. For larger p it is stable for :math:`(\omega\Delta t)^2 \le 8/(1 + \sqrt{1 - 4c})` with
    :math:`c = (1 - p)(4p^2 - 3p + 1)`; at this limit a root of the amplification matrix is −1. p = ½ is two steps of
    central difference. Carries u, u̇ and ü; two forces per step, and two solutions with M. The history of a force is
    committed at the end of each sub-step.

    Parameters
    ----------
    p
        0.5 ≤ p ≤ 0.9.

    Raises
    ------
    ValueError
        If p is out of its range.

    References
    ----------
    G. Noh, K. J. Bathe, An explicit time integration scheme for the analysis of wave propagations, Comput. Struct. 129,
    2013, 178-193.
    """

    p: float = 0.54
    title: str = eqx.field(default="Noh-Bathe", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Noh and Bathe (2013)"
    doi: ClassVar[str] = "10.1016/j.compstruc.2013.06.007"
    order = 2
    explicit = True
    acceleration_offset = 0.0
    force_at_end = True

    def __check_init__(self):
        check_ranges(self, p=(0.5, 0.9))

    @property
    def stability_limit(self) -> float:
        p = self.p
        if p <= 0.75:
            return 2 / math.sqrt((3 * p - 1) * (1 - p))
        return math.sqrt(8 / (1 + math.sqrt(1 - 4 * (1 - p) * (4 * p * p - 3 * p + 1))))

    def increment(self, problem, state, t, dt):
        u, v, a = state
        p, h, k = self.p, self.p * dt, (1 - self.p) * dt
        q1 = (1 - 2 * p) / (2 * p * (1 - p))
        q2 = 0.5 - p * q1
        q0 = 0.5 - q1 - q2
        du = h * v + h**2 / 2 * a
        a_p = acceleration(problem, t + h, u + du, v + h * a)
        dv = h / 2 * (a + a_p)
        problem = problem.at_time(t + h).committed(u + du, v + dv)
        du = du + k * (v + dv) + k**2 / 2 * a_p
        a_new = acceleration(problem, t + dt, u + du, v + dv + k * a_p)
        new = Motion(du, dv + k * (q0 * a + (0.5 + q1) * a_p + q2 * a_new), a_new)
        return new, Effort(committed=problem.history)


noh_bathe = NohBathe()
