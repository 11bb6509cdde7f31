"""Newmark's family, with the average acceleration method and central difference."""

import math
from typing import ClassVar

import equinox as eqx

from study.algebra.arrays import ScalarLike, Vector, VectorLike
from study.mechanics.balance import acceleration_within, at, balance
from study.mechanics.definition import Problem
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges

#: Tolerance for round-off in conditions on parameters.
ROUND_OFF = 1e-12


def predicted(
    v: VectorLike, a: VectorLike, dt: ScalarLike, beta: ScalarLike, gamma: ScalarLike
) -> tuple[VectorLike, VectorLike]:
    """Increments of u and u̇ without the terms of ü₁: Δt u̇₀ + Δt² (½ − β) ü₀ and Δt (1 − γ) ü₀."""
    return dt * v + dt**2 * (0.5 - beta) * a, dt * (1 - gamma) * a


def corrected(
    v: VectorLike, a: VectorLike, a_new: VectorLike, dt: ScalarLike, beta: ScalarLike, gamma: ScalarLike
) -> tuple[VectorLike, VectorLike]:
    """Increments of u and u̇ by Newmark's formulas, with ü₁ known."""
    return dt * v + dt**2 * ((0.5 - beta) * a + beta * a_new), dt * ((1 - gamma) * a + gamma * a_new)


def stability_limit(beta: float, gamma: float) -> float:
    """Largest ωΔt at which Newmark's method is stable without damping: 1/√(γ/2 − β) if γ ≥ ½ and 2β < γ.

    It is zero if γ < ½, and infinite if 2β ≥ γ ≥ ½.
    """
    if gamma < 0.5:
        return 0.0
    return math.inf if 2 * beta >= gamma - ROUND_OFF else 1 / math.sqrt(gamma / 2 - beta)


def bounded_at_infinite_frequency(beta: float, gamma: float) -> bool:
    """Whether velocity and acceleration of an unknown without mass stay bounded under Newmark's formulas.

    A balance of such an unknown prescribes its displacement. With u₀ = u₁ = 0 the formulas give ü₁ only if β > 0, and
    their roots solve β λ² + (½ + γ − 2β) λ + (½ − γ + β) = 0. Neither root exceeds one in size if 2β ≥ γ ≥ ½.
    """
    return bool(beta > 0 and 2 * beta >= gamma - ROUND_OFF and gamma >= 0.5 - ROUND_OFF)


class Newmark(OneStep):
    r"""The Newmark method, Xie (1996), eqs (6) and (7).

    .. math::

        u_1 &= u_0 + \Delta t\,\dot u_0 + \Delta t^2 (\tfrac12 - \beta)\,\ddot u_0 + \Delta t^2 \beta\,\ddot u_1 \\
        \dot u_1 &= \dot u_0 + \Delta t\,(1 - \gamma)\,\ddot u_0 + \Delta t\,\gamma\,\ddot u_1 \\
        M \ddot u_1 + C \dot u_1 + p(u_1) &= f(t_1)

    Second order for γ = ½, first order otherwise. Unconditionally stable for linear systems if 2β ≥ γ ≥ ½. If γ ≥ ½ and
    2β < γ, it is stable without damping for ωΔt ≤ 1/√(γ/2 − β). With γ > ½ high frequencies are damped. Carries u, u̇
    and ü; one force per Newton iteration. The history of a force is committed at u₁, where the forces balance. Members
    of the family:

    - β = ¼, γ = ½, average acceleration, the trapezoidal rule;
    - β = 1/6, γ = ½, linear acceleration, stable for :math:`\omega\Delta t \le 2\sqrt 3`;
    - β = 1/12, γ = ½, Fox and Goodwin, stable for :math:`\omega\Delta t \le \sqrt 6`; its displacement is of fourth
      order for undamped free motion from rest alone (Numerov's formula), because the first step from a velocity errs;
    - β = 0, γ = ½, central difference, stable for ωΔt ≤ 2; it takes one force per step, and no iteration unless the
      force depends on the velocity. With steps that alternate between h and H ≥ h it is stable for
      :math:`\omega^2 H (h + H) \le 4`, and again where :math:`\omega^2 h (h + H) \ge 4` and
      :math:`\omega^2 h H \le 4`.

    Parameters
    ----------
    beta
        0 ≤ β ≤ ½.
    gamma
        0 ≤ γ ≤ 1.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    N. M. Newmark, A method of computation for structural dynamics, J. Eng. Mech. Div. ASCE 85(EM3), 1959, 67-94.
    L. Fox, E. T. Goodwin, Some new methods for the numerical integration of ordinary differential equations, Math.
    Proc. Cambridge Philos. Soc. 45(3), 1949, 373-388.
    """

    beta: float
    gamma: float
    title: str = eqx.field(default="Newmark", static=True)
    source: str = eqx.field(default="Newmark (1959)", static=True)
    doi: str = eqx.field(default="10.1061/JMCEA3.0000098", static=True)

    family: ClassVar[str] = "Newmark and Wilson"
    acceleration_offset = 0.0
    force_at_end = True

    def __check_init__(self):
        check_ranges(self, beta=(0.0, 0.5), gamma=(0.0, 1.0))

    @property
    def keeps_energy(self) -> bool:
        return self.gamma == 0.5

    @property
    def order(self) -> int:
        return 2 if self.gamma == 0.5 else 1

    @property
    def stability_limit(self) -> float:
        return stability_limit(self.beta, self.gamma)

    @property
    def explicit(self) -> bool:
        return isinstance(self.beta, float | int) and self.beta == 0

    @property
    def needs_mass(self) -> bool:
        return not bounded_at_infinite_frequency(self.beta, self.gamma)

    def increment(self, problem, state, t, dt):
        u, v, a = state
        c_u, c_v = self.beta * dt**2, self.gamma * dt
        du, dv = predicted(v, a, dt, self.beta, self.gamma)
        a, effort = self.new_acceleration(problem, t + dt, u + du, v + dv, c_u, c_v, guess=a)
        return Motion(du + c_u * a, dv + c_v * a, a), effort

    def new_acceleration(
        self, problem: Problem, t: ScalarLike, u: Vector, v: Vector, c_u: ScalarLike, c_v: ScalarLike, guess: Vector
    ) -> tuple[Vector, Effort]:
        """ü₁ that balances the forces at the end of the step, and the effort to find it."""
        if self.explicit:
            return acceleration_within(problem, t, u, v, c_v, guess)
        return balance(*at(problem, t), u, v, c_u, c_v, guess)


average_acceleration = Newmark(beta=0.25, gamma=0.5, title="Average acceleration")
central_difference = Newmark(beta=0.0, gamma=0.5, title="Central difference")
newmark_dissipative = Newmark(beta=0.3025, gamma=0.6, title="Newmark, γ = 0.6")
linear_acceleration = Newmark(beta=1 / 6, gamma=0.5, title="Linear acceleration")
fox_goodwin = Newmark(
    beta=1 / 12, gamma=0.5, title="Fox-Goodwin", source="Fox and Goodwin (1949)", doi="10.1017/S0305004100025007"
)
