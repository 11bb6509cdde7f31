"""Newmark's family, with the average acceleration method and central difference."""

from typing import ClassVar

import equinox as eqx

from study.algebra.arrays import ScalarLike, Vector
from study.equilibrium.balance import acceleration_within, balance, load
from study.equilibrium.state import Effort, Motion
from study.problem.definition import Problem
from study.scheme.base import OneStep, check_ranges, start_in_balance
from study.scheme.newmark_formulas import bounded_at_infinite_frequency, predicted


class Newmark(OneStep):
    """The Newmark method, Xie (1996), eqs (6) and (7).

    u₁ = u₀ + Δt u̇₀ + Δt² (½ − β) ü₀ + Δt² β ü₁
    u̇₁ = u̇₀ + Δt (1 − γ) ü₀ + Δt γ ü₁
    M ü₁ + C u̇₁ + p(u₁) = f(t₁)

    Second order for γ = ½, first order otherwise. Unconditionally stable for linear systems if 2β ≥ γ ≥ ½. With γ > ½
    high frequencies are damped. Carries u, u̇ and ü; one force a Newton iteration. A force with a
    history commits it at u₁, where the balance is. Members of the family:

    - β = ¼, γ = ½, average acceleration, the trapezoidal rule;
    - β = 1/6, γ = ½, linear acceleration, stable for ωΔt ≤ 2√3;
    - β = 1/12, γ = ½, Fox and Goodwin, stable for ωΔt ≤ √6; its displacement is of fourth order for undamped motion
      from rest (Numerov's formula);
    - β = 0, γ = ½, central difference, which takes one force a step and no iteration, and is stable for ωΔt ≤ 2.

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
    title: str = eqx.field(default="Newmark", kw_only=True, static=True)
    source: str = eqx.field(default="Newmark (1959)", kw_only=True, static=True)
    doi: str = eqx.field(default="10.1061/JMCEA3.0000098", kw_only=True, static=True)

    family: ClassVar[str] = "Newmark and Wilson"

    def __check_init__(self):
        check_ranges(self, beta=(0.0, 0.5), gamma=(0.0, 1.0))

    @property
    def order(self) -> int:
        if isinstance(self.beta, float) and self.beta == 1 / 12 and self.gamma == 0.5:
            return 4
        return self.damped_order

    @property
    def damped_order(self) -> int:
        return 2 if self.gamma == 0.5 else 1

    @property
    def explicit(self) -> bool:
        return isinstance(self.beta, float | int) and self.beta == 0

    @property
    def evaluations(self) -> int:
        return 1 if self.explicit else 0

    @property
    def needs_mass(self) -> bool:
        return not bounded_at_infinite_frequency(self.beta, self.gamma)

    start = start_in_balance

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
        return balance(problem, load(problem, t), u, v, c_u, c_v, guess)


average_acceleration = Newmark(beta=0.25, gamma=0.5, title="Average acceleration")
central_difference = Newmark(beta=0.0, gamma=0.5, title="Central difference")
newmark_dissipative = Newmark(beta=0.3025, gamma=0.6, title="Newmark, γ = 0.6")
linear_acceleration = Newmark(beta=1 / 6, gamma=0.5, title="Linear acceleration")
fox_goodwin = Newmark(
    beta=1 / 12, gamma=0.5, title="Fox-Goodwin", source="Fox and Goodwin (1949)", doi="10.1017/S0305004100025007"
)
