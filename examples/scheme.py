"""Your own scheme, compared with those of the study.

    study assess examples/driven.py:driven --schemes examples/scheme.py:heun rk4 \
        --duration 100 --output heun

Heun's method is of second order. Without damping it is unstable at any step size.
"""

from typing import ClassVar

import equinox as eqx
import numpy as np

import study
from study.building import Effort, Phase, acceleration


class Heun(study.OneStep):
    r"""Heun's method on u̇ = v, v̇ = F(t, u, v): the mean of two slopes.

    The second slope is taken at the end point of an Euler step.

    .. math::

        u_* &= u_0 + \Delta t\,\dot u_0 \\
        \dot u_* &= \dot u_0 + \Delta t\,F(t_0, u_0, \dot u_0) \\
        u_1 &= u_0 + \tfrac12 \Delta t\,(\dot u_0 + \dot u_*) \\
        \dot u_1 &= \dot u_0 + \tfrac12 \Delta t\,
            (F(t_0, u_0, \dot u_0) + F(t_1, u_*, \dot u_*))
    """

    title: str = eqx.field(default="Heun", kw_only=True, static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Heun (1900)"
    doi: ClassVar[str] = ""
    order = 2
    explicit = True
    stability_limit = 0.0

    def start(self, problem, u0, v0, dt):
        return Phase(u0, v0), Effort()

    def increment(self, problem, state, t, dt):
        u, v = state
        slope = acceleration(problem, t, u, v)
        ahead = acceleration(problem, t + dt, u + dt * v, v + dt * slope)
        return Phase(dt * v + dt**2 / 2 * slope, dt / 2 * (slope + ahead)), Effort()


heun = Heun()

if __name__ == "__main__":
    theory = study.LinearTheory(heun, np.logspace(-3, 0, 31))
    print(f"order {theory.order():.2f}, stable up to ωΔt = {theory.stability_limit():.2f}")
