"""The explicit single-step methods GSSE and ICL. Forces balance once per step: before, at or after its end."""

import math
from typing import ClassVar

import equinox as eqx

from study.keywords import keywords_only
from study.mechanics.balance import acceleration
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_range, check_ranges


class SingleSolve(OneStep):
    r"""The explicit self-starting method GSSE of Li, Yu and Li, with balance at t₀ + CΔt.

    .. math::

        u_c &= u_0 + C\Delta t\,\dot u_0 + \tfrac12 (C\Delta t)^2 \ddot u_0, \quad
            \dot u_c = \dot u_0 + C\Delta t\,\ddot u_0 \\
        M \ddot u_c + C_d \dot u_c + p(u_c) &= f(t_0 + C\Delta t) \\
        u_1 &= u_0 + \Delta t\,\dot u_0 + \Delta t^2 [(\tfrac12 - U)\,\ddot u_0 + U \ddot u_c] \\
        \dot u_1 &= \dot u_0 + \Delta t\,[(1 - V)\,\ddot u_0 + V \ddot u_c], \quad V = 1/(2C) \\
        \ddot u_1 &= \ddot u_0 + (\ddot u_c - \ddot u_0)/C

    where :math:`C_d` is the damping. The principal roots meet at −ρ_b, where the third root is −ρ_s. The coefficients
    follow from these two parameters:

    .. math::

        C &= \frac{2 + \rho_s - \rho_b \rho_s}{(1 + \rho_s)(1 + \rho_b)} \\
        U &= -\frac{\rho_b(\rho_b - 1)\,\rho_s^3 + \tfrac12 (\rho_b - 1)(\rho_b^2 + 6\rho_b - 1)\,\rho_s^2
            + (1 - 5\rho_b)\,\rho_s + 1 - \rho_b}{(1 + \rho_b)(1 + \rho_s)(\rho_b \rho_s - \rho_s - 2)^2}

    Second order, also with damping and load. The damping force is treated explicitly. Stable without damping for
    :math:`\omega\Delta t \le \sqrt{(2C - 1)/(C^2/2 + CU - 1/4)}`. For a linear system of one unknown, the roots are
    those of Hulbert and Chung's method if ρ_s = ρ_b, and those of Chung and Lee's method if C = 1. With C = 1, for
    which :math:`\rho_s = (1/\rho_b - 1)/2`, the method is called ICL. Without damping, ρ_s = 0 and ρ_b = 1 give central
    difference. Carries u, u̇ and the algorithmic ü; one force per step, and one solution with M. The history of a force
    is committed at u₁, not at t₀ + CΔt where the forces balance.

    Parameters
    ----------
    rho_s, rho_b
        0 ≤ ρ_s ≤ ρ_b ≤ 1.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    J. Li, K. Yu, X. Li, Identical second-order single step explicit integration algorithms with dissipation control for
    structural dynamics, Int. J. Numer. Methods Eng. 122(4), 2021, 1089-1132.
    """

    rho_s: float
    rho_b: float
    title: str = eqx.field(default="GSSE", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Li et al. (2021)"
    doi: ClassVar[str] = "10.1002/nme.6574"
    order = 2
    explicit = True

    def __check_init__(self):
        check_ranges(self, rho_b=(0.0, 1.0), rho_s=(0.0, self.rho_b))

    @classmethod
    @keywords_only
    def icl(cls, *, rho_b: float) -> "SingleSolve":
        """The method with the balance at the end of the step, ½ ≤ ρ_b ≤ 1."""
        check_range("SingleSolve.icl", "rho_b", rho_b, 0.5, 1.0)
        return cls(rho_s=(1 / rho_b - 1) / 2, rho_b=rho_b, title="ICL")

    @property
    def _coefficients(self) -> tuple[float, float, float]:
        """C, U and V."""
        s, b = self.rho_s, self.rho_b
        c = (2 + s - b * s) / ((1 + s) * (1 + b))
        numerator = b * (b - 1) * s**3 + (b - 1) * (b**2 + 6 * b - 1) * s**2 / 2 + (1 - 5 * b) * s + 1 - b
        return c, -numerator / ((1 + b) * (1 + s) * (b * s - s - 2) ** 2), 1 / (2 * c)

    @property
    def force_at_end(self) -> bool:
        return self._coefficients[0] >= 1 - 1e-12

    @property
    def stability_limit(self) -> float | None:
        c, weight_u, _ = self._coefficients
        return math.sqrt((2 * c - 1) / (c**2 / 2 + c * weight_u - 1 / 4)) if c > 0.5 else None

    def increment(self, problem, state, t, dt):
        u, v, a = state
        c, weight_u, weight_v = self._coefficients
        part = c * dt
        a_c = acceleration(problem, t + part, u + part * v + part**2 / 2 * a, v + part * a)
        du = dt * v + dt**2 * ((0.5 - weight_u) * a + weight_u * a_c)
        dv = dt * ((1 - weight_v) * a + weight_v * a_c)
        return Motion(du, dv, a + (a_c - a) / c), Effort()


icl = SingleSolve.icl(rho_b=0.8)
