"""The explicit method of Tchamwa and Wielgosz, of first order, with damping of high frequencies."""

import math
from typing import ClassVar

import equinox as eqx

from study.mechanics.balance import acceleration
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges


class TchamwaWielgosz(OneStep):
    r"""The method of Tchamwa and Wielgosz.

    .. math::

        u_1 &= u_0 + \Delta t\,\dot u_0 + \varphi\,\Delta t^2 \ddot u_0 \\
        \dot u_1 &= \dot u_0 + \Delta t\,\ddot u_0 \\
        M \ddot u_1 + C \dot u_1 + p(u_1) &= f(t_1)

    First order. Without damping φ = 1 is the symplectic Euler method; φ > 1 damps high frequencies. Stable without
    damping for :math:`\omega\Delta t \le 2/\sqrt{2\varphi - 1}`. Carries u, u̇ and ü; one force per step. The history
    of a force is committed at u₁, where the forces balance.

    Parameters
    ----------
    phi
        1 ≤ φ ≤ 2.

    Raises
    ------
    ValueError
        If φ is out of its range.

    References
    ----------
    B. Tchamwa, T. Conway, C. Wielgosz, An accurate explicit direct time integration method for computational structural
    dynamics, ASME PVP 398, 1999, 77-84.
    """

    phi: float = 1.033
    title: str = eqx.field(default="Tchamwa-Wielgosz", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Tchamwa et al. (1999)"
    doi: ClassVar[str] = ""
    order = 1
    explicit = True
    acceleration_offset = 0.0

    def __check_init__(self):
        check_ranges(self, phi=(1.0, 2.0))

    @property
    def stability_limit(self) -> float:
        return 2 / math.sqrt(2 * self.phi - 1)

    def increment(self, problem, state, t, dt):
        u, v, a = state
        du, dv = dt * v + self.phi * dt**2 * a, dt * a
        return Motion(du, dv, acceleration(problem, t + dt, u + du, v + dv)), Effort()


tchamwa_wielgosz = TchamwaWielgosz()
