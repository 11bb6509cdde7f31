"""Backward differences for displacement and velocity: BDF2 and Park's method."""

import math
from typing import ClassVar, NamedTuple

import equinox as eqx
import numpy as np

from study.algebra.arrays import Vector
from study.mechanics.balance import at, balance
from study.mechanics.state import Effort, Motion
from study.scheme.base import Scheme, as_tuple, check_numbers
from study.scheme.newmark import ROUND_OFF, average_acceleration

#: Value of ωΔt at which a method that grows counts as unstable at every step size.
SMALL = 0.05


class Memory(NamedTuple):
    """Motion at tₙ, and displacement and velocity at tₙ₋₁, tₙ₋₂, ..., each of shape () or (n,)."""

    u: Vector
    v: Vector
    a: Vector
    older: tuple[tuple[Vector, Vector], ...]


class BackwardDifferences(Scheme):
    r"""Backward differences for the equation as a first-order system, with the weights d.

    .. math::

        \Delta t\,\dot y_1 &= d_0 y_1 + d_1 y_0 + d_2 y_{-1} + \dots \quad\text{for } y = u \text{ and } y = \dot u \\
        M \ddot u_1 + C \dot u_1 + p(u_1) &= f(t_1)

    BDF2 is d = (3/2, −2, 1/2). Park's method, d = (10, −15, 6, −1)/6, is the mean of BDF2 and BDF3. Both are of second
    order and unconditionally stable for linear systems, with ρ∞ = 0. The average acceleration method, run backwards,
    finds the motion before the start. Carries u, u̇ and ü, and one (BDF2) or two (Park) older u and u̇; one force per
    Newton iteration. The history of a force is committed at u₁, where the forces balance.

    Parameters
    ----------
    weights
        d₀ > 0, d₁, ...; the formula must be exact for a constant and for a straight line.

    Raises
    ------
    ValueError
        If the weights are not weights of a derivative.

    References
    ----------
    K. C. Park, An improved stiffly stable method for direct integration of nonlinear structural dynamic equations, J.
    Appl. Mech. 42(2), 1975, 464-470.
    C. F. Curtiss, J. O. Hirschfelder, Integration of stiff equations, Proc. Natl. Acad. Sci. 38(3), 1952, 235-243.
    C. W. Gear, Numerical initial value problems in ordinary differential equations, Prentice-Hall, 1971.
    """

    weights: tuple[float, ...] = eqx.field(static=True, converter=as_tuple)
    title: str = eqx.field(default="Backward differences", static=True)
    source: str = eqx.field(default="Curtiss and Hirschfelder (1952)", static=True)
    doi: str = eqx.field(default="10.1073/pnas.38.3.235", static=True)

    family: ClassVar[str] = "Multi-step and composite"
    explicit = False

    def __check_init__(self):
        check_numbers("BackwardDifferences", "weights", self.weights)
        if self.weights[0] <= 0 or abs(sum(self.weights)) > 1e-12 or self.order < 1:
            raise ValueError(
                f"BackwardDifferences(weights={self.weights}): weights must be weights of a derivative: the first is "
                "greater than zero, their sum is zero, and the formula is exact for a straight line."
            )

    @property
    def order(self) -> int:
        def moment(power):
            return sum(d * (1 - k) ** power for k, d in enumerate(self.weights))

        # for y = tᵖ and Δt = 1 the formula gives the moment of power p as ẏ at t = 1; the exact value is p
        return next(p for p in range(len(self.weights) + 1) if abs(moment(p + 1) - (p + 1)) > 1e-12)

    @property
    def stability_limit(self) -> float | None:
        d, *rest = self.weights
        if np.abs(np.roots([d - SMALL * 1j, *rest])).max() > 1 + ROUND_OFF:
            return 0.0
        # the values of the polynomial are the boundary of the region of stability; if this boundary stays in the right
        # half plane, the method is stable for every ωΔt
        circle = np.exp(1j * np.linspace(0, np.pi, 721))
        return math.inf if np.polyval(self.weights[::-1], circle).real.min() > -1e-9 else None

    def start(self, problem, u0, v0, dt):
        state, effort = average_acceleration.start(problem, u0, v0, dt)
        previous, older = state, []
        for k in range(len(self.weights) - 2):
            previous, more = average_acceleration.step(problem, previous, -k * dt, -dt)
            older.append((previous.u, previous.v))
            effort = effort.then(more)
        return Memory(state.u, state.v, state.a, tuple(older)), effort

    def step(self, problem, state, t, dt) -> tuple[Memory, Effort]:
        d, *rest = self.weights
        past = ((state.u, state.v), *state.older)
        # u₁ = ũ + c u̇₁ and u̇₁ = ṽ + c ü₁ with c = Δt/d₀
        c = dt / d
        v = -sum(w * v for w, (_, v) in zip(rest, past, strict=True)) / d
        u = -sum(w * u for w, (u, _) in zip(rest, past, strict=True)) / d + c * v
        a, effort = balance(*at(problem, t + dt), u, v, c**2, c, guess=state.a)
        return Memory(*Motion(u + c**2 * a, v + c * a, a), past[:-1]), effort


bdf2 = BackwardDifferences(weights=(3 / 2, -2.0, 1 / 2), title="BDF2")
park = BackwardDifferences(
    weights=(10 / 6, -15 / 6, 1.0, -1 / 6), title="Park", source="Park (1975)", doi="10.1115/1.3423600"
)
