"""The classical Runge-Kutta method."""

from typing import ClassVar, NamedTuple

import equinox as eqx
import jax

from study.equilibrium import Effort, acceleration
from study.schemes.scheme import OneStep


class Phase(NamedTuple):
    """Displacement and velocity, each of shape () or (n,)."""

    u: jax.Array
    v: jax.Array


class RungeKutta4(OneStep):
    """The classical fourth order Runge-Kutta method on u̇ = v, v̇ = M⁻¹ (f − C v − p(u)), Xie (1996), eqs (13) to (16).

    y₁ = y₀ + k₁/6 + k₂/3 + k₃/3 + k₄/6,    y = (u, v)
    k₁ = Δt F(t, y₀), k₂ = Δt F(t + Δt/2, y₀ + k₁/2), k₃ = Δt F(t + Δt/2, y₀ + k₂/2), k₄ = Δt F(t + Δt, y₀ + k₃)

    Fourth order, four force evaluations a step, stable for an undamped linear oscillator up to ωΔt = 2√2.

    References
    ----------
    W. Kutta, Beitrag zur näherungsweisen Integration totaler Differentialgleichungen, Z. Math. Phys. 46, 1901,
    435-453.
    """

    title: str = eqx.field(default="Runge-Kutta", kw_only=True, static=True)

    family: ClassVar[str] = "Runge-Kutta"
    source: ClassVar[str] = "Kutta (1901)"
    doi: ClassVar[str] = ""

    @property
    def order(self) -> int:
        return 4

    @property
    def explicit(self) -> bool:
        return True

    @property
    def evaluations(self) -> int:
        return 4

    def start(self, problem, u0, v0, dt):
        return Phase(u0, v0), Effort()

    def increment(self, problem, state, t, dt):
        def k(c, du, dv):
            u, v = state.u + du, state.v + dv
            return dt * v, dt * acceleration(problem, t + c * dt, u, v)

        u1, v1 = k(0.0, 0.0, 0.0)
        u2, v2 = k(0.5, u1 / 2, v1 / 2)
        u3, v3 = k(0.5, u2 / 2, v2 / 2)
        u4, v4 = k(1.0, u3, v3)
        return Phase((u1 + u4) / 6 + (u2 + u3) / 3, (v1 + v4) / 6 + (v2 + v3) / 3), Effort()


rk4 = RungeKutta4()
