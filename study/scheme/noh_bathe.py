"""The explicit method of Noh and Bathe, with two sub-steps and damping of high frequencies."""

from typing import ClassVar

import equinox as eqx

from study.equilibrium.balance import acceleration
from study.equilibrium.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges, start_in_balance


class NohBathe(OneStep):
    """The explicit method of Noh and Bathe, with the sub-steps h = pΔt and k = (1 − p)Δt.

    u_p = u₀ + h u̇₀ + h²/2 ü₀,    M ü_p + C (u̇₀ + h ü₀) + p(u_p) = f(t₀ + h),    u̇_p = u̇₀ + h/2 (ü₀ + ü_p)
    u₁ = u_p + k u̇_p + k²/2 ü_p,    M ü₁ + C (u̇_p + k ü_p) + p(u₁) = f(t₁)
    u̇₁ = u̇_p + k (q₀ ü₀ + (½ + q₁) ü_p + q₂ ü₁)
    q₁ = (1 − 2p)/(2p(1 − p)),    q₂ = ½ − p q₁,    q₀ = ½ − q₁ − q₂

    Second order; with p = 0.54 stable without damping for ωΔt ≤ 3.745, a limit computed from the amplification matrix.
    p = ½ is central difference twice. Carries u, u̇ and ü; two forces a step, and two solutions with
    M. The first sub-step commits the history of a force with a memory.

    Parameters
    ----------
    p
        0.5 ≤ p ≤ 0.9.

    Raises
    ------
    ValueError
        If p is out of its range.

    References
    ----------
    G. Noh, K. J. Bathe, An explicit time integration scheme for the analysis of wave propagations, Comput. Struct. 129,
    2013, 178-193.
    """

    p: float = 0.54
    title: str = eqx.field(default="Noh-Bathe", kw_only=True, static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Noh and Bathe (2013)"
    doi: ClassVar[str] = "10.1016/j.compstruc.2013.06.007"
    order = 2
    explicit = True
    evaluations = 2

    def __check_init__(self):
        check_ranges(self, p=(0.5, 0.9))

    start = start_in_balance

    def increment(self, problem, state, t, dt):
        u, v, a = state
        p, h, k = self.p, self.p * dt, (1 - self.p) * dt
        q1 = (1 - 2 * p) / (2 * p * (1 - p))
        q2 = 0.5 - p * q1
        q0 = 0.5 - q1 - q2
        du = h * v + h**2 / 2 * a
        a_p = acceleration(problem, t + h, u + du, v + h * a)
        dv = h / 2 * (a + a_p)
        problem = problem.committed(u + du, v + dv)
        du = du + k * (v + dv) + k**2 / 2 * a_p
        a_new = acceleration(problem, t + dt, u + du, v + dv + k * a_p)
        new = Motion(du, dv + k * (q0 * a + (0.5 + q1) * a_p + q2 * a_new), a_new)
        return new, Effort(committed=problem.history)


noh_bathe = NohBathe()
