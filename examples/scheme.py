"""A scheme of one's own, assessed beside those of the study.

    study assess examples/driven.py:driven --schemes examples/scheme.py:heun rk4 --duration 100 --output heun

Heun's method is of second order, and unstable for free motion without damping at any step.
"""

from typing import ClassVar

import equinox as eqx
import numpy as np

import study


class Heun(study.OneStep):
    """Heun's method on u̇ = v, v̇ = F(t, u, v): a step by Euler's rule, then the mean of both slopes.

    u₁ = u₀ + Δt/2 (u̇₀ + u̇*),    u̇₁ = u̇₀ + Δt/2 (F(t₀, u₀, u̇₀) + F(t₁, u*, u̇*))
    u* = u₀ + Δt u̇₀,    u̇* = u̇₀ + Δt F(t₀, u₀, u̇₀)
    """

    title: str = eqx.field(default="Heun", kw_only=True, static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Heun (1900)"
    doi: ClassVar[str] = ""
    order = 2
    explicit = True
    evaluations = 2

    def start(self, problem, u0, v0, dt):
        return study.Phase(u0, v0), study.Effort()

    def increment(self, problem, state, t, dt):
        u, v = state
        slope = study.acceleration(problem, t, u, v)
        ahead = study.acceleration(problem, t + dt, u + dt * v, v + dt * slope)
        return study.Phase(dt * v + dt**2 / 2 * slope, dt / 2 * (slope + ahead)), study.Effort()


heun = Heun()

if __name__ == "__main__":
    theory = study.LinearTheory(heun, np.logspace(-3, 0, 31))
    print(f"order {theory.order():.2f}, stable up to ωΔt = {theory.stability_limit():.2f}")
