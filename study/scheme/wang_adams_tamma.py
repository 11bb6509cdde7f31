"""The explicit method WAT2 of Wang, Adams and Tamma: third order with two forces per step."""

import math
from typing import ClassVar

import equinox as eqx

from study.mechanics.balance import acceleration
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges


class WangAdamsTamma(OneStep):
    r"""The generalised explicit Runge-Kutta-Nyström method WAT2, with the balance at two times of a step.

    With :math:`D = 3C_1^2 - 3C_1 + 1` and :math:`E = 2C_1 - 1`,

    .. math::

        u_1 &= u_0 + C_1 \Delta t\,\dot u_0 + \tfrac16 C_1 \Delta t^2 \ddot u_0, \quad
            \dot u_1 = \dot u_0 + C_1 \Delta t\,\ddot u_0 \\
        u_2 &= u_0 + C_2 \Delta t\,\dot u_0 + \Delta t^2 \left(\frac{3C_1 - 1}{18 C_1} \ddot u_0
            + \frac{D}{18 C_1 E^2} \ddot u_1\right), \quad C_2 = \frac{3C_1 - 2}{3E} \\
        \dot u_2 &= \dot u_0 + \Delta t\,[(C_2 - V)\,\ddot u_0 + V \ddot u_1], \quad V = \frac{2D}{9 C_1 E^2} \\
        M \ddot u_i + C \dot u_i + p(u_i) &= f(t_0 + C_i \Delta t) \quad\text{for } i = 1, 2 \\
        u(t_1) &= u_0 + \Delta t\,\dot u_0 + \Delta t^2 [U_0 \ddot u_0 + U_1 \ddot u_1
            + (\tfrac12 - U_0 - U_1)\,\ddot u_2] \\
        \dot u(t_1) &= \dot u_0 + \Delta t\left[\frac{1}{4D} \ddot u_1
            + \left(1 - \frac{1}{4D}\right) \ddot u_2\right] \\
        \ddot u(t_1) &= A_0 \ddot u_0 + A_1 \ddot u_1 + (1 - A_0 - A_1)\,\ddot u_2 \\
        U_0 &= \frac{4C_1 - 1}{12 C_1}, \quad U_1 = \frac{6C_1^2 - 5C_1 + 2}{24 C_1 D} \\
        A_0 &= \frac{1 - 3C_1}{C_1}, \quad A_1 = \frac{4C_1 - 3C_1^2 - 1}{C_1 D}

    Third order, with damping and load too; the principal roots of undamped linear systems are of fourth order. Stable
    without damping for :math:`\omega\Delta t \le \sqrt{6(4 - 1/C_1)}`, from 2 (C₁ = 0.3) to 3 (C₁ = 0.4). C₁ = 0.4
    damps high frequencies most. With C₁ = ⅓ the acceleration at the end is the acceleration of the second balance.
    Carries u, u̇ and the algorithmic ü; two forces per step, and two solutions with M. The history of a force is
    committed at u(t₁); both balances start from the history at u₀.

    Parameters
    ----------
    c1
        0.3 ≤ C₁ ≤ 0.4.

    Raises
    ------
    ValueError
        If C₁ is out of its range.

    References
    ----------
    Y. Wang, N. Adams, K. K. Tamma, [on generalized explicit Runge-Kutta-Nyström methods; title not confirmed], Int. J.
    Numer. Methods Eng. 126, 2025, e7658.
    """

    c1: float = 1 / 3
    title: str = eqx.field(default="WAT2", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Wang et al. (2025)"
    doi: ClassVar[str] = "10.1002/nme.7658"
    order = 3
    explicit = True

    def __check_init__(self):
        check_ranges(self, c1=(0.3, 0.4))

    @property
    def force_at_end(self) -> bool:
        return self.c1 >= 1 / 3  # the second stage is then at or after the end

    @property
    def stability_limit(self) -> float:
        return math.sqrt(24 - 6 / self.c1)

    def increment(self, problem, state, t, dt):
        u, v, a = state
        c1 = self.c1
        d, e = 3 * c1**2 - 3 * c1 + 1, 2 * c1 - 1
        c2 = (3 * c1 - 2) / (3 * e)
        weight_v = 2 * d / (9 * c1 * e**2)
        v_1 = 1 / (4 * d)
        u_0, u_1 = (4 * c1 - 1) / (12 * c1), (6 * c1**2 - 5 * c1 + 2) / (24 * c1 * d)
        a_0, a_1 = (1 - 3 * c1) / c1, (4 * c1 - 3 * c1**2 - 1) / (c1 * d)

        first = acceleration(problem, t + c1 * dt, u + c1 * dt * v + c1 / 6 * dt**2 * a, v + c1 * dt * a)
        u_second = u + c2 * dt * v + dt**2 * ((3 * c1 - 1) / (18 * c1) * a + d / (18 * c1 * e**2) * first)
        v_second = v + dt * ((c2 - weight_v) * a + weight_v * first)
        second = acceleration(problem, t + c2 * dt, u_second, v_second)
        du = dt * v + dt**2 * (u_0 * a + u_1 * first + (0.5 - u_0 - u_1) * second)
        dv = dt * (v_1 * first + (1 - v_1) * second)
        return Motion(du, dv, a_0 * a + a_1 * first + (1 - a_0 - a_1) * second), Effort()


wat2 = WangAdamsTamma()
