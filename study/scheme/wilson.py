"""Wilson's θ-method."""

import math
from typing import ClassVar

import equinox as eqx
import numpy as np

from study.mechanics.balance import at, balance
from study.mechanics.state import Motion
from study.scheme.base import OneStep, check_ranges
from study.scheme.newmark import ROUND_OFF, corrected, stability_limit

#: Tolerance for round-off in the condition that no root exceeds one in size. Where two roots meet, half of their digits
#: are lost.
GROWTH = 1e-6


class WilsonTheta(OneStep):
    r"""The Wilson-θ method, Xie (1996), eqs (8) to (10): balance beyond the step, then interpolation of ü back to t₁.

    With τ = θΔt,

    .. math::

        u_\theta &= u_0 + \tau \dot u_0 + \tau^2 (\tfrac12 - \beta)\,\ddot u_0 + \tau^2 \beta\,\ddot u_\theta \\
        \dot u_\theta &= \dot u_0 + \tau (1 - \gamma)\,\ddot u_0 + \tau \gamma\,\ddot u_\theta \\
        M \ddot u_\theta + C \dot u_\theta + p(u_\theta) &= f(t_0 + \tau) \\
        \ddot u_1 &= (1 - 1/\theta)\,\ddot u_0 + \ddot u_\theta / \theta

    and then u₁ and u̇₁ by Newmark's formulas.

    Second order for γ = ½, first order otherwise. θ = 1 is Newmark's method (linear acceleration for β = 1/6). With β =
    1/6 and γ = ½ it is unconditionally stable for linear systems if θ ≥ (1 + √3)/2 ≈ 1.366. Carries u, u̇ and ü; one
    force per Newton iteration. The history of a force is committed at u₁, not at t₀ + θΔt where the forces balance.

    Parameters
    ----------
    theta
        θ ≥ 1.
    beta, gamma
        0 ≤ β ≤ ½, 0 ≤ γ ≤ 1.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    E. L. Wilson, I. Farhoomand, K. J. Bathe, Nonlinear dynamic analysis of complex structures, Earthquake Eng. Struct.
    Dyn. 1(3), 1973, 241-252.
    """

    theta: float = 1.4
    beta: float = 1 / 6
    gamma: float = 0.5
    title: str = eqx.field(default="Wilson-θ", static=True)

    family: ClassVar[str] = "Newmark and Wilson"
    source: ClassVar[str] = "Wilson et al. (1973)"
    doi: ClassVar[str] = "10.1002/eqe.4290010305"
    explicit = False
    acceleration_offset = 0.0
    force_at_end = True

    def __check_init__(self):
        check_ranges(self, theta=(1.0, float("inf")), beta=(0.0, 0.5), gamma=(0.0, 1.0))

    @property
    def order(self) -> int:
        return 2 if self.gamma == 0.5 else 1

    @property
    def stability_limit(self) -> float | None:
        if self.theta == 1:
            return stability_limit(self.beta, self.gamma)
        # for small Ω = ωΔt the principal roots have the size 1 + (½ − γ) Ω²/2, and for γ = ½
        # 1 + θ (θ − 1) (2β (θ + 1) − θ) Ω⁴/4
        grows = self.gamma == 0.5 and 2 * self.beta * (self.theta + 1) > self.theta + ROUND_OFF
        if self.gamma < 0.5 or grows:
            return 0.0
        return math.inf if (self.beta, self.gamma) == (1 / 6, 0.5) and self.theta >= (1 + math.sqrt(3)) / 2 else None

    @property
    def needs_mass(self) -> bool:
        if self.beta == 0:  # u_θ does not depend on ü_θ
            return True
        return bool(np.abs(np.linalg.eigvals(self._amplification_at_infinity())).max() > 1 + GROWTH)

    def _amplification_at_infinity(self) -> np.ndarray:
        """Amplification matrix (3, 3) of (u, Δt u̇, Δt² ü) at infinite frequency, where the balance makes u_θ zero."""
        theta, beta, gamma = float(self.theta), float(self.beta), float(self.gamma)
        u, v, a = np.eye(3)
        a_theta = -(u + theta * v + theta**2 * (0.5 - beta) * a) / (beta * theta**2)
        a_new = (1 - 1 / theta) * a + a_theta / theta
        du, dv = corrected(v, a, a_new, 1.0, beta, gamma)
        return np.stack([u + du, v + dv, a_new])

    def increment(self, problem, state, t, dt):
        u, v, a = state
        tau = self.theta * dt
        # ``predicted`` is not used: it adds the terms in another order, which changes the round-off
        u_predicted = u + tau * v + tau**2 * (0.5 - self.beta) * a
        v_predicted = v + tau * (1 - self.gamma) * a
        a_theta, effort = balance(
            *at(problem, t + tau), u_predicted, v_predicted, self.beta * tau**2, self.gamma * tau, guess=a
        )
        a_new = (1 - 1 / self.theta) * a + a_theta / self.theta
        du, dv = corrected(v, a, a_new, dt, self.beta, self.gamma)
        return Motion(du, dv, a_new), effort


wilson_theta = WilsonTheta(theta=1.4)
