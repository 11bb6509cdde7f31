"""Zhang's two-step method with the least damping of low frequencies for its spectral radius: OALTS."""

import math
from typing import ClassVar, NamedTuple

import equinox as eqx

from study.algebra.arrays import Vector
from study.mechanics.balance import at, balance
from study.mechanics.state import Effort
from study.scheme.base import Scheme, check_ranges
from study.scheme.newmark import average_acceleration


class TwoMotions(NamedTuple):
    """Displacement, velocity and acceleration at tₙ and at tₙ₋₁, each of shape () or (n,)."""

    u: Vector
    v: Vector
    a: Vector
    u_1: Vector
    v_1: Vector
    a_1: Vector


class TwoStep(Scheme):
    r"""The optimal A-stable linear two-step method of Zhang, OALTS, for the equation as a first-order system.

    .. math::

        y_1 + A_1 y_0 + A_2 y_{-1} &= \Delta t\,(B_0 \dot y_1 + B_1 \dot y_0 + B_2 \dot y_{-1})
            \quad\text{for } y = u \text{ and } y = \dot u \\
        M \ddot u_1 + C \dot u_1 + p(u_1) &= f(t_1) \\
        A_1 &= \frac{4 \rho_\infty - 4}{3 - \rho_\infty}, \quad A_2 = -1 - A_1,
            \quad B_0 = \frac{2}{(1 + \rho_\infty)(3 - \rho_\infty)} \\
        B_1 &= 2 - 2 B_0 + \tfrac12 A_1, \quad B_2 = \tfrac12 A_1 + B_0

    Second order, unconditionally stable for linear systems, with the spectral radius ρ∞ at infinite frequency. ρ∞ = 0
    is BDF2, ρ∞ = 1 has the solutions of the trapezoidal rule. The average acceleration method, run backwards, finds the
    motion before the start. Carries u, u̇ and ü at two times; one force per Newton iteration. The history of a force is
    committed at u₁, where the forces balance.

    Parameters
    ----------
    rho_inf
        0 ≤ ρ∞ ≤ 1.

    Raises
    ------
    ValueError
        If ρ∞ is out of its range.

    References
    ----------
    J. Zhang, A-stable two-step time integration methods with controllable numerical dissipation for structural
    dynamics, Int. J. Numer. Methods Eng. 121(1), 2020, 54-92.
    """

    rho_inf: float
    title: str = eqx.field(default="OALTS", static=True)

    family: ClassVar[str] = "Multi-step and composite"
    source: ClassVar[str] = "Zhang (2020)"
    doi: ClassVar[str] = "10.1002/nme.6188"
    order = 2
    explicit = False
    stability_limit = math.inf

    def __check_init__(self):
        check_ranges(self, rho_inf=(0.0, 1.0))

    def start(self, problem, u0, v0, dt):
        state, effort = average_acceleration.start(problem, u0, v0, dt)
        previous, more = average_acceleration.step(problem, state, 0.0, -dt)
        return TwoMotions(*state, *previous), effort.then(more)

    def step(self, problem, state, t, dt) -> tuple[TwoMotions, Effort]:
        u, v, a, u_1, v_1, a_1 = state
        rho = self.rho_inf
        a1 = (4 * rho - 4) / (3 - rho)
        a2 = -1 - a1
        b0 = 2 / ((1 + rho) * (3 - rho))
        b1, b2 = 2 - 2 * b0 + a1 / 2, a1 / 2 + b0
        # y₁ = ỹ + c ẏ₁
        c = b0 * dt
        v_new = -a1 * v - a2 * v_1 + dt * (b1 * a + b2 * a_1)
        u_new = -a1 * u - a2 * u_1 + dt * (b1 * v + b2 * v_1) + c * v_new
        a_new, effort = balance(*at(problem, t + dt), u_new, v_new, c**2, c, guess=a)
        return TwoMotions(u_new + c**2 * a_new, v_new + c * a_new, a_new, u, v, a), effort


oalts = TwoStep(rho_inf=0.8)
