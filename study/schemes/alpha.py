"""The α-method of Hilber, Hughes and Taylor, in the form of 1996."""

from typing import ClassVar

import equinox as eqx

from study.equilibrium import Motion, balance, load
from study.schemes.scheme import OneStep, check_range, start_in_balance


class HHTAlpha(OneStep):
    """The α-method as Xie (1996), eq. (12), has it: two internal forces are weighted.

    M ü₁ + C u̇₁ + (1 + α) p(u₁) − α p(u₀) = f(t₁), with Newmark's u₁ and u̇₁.

    Finite element codes commonly evaluate one force at the weighted displacement instead, p((1 + α) u₁ − α u₀), and
    weight damping and load alike; for a linear spring the internal forces agree, for a non-linear one they differ.

    Second order without damping and load for γ = ½ − α, and then unconditionally stable for linear systems if
    β = (1 − α)²/4 and −⅓ ≤ α ≤ 0. α = 0 is Newmark's method.

    Parameters
    ----------
    alpha
        −⅓ ≤ α ≤ 0.
    beta, gamma
        0 ≤ β ≤ ½, 0 ≤ γ ≤ 1.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    H. M. Hilber, T. J. R. Hughes, R. L. Taylor, Improved numerical dissipation for time integration algorithms in
    structural dynamics, Earthquake Eng. Struct. Dyn. 5, 1977, 283-292.
    """

    alpha: float
    beta: float
    gamma: float
    title: str = eqx.field(default="α-method", kw_only=True, static=True)

    family: ClassVar[str] = "α-methods"
    source: ClassVar[str] = "Hilber et al. (1977)"
    doi: ClassVar[str] = "10.1002/eqe.4290050306"

    def __check_init__(self):
        check_range(self, "alpha", -1 / 3, 0.0)
        check_range(self, "beta", 0.0, 0.5)
        check_range(self, "gamma", 0.0, 1.0)

    @property
    def order(self) -> int:
        return 2 if abs(self.gamma - (0.5 - self.alpha)) < 1e-12 else 1

    @property
    def explicit(self) -> bool:
        return False

    @property
    def evaluations(self) -> int:
        return 1

    start = start_in_balance

    def increment(self, problem, state, t, dt):
        u, v, a = state
        c_u, c_v = self.beta * dt**2, self.gamma * dt
        du = dt * v + dt**2 * (0.5 - self.beta) * a
        dv = dt * (1 - self.gamma) * a
        rhs = load(problem, t + dt) + self.alpha * problem.force(u)
        a, effort = balance(problem, rhs, u + du, v + dv, c_u, c_v, guess=a, weight=1 + self.alpha)
        return Motion(du + c_u * a, dv + c_v * a, a), effort


hht_alpha = HHTAlpha(alpha=-0.1, beta=0.3025, gamma=0.6)
