"""The explicit KR-α methods of Kolay and Ricles, with a linear model of the structure in their coefficients."""

import math
from typing import ClassVar

import equinox as eqx

from study.algebra.elimination import solve
from study.algebra.matrices import add, product, times
from study.mechanics.balance import acceleration
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges
from study.scheme.model_based import mass_of, model


class KolayRicles(OneStep):
    r"""The KR-α method: unconditionally stable for a linear structure, without iteration for a non-linear one.

    With the stiffness K = ∂p/∂u of the undeformed structure at rest, :math:`G = \gamma\Delta t\,C + \beta\Delta t^2 K`
    and S = M + G, where the C in G includes ∂p/∂u̇,

    .. math::

        \dot u_1 &= \dot u_0 + \Delta t\,S^{-1} M \ddot u_0 \\
        u_1 &= u_0 + \Delta t\,\dot u_0 + (\tfrac12 + \gamma)\,\Delta t^2 S^{-1} M \ddot u_0 \\
        M \ddot u_m + C \dot u_f + p(u_f) &= f(t_f),
            \quad x_f = (1 - \alpha_f)\,x_1 + \alpha_f x_0 \quad\text{for } x = t, u, \dot u \\
        S \ddot u_m &= [(1 - \alpha_m) M + (1 - \alpha_f) G]\,\ddot u_1 + [\alpha_m M + \alpha_f G]\,\ddot u_0

    α_m, α_f, β and γ are the parameters of the generalized-α method for ρ∞. For a linear structure both methods have
    the same eigenvalues: accurate to second order, and stable at every step size. The modified method, MKR-α, has

    .. math::

        \alpha_m = \frac{2 \rho_\infty^3 + \rho_\infty^2 - 1}{\rho_\infty^3 + \rho_\infty^2 + \rho_\infty + 1},
            \quad \alpha_f = \frac{\rho_\infty}{\rho_\infty + 1}, \quad \gamma = \tfrac12 - \alpha_m + \alpha_f,
            \quad \beta = \tfrac12 (\tfrac12 + \gamma)

    and the roots ±iρ∞ and −ρ∞ at infinite frequency in place of −ρ∞ three times. The carried velocity lags by γΔt, so a
    motion that starts with an acceleration is of first order; from :math:`\dot u_0 - \gamma\Delta t\,\ddot u_0` it is
    of second order, unless the force is non-linear in the velocity. The method was published as stable for structures
    that soften. If the tangent k exceeds K, as in a structure that hardens, eigenvalues may exceed one. Without damping
    they exceed one for ρ∞ = 1 if k > K + 4/Δt² M, and for ρ∞ = 0.8 at every step size if k is at least 1.05 K, with
    MKR-α 1.8 K; for small step sizes the excess is slight. Carries u, u̇ and ü; one force per step, because K is the
    same in all steps, and three solutions of linear systems. The history of a force is committed at u₁; K remains the
    stiffness at rest.

    Parameters
    ----------
    rho_inf
        0 ≤ ρ∞ ≤ 1.
    modified
        Whether to take the parameters of MKR-α.

    Raises
    ------
    ValueError
        If ρ∞ is out of its range.

    References
    ----------
    C. Kolay, J. M. Ricles, Development of a family of unconditionally stable explicit direct integration algorithms
    with controllable numerical energy dissipation, Earthquake Eng. Struct. Dyn. 43(9), 2014, 1361-1380.
    C. Kolay, J. M. Ricles, Improved explicit integration algorithms for structural dynamic analysis with unconditional
    stability and controllable numerical dissipation, J. Earthquake Eng. 23(5), 2019, 771-792.
    """

    rho_inf: float
    modified: bool = eqx.field(default=False, static=True)
    title: str = eqx.field(default="KR-α", static=True)
    source: str = eqx.field(default="Kolay and Ricles (2014)", static=True)
    doi: str = eqx.field(default="10.1002/eqe.2401", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    order = 1
    #: The scheme is of first order only because its velocity lags.
    order_of_loss = 3.0
    explicit = True
    stability_limit = math.inf

    def __check_init__(self):
        check_ranges(self, rho_inf=(0.0, 1.0))

    @property
    def _weights(self) -> tuple[float, float]:
        """α_m and α_f."""
        rho = self.rho_inf
        numerator = 2 * rho**3 + rho**2 - 1 if self.modified else (2 * rho - 1) * (rho**2 + 1)
        return numerator / ((rho + 1) * (rho**2 + 1)), rho / (rho + 1)

    @property
    def velocity_lag(self) -> float:
        """The lag γ of the carried velocity in steps."""
        alpha_m, alpha_f = self._weights
        return 0.5 - alpha_m + alpha_f

    def increment(self, problem, state, t, dt):
        u, v, a = state
        (alpha_m, alpha_f), gamma = self._weights, self.velocity_lag
        beta = (0.5 + gamma) / 2 if self.modified else (0.5 + gamma) ** 2 / 4
        mass, n = mass_of(problem), u.size
        matrix = model(problem, u, gamma * dt, beta * dt**2)

        def mixed(mass_weight, model_weight):
            return add(product(mass_weight, mass, n), product(model_weight, matrix, n), n=n)

        effective, new, old = mixed(1.0, 1.0), mixed(1 - alpha_m, 1 - alpha_f), mixed(alpha_m, alpha_f)

        step = solve(effective, times(mass, a))
        du, dv = dt * v + (0.5 + gamma) * dt**2 * step, dt * step
        part = 1 - alpha_f
        a_m = acceleration(problem, t + part * dt, u + part * du, v + part * dv)
        return Motion(du, dv, solve(new, times(effective, a_m) - times(old, a))), Effort()


kr_alpha = KolayRicles(rho_inf=0.8)
mkr_alpha = KolayRicles(
    rho_inf=0.8,
    modified=True,
    title="MKR-α",
    source="Kolay and Ricles (2019)",
    doi="10.1080/13632469.2017.1326423",
)
