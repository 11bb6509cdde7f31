"""Explicit generalized-α methods: Chung and Lee's, and Hulbert and Chung's."""

import math
from typing import ClassVar

import equinox as eqx

from study.keywords import keywords_only
from study.mechanics.balance import acceleration
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_range, check_ranges
from study.scheme.newmark import ROUND_OFF, corrected


class ExplicitAlpha(OneStep):
    r"""The explicit generalized-α method of Hulbert and Chung: balance with the displacement and velocity at t₀.

    .. math::

        M [(1 - \alpha_m)\,\ddot u_1 + \alpha_m \ddot u_0] + C \dot u_0 + p(u_0) &= f(t_0) \\
        u_1 &= u_0 + \Delta t\,\dot u_0 + \Delta t^2 (\tfrac12 - \beta)\,\ddot u_0 + \Delta t^2 \beta\,\ddot u_1 \\
        \dot u_1 &= \dot u_0 + \Delta t\,(1 - \gamma)\,\ddot u_0 + \Delta t\,\gamma\,\ddot u_1

    Second order for γ = 3/2 − α_m; stable without damping for
    :math:`\omega\Delta t \le \sqrt{2(1 - 2\alpha_m)/(2\beta - \gamma)}`. The parameters of ``hulbert_chung`` follow
    from the spectral radius ρ_b at :math:`\omega\Delta t = (1 + \rho_b)\sqrt{2 - \rho_b}`, where the principal roots
    meet:

    .. math::

        \alpha_m = \frac{2\rho_b - 1}{1 + \rho_b}, \quad \beta = \frac{5 - 3\rho_b}{(1 + \rho_b)^2 (2 - \rho_b)}

    α_m = 0 with 1 ≤ β ≤ 28/27 is the method of Chung and Lee: β = 1 does not damp, β = 28/27 gives ρ_b = ½. Carries u,
    u̇ and the algorithmic ü; one force per step, and one solution with M. The history of a force is committed at u₁.

    Parameters
    ----------
    alpha_m, beta, gamma
        −1 ≤ α_m ≤ ½, 0 ≤ β ≤ 5, 0 ≤ γ ≤ 5/2.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    G. M. Hulbert, J. Chung, Explicit time integration algorithms for structural dynamics with optimal numerical
    dissipation, Comput. Methods Appl. Mech. Eng. 137(2), 1996, 175-188.
    J. Chung, J. M. Lee, A new family of explicit time integration methods for linear and non-linear structural
    dynamics, Int. J. Numer. Methods Eng. 37(23), 1994, 3961-3976.
    """

    alpha_m: float
    beta: float
    gamma: float
    title: str = eqx.field(default="Hulbert-Chung", static=True)
    source: str = eqx.field(default="Hulbert and Chung (1996)", static=True)
    doi: str = eqx.field(default="10.1016/S0045-7825(96)01036-5", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    explicit = True

    def __check_init__(self):
        check_ranges(self, alpha_m=(-1.0, 0.5), beta=(0.0, 5.0), gamma=(0.0, 2.5))

    @classmethod
    @keywords_only
    def hulbert_chung(cls, *, rho_b: float) -> "ExplicitAlpha":
        """The method for a spectral radius ρ_b where the principal roots meet, 0 ≤ ρ_b ≤ 1."""
        check_range("ExplicitAlpha.hulbert_chung", "rho_b", rho_b, 0.0, 1.0)
        alpha_m = (2 * rho_b - 1) / (1 + rho_b)
        return cls(alpha_m=alpha_m, beta=(5 - 3 * rho_b) / ((1 + rho_b) ** 2 * (2 - rho_b)), gamma=1.5 - alpha_m)

    @classmethod
    @keywords_only
    def chung_lee(cls, *, beta: float) -> "ExplicitAlpha":
        """The method of Chung and Lee, 1 ≤ β ≤ 28/27."""
        check_range("ExplicitAlpha.chung_lee", "beta", beta, 1.0, 28 / 27)
        labels = {"title": "Chung-Lee", "source": "Chung and Lee (1994)", "doi": "10.1002/nme.1620372303"}
        return cls(alpha_m=0.0, beta=beta, gamma=1.5, **labels)

    @property
    def order(self) -> int:
        return 2 if math.isclose(self.gamma, 1.5 - self.alpha_m) else 1

    @property
    def stability_limit(self) -> float | None:
        # for small Ω = ωΔt the principal roots have the size 1 + (3/2 − α_m − γ) Ω²/2, and for methods of second order
        # 1 + (1 − α_m) (1 − α_m − β) Ω⁴/2
        damping = self.gamma - (1.5 - self.alpha_m) if self.order == 1 else self.beta - (1 - self.alpha_m)
        if damping < -ROUND_OFF:
            return 0.0
        if self.order == 1 or 2 * self.beta <= self.gamma:
            return None
        return math.sqrt(2 * (1 - 2 * self.alpha_m) / (2 * self.beta - self.gamma))

    @property
    def acceleration_offset(self) -> float:
        return self.alpha_m - 1

    def increment(self, problem, state, t, dt):
        u, v, a = state
        a_new = (acceleration(problem, t, u, v) - self.alpha_m * a) / (1 - self.alpha_m)
        du, dv = corrected(v, a, a_new, dt, self.beta, self.gamma)
        return Motion(du, dv, a_new), Effort()


chung_lee = ExplicitAlpha.chung_lee(beta=28 / 27)
hulbert_chung = ExplicitAlpha.hulbert_chung(rho_b=0.8)
