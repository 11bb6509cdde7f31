"""The α-methods: Hilber, Hughes and Taylor's in the form of Xie (1996), and the generalized-α family."""

import math
from typing import ClassVar

import equinox as eqx

from study.keywords import keywords_only
from study.mechanics.balance import at, balance
from study.mechanics.state import Motion
from study.scheme.base import OneStep, check_range, check_ranges
from study.scheme.newmark import ROUND_OFF, bounded_at_infinite_frequency, predicted, stability_limit


def _stability_limit(alpha_m: float, alpha_f: float, beta: float, gamma: float) -> float | None:
    """Stability limit: Newmark's if both α are zero, zero or infinite under the conditions below, None otherwise.

    For small Ω = ωΔt the principal roots have the size 1 + (½ − α_m + α_f − γ) Ω²/2, and for methods of second order
    1 − (α_f − α_m) (β − α_f (1 − α_m)) Ω⁴/2. Chung and Hulbert's conditions, for methods of second order, make the
    limit infinite.
    """
    if alpha_m == alpha_f == 0:
        return stability_limit(beta, gamma)
    shift = alpha_f - alpha_m
    second_order = abs(gamma - (0.5 + shift)) < ROUND_OFF
    if gamma < 0.5 + shift - ROUND_OFF or (second_order and shift * (beta - alpha_f * (1 - alpha_m)) < -ROUND_OFF):
        return 0.0
    return math.inf if second_order and shift >= 0 and beta >= 0.25 + shift / 2 - ROUND_OFF else None


class HHTAlpha1996(OneStep):
    r"""The α-method of Xie (1996), equation (12), with a weighted mean of two internal forces.

    .. math::

        M \ddot u_1 + C \dot u_1 + (1 + \alpha)\,p(u_1) - \alpha\,p(u_0) = f(t_1)

    with Newmark's u₁ and u̇₁. Finite element codes commonly evaluate one force at the weighted displacement instead,
    p((1 + α) u₁ − α u₀), and weight damping and load in the same way (:meth:`study.GeneralizedAlpha.hht`). For a linear
    spring this force equals the weighted mean, for a non-linear spring it does not.

    Second order for γ = ½ − α without damping and load. With damping or load it is of first order, except for α = 0,
    which is Newmark's method. With β = (1 − α)²/4, γ = ½ − α and −⅓ ≤ α ≤ 0 it is unconditionally stable for linear
    systems. Carries u, u̇ and ü; one force per Newton iteration and one force per step. The history of a force is
    committed at u₁, and p(u₀) is evaluated from the history that the previous step committed.

    Parameters
    ----------
    alpha
        −⅓ ≤ α ≤ 0.
    beta, gamma
        0 ≤ β ≤ ½, 0 ≤ γ ≤ 1; by default (1 − α)²/4 and ½ − α.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    H. M. Hilber, T. J. R. Hughes, R. L. Taylor, Improved numerical dissipation for time integration algorithms in
    structural dynamics, Earthquake Eng. Struct. Dyn. 5(3), 1977, 283-292.
    """

    alpha: float
    beta: float = None  # type: ignore[assignment]
    gamma: float = None  # type: ignore[assignment]
    title: str = eqx.field(default="HHT-α (1996)", static=True)

    family: ClassVar[str] = "α-methods"
    source: ClassVar[str] = "Hilber et al. (1977)"
    doi: ClassVar[str] = "10.1002/eqe.4290050306"
    explicit = False
    force_at_end = True

    def __post_init__(self):
        if self.beta is None:
            self.beta = (1 - self.alpha) ** 2 / 4
        if self.gamma is None:
            self.gamma = 0.5 - self.alpha

    def __check_init__(self):
        check_ranges(self, alpha=(-1 / 3, 0.0), beta=(0.0, 0.5), gamma=(0.0, 1.0))

    @property
    def order(self) -> int:
        return 2 if abs(self.gamma - (0.5 - self.alpha)) < 1e-12 else 1

    @property
    def stability_limit(self) -> float | None:
        return _stability_limit(0.0, -self.alpha, self.beta, self.gamma)

    @property
    def acceleration_offset(self) -> float:
        return self.alpha

    @property
    def order_with_damping(self) -> int:
        # eq. (12) weights neither damping nor load
        return self.order if self.alpha == 0 else 1

    @property
    def needs_mass(self) -> bool:
        # at infinite frequency (1 + α) u₁ = α u₀: the root α/(1 + α) is at most ½ in size, so the other two decide
        return not bounded_at_infinite_frequency(self.beta, self.gamma)

    def increment(self, problem, state, t, dt):
        u, v, a = state
        c_u, c_v = self.beta * dt**2, self.gamma * dt
        du, dv = predicted(v, a, dt, self.beta, self.gamma)
        end, f = at(problem, t + dt)
        rhs = f + self.alpha * problem.at_time(t).internal_force(u, v)
        a, effort = balance(end, rhs, u + du, v + dv, c_u, c_v, guess=a, weight=1 + self.alpha)
        return Motion(du + c_u * a, dv + c_v * a, a), effort


