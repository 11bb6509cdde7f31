"""The explicit method of Tchamwa and Wielgosz, of first order, with damping of high frequencies."""

from typing import ClassVar

import equinox as eqx

from study.equilibrium.balance import acceleration
from study.equilibrium.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges, start_in_balance


class TchamwaWielgosz(OneStep):
    """The method of Tchamwa and Wielgosz.

    u₁ = u₀ + Δt u̇₀ + φ Δt² ü₀,    u̇₁ = u̇₀ + Δt ü₀
    M ü₁ + C u̇₁ + p(u₁) = f(t₁)

    First order. Without damping φ = 1 is the symplectic Euler method; φ > 1 damps high frequencies. Stable without
    damping for ωΔt ≤ 2/√(2φ − 1). Carries u, u̇ and ü; one force a step. A force with a history commits it at u₁, where
    the balance is.

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
    title: str = eqx.field(default="Tchamwa-Wielgosz", kw_only=True, static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Tchamwa et al. (1999)"
    doi: ClassVar[str] = ""
    order = 1
    explicit = True
    evaluations = 1

    def __check_init__(self):
        check_ranges(self, phi=(1.0, 2.0))

    start = start_in_balance

    def increment(self, problem, state, t, dt):
        u, v, a = state
        du, dv = dt * v + self.phi * dt**2 * a, dt * a
        return Motion(du, dv, acceleration(problem, t + dt, u + du, v + dv)), Effort()


tchamwa_wielgosz = TchamwaWielgosz()