class GeneralizedAlpha(OneStep):
    r"""The generalized-α method of Chung and Hulbert; HHT-α and WBZ-α are members of this family.

    .. math::

        M \ddot u_m + C \dot u_f + p(u_f) &= f(t_0 + (1 - \alpha_f)\,\Delta t) \\
        \ddot u_m &= (1 - \alpha_m)\,\ddot u_1 + \alpha_m \ddot u_0 \\
        x_f &= (1 - \alpha_f)\,x_1 + \alpha_f x_0 \quad\text{for } x = u \text{ and } x = \dot u

    with u₁ and u̇₁ by Newmark's formulas. The internal force is evaluated once, at the weighted displacement, as finite
    element codes do. Second order for γ = ½ − α_m + α_f. With this γ, :math:`\beta = (1 - \alpha_m + \alpha_f)^2/4` and
    α_m ≤ α_f ≤ ½ it is unconditionally stable for linear systems, and its spectral radius falls to ρ∞ as ωΔt grows to
    infinity. Carries u, u̇ and the algorithmic ü; one force per Newton iteration. The history of a force is committed at
    u₁, not where the forces balance.

    Parameters
    ----------
    alpha_m, alpha_f
        −1 ≤ α_m ≤ ½, 0 ≤ α_f ≤ ½.
    beta, gamma
        0 ≤ β ≤ 1, 0 ≤ γ ≤ 3/2.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    J. Chung, G. M. Hulbert, A time integration algorithm for structural dynamics with improved numerical dissipation:
    the generalized-α method, J. Appl. Mech. 60(2), 1993, 371-375.
    W. L. Wood, M. Bossak, O. C. Zienkiewicz, An alpha modification of Newmark's method, Int. J. Numer. Methods Eng.
    15(10), 1980, 1562-1566.
    H. M. Hilber, T. J. R. Hughes, R. L. Taylor, Improved numerical dissipation for time integration algorithms in
    structural dynamics, Earthquake Eng. Struct. Dyn. 5(3), 1977, 283-292.
    """

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    title: str = eqx.field(default="Generalized-α", static=True)
    source: str = eqx.field(default="Chung and Hulbert (1993)", static=True)
    doi: str = eqx.field(default="10.1115/1.2900803", static=True)

    family: ClassVar[str] = "α-methods"
    explicit = False

    def __check_init__(self):
        check_ranges(self, alpha_m=(-1.0, 0.5), alpha_f=(0.0, 0.5), beta=(0.0, 1.0), gamma=(0.0, 1.5))

    @classmethod
    @keywords_only
    def optimal(cls, *, alpha_m: float, alpha_f: float, **labels: str) -> "GeneralizedAlpha":
        """The second-order method with the least damping of low frequencies for given α_m and α_f."""
        shift = 0.5 - alpha_m + alpha_f
        return cls(alpha_m=alpha_m, alpha_f=alpha_f, beta=(0.5 + shift) ** 2 / 4, gamma=shift, **labels)

    @classmethod
    @keywords_only
    def chung_hulbert(cls, *, rho_inf: float) -> "GeneralizedAlpha":
        """The generalized-α method for a spectral radius ρ∞ at infinite frequency, 0 ≤ ρ∞ ≤ 1."""
        check_range("GeneralizedAlpha.chung_hulbert", "rho_inf", rho_inf, 0.0, 1.0)
        return cls.optimal(alpha_m=(2 * rho_inf - 1) / (rho_inf + 1), alpha_f=rho_inf / (rho_inf + 1))

    @classmethod
    @keywords_only
    def hht(cls, *, rho_inf: float) -> "GeneralizedAlpha":
        """HHT-α (α_m = 0, α = −α_f) for a spectral radius ρ∞ at infinite frequency, ½ ≤ ρ∞ ≤ 1."""
        check_range("GeneralizedAlpha.hht", "rho_inf", rho_inf, 0.5, 1.0)
        labels = {"title": "HHT-α", "source": HHTAlpha1996.source, "doi": HHTAlpha1996.doi}
        return cls.optimal(alpha_m=0.0, alpha_f=(1 - rho_inf) / (1 + rho_inf), **labels)

    @classmethod
    @keywords_only
    def wbz(cls, *, rho_inf: float) -> "GeneralizedAlpha":
        """WBZ-α (α_f = 0) for a spectral radius ρ∞ at infinite frequency, 0 ≤ ρ∞ ≤ 1."""
        check_range("GeneralizedAlpha.wbz", "rho_inf", rho_inf, 0.0, 1.0)
        labels = {"title": "WBZ-α", "source": "Wood et al. (1980)", "doi": "10.1002/nme.1620151011"}
        return cls.optimal(alpha_m=(rho_inf - 1) / (rho_inf + 1), alpha_f=0.0, **labels)

    @property
    def order(self) -> int:
        return 2 if abs(self.gamma - (0.5 - self.alpha_m + self.alpha_f)) < 1e-12 else 1

    @property
    def stability_limit(self) -> float | None:
        return _stability_limit(self.alpha_m, self.alpha_f, self.beta, self.gamma)

    @property
    def acceleration_offset(self) -> float:
        return self.alpha_m - self.alpha_f

    @property
    def force_at_end(self) -> bool:
        return self.alpha_f == 0

    @property
    def needs_mass(self) -> bool:
        # at infinite frequency u_f = 0: as α_f ≤ ½, the root −α_f/(1 − α_f) is at most 1 in size, so the others decide
        return not bounded_at_infinite_frequency(self.beta, self.gamma)

    def increment(self, problem, state, t, dt):
        u, v, a = state
        part = 1 - self.alpha_f
        # with ü₁ = c_a (ü_m − α_m ü₀) Newmark's formulas hold for ü₀ and ü_m, with c_a β and c_a γ
        c_a = 1 / (1 - self.alpha_m)
        c_u, c_v = part * self.beta * dt**2 * c_a, part * self.gamma * dt * c_a
        du, dv = predicted(v, a, dt, self.beta * c_a, self.gamma * c_a)
        a_m, effort = balance(*at(problem, t + part * dt), u + part * du, v + part * dv, c_u, c_v, guess=a)
        a_new = c_a * (a_m - self.alpha_m * a)
        return Motion(du + self.beta * dt**2 * c_a * a_m, dv + self.gamma * dt * c_a * a_m, a_new), effort


hht_alpha_1996 = HHTAlpha1996(alpha=-0.1, beta=0.3025, gamma=0.6)
hht_alpha = GeneralizedAlpha.hht(rho_inf=0.9 / 1.1)
wbz_alpha = GeneralizedAlpha.wbz(rho_inf=0.8)
generalized_alpha = GeneralizedAlpha.chung_hulbert(rho_inf=0.8)
