"""Houbolt's three-step method and four ways to start it."""

import math
from typing import ClassVar, NamedTuple

import equinox as eqx
from jax import lax

from study.algebra.arrays import Vector
from study.mechanics.balance import acceleration, acceleration_within, at, balance, initial_acceleration
from study.mechanics.definition import Problem
from study.mechanics.state import Effort, Phase
from study.registry import did_you_mean
from study.scheme.base import Scheme
from study.scheme.contract import stepped
from study.scheme.newmark import Newmark, central_difference
from study.scheme.runge_kutta import RungeKutta4


class History(NamedTuple):
    """Motion at tₙ and the displacements at tₙ₋₁ and tₙ₋₂, each of shape () or (n,)."""

    u: Vector
    v: Vector
    a: Vector
    u_1: Vector
    u_2: Vector


def _linear_acceleration(problem: Problem, u0, v0, dt):
    """Houbolt's own start: fictitious points that satisfy his central formulas for u̇₀ and ü₀.

    ü₀ = (u₁ − 2u₀ + u₋₁)/Δt² and u̇₀ = (2u₁ + 3u₀ − 6u₋₁ + u₋₂)/(6Δt). Together with eq. (11b) at t₁, these points make
    the first step exactly the step of the linear acceleration method, which finds u₁ here.
    """
    scheme = Newmark(beta=1 / 6, gamma=0.5)
    state, _ = scheme.start(problem, u0, v0, dt)
    first, effort = scheme.step(problem, state, 0.0, dt)
    u_1 = dt**2 * state.a - first.u + 2 * u0
    u_2 = 6 * dt * v0 - 2 * first.u - 3 * u0 + 6 * u_1
    return u_1, u_2, effort


def _central_difference(problem: Problem, u0, v0, dt):
    """Fictitious points that make the first two steps equal to those of central difference."""
    state, _ = central_difference.start(problem, u0, v0, dt)
    first, effort = central_difference.step(problem, state, 0.0, dt)
    second, more = central_difference.step(problem, first, dt, dt)
    effort = effort.then(more)
    u1, u2 = first.u, second.u
    # eqs (11), solved for u₋₁ and u₋₂. Both depend on the acceleration, and so does the velocity in the damping force
    a2, more = acceleration_within(problem, 2 * dt, u2, (7 * u2 - 8 * u1 + u0) / (6 * dt), dt / 3, guess=second.a)
    effort = effort.then(more)
    u_1 = 2 * u2 - 5 * u1 + 4 * u0 - dt**2 * a2
    a1, more = acceleration_within(problem, dt, u1, (7 * u1 - 8 * u0 + u_1) / (6 * dt), dt / 3, guess=first.a)
    u_2 = 2 * u1 - 5 * u0 + 4 * u_1 - dt**2 * a1
    return u_1, u_2, effort.then(more)


def _taylor(problem: Problem, u0, v0, dt):
    """Displacements at −Δt and −2Δt by the Taylor polynomial of second order."""
    a0 = acceleration(problem, 0.0, u0, v0)
    return u0 - dt * v0 + dt**2 / 2 * a0, u0 - 2 * dt * v0 + 2 * dt**2 * a0, Effort()


def _exact(problem: Problem, u0, v0, dt):
    """Displacements at −Δt and −2Δt, exact up to round-off, by 1024 backward Runge-Kutta steps for each Δt."""
    substeps = 1024
    h = -dt / substeps

    def back(i, carry):
        phase, forces = carry
        phase, effort = stepped(RungeKutta4(), problem, phase, i.astype(float) * h, h)
        return phase, forces + effort.forces

    once, forces = lax.fori_loop(0, substeps, back, (Phase(u0, v0), 0))
    twice, forces = lax.fori_loop(substeps, 2 * substeps, back, (once, forces))
    return once.u, twice.u, Effort(forces=forces)


#: Ways to find the two displacements before t = 0, by name.
starts = {
    "linear_acceleration": _linear_acceleration,
    "central_difference": _central_difference,
    "taylor": _taylor,
    "exact": _exact,
}


class Houbolt(Scheme):
    r"""The Houbolt method, Xie (1996), eqs (7) and (11), with backward differences through four points.

    .. math::

        \dot u_1 &= (11 u_1 - 18 u_0 + 9 u_{-1} - 2 u_{-2})/(6 \Delta t) \\
        \ddot u_1 &= (2 u_1 - 5 u_0 + 4 u_{-1} - u_{-2})/\Delta t^2 \\
        M \ddot u_1 + C \dot u_1 + p(u_1) &= f(t_1)

    Second order, unconditionally stable for linear systems; its damping cannot be controlled. In terms of the
    acceleration, :math:`u_1 = \tilde u + \Delta t^2\,\ddot u_1/2` and
    :math:`\dot u_1 = \tilde v + 11 \Delta t\,\ddot u_1/12`, where ũ and ṽ depend on earlier displacements. Carries u,
    u̇, ü and two older u; one force per Newton iteration. The history of a force is committed at u₁, where the forces
    balance.

    Parameters
    ----------
    start_by
        The way to find u₋₁ and u₋₂: ``linear_acceleration`` (Houbolt's fictitious points), ``central_difference``,
        ``taylor`` or ``exact``.

    Raises
    ------
    ValueError
        If there is no way of this name.

    References
    ----------
    J. C. Houbolt, A recurrence matrix solution for the dynamic response of elastic aircraft, J. Aeronaut. Sci. 17(9),
    1950, 540-550.
    """

    start_by: str = eqx.field(default="linear_acceleration", static=True)
    title: str = eqx.field(default="Houbolt", static=True)

    family: ClassVar[str] = "Multi-step and composite"
    source: ClassVar[str] = "Houbolt (1950)"
    doi: ClassVar[str] = "10.2514/8.1722"
    order = 2
    explicit = False
    stability_limit = math.inf

    def __check_init__(self):
        if not isinstance(self.start_by, str) or self.start_by not in starts:
            raise ValueError(
                f"Houbolt(start_by={self.start_by!r}): no such start; {did_you_mean(str(self.start_by), starts)}"
            )

    @property
    def needs_mass(self) -> bool:
        # with ρ∞ = 0 the steps do not need mass; three of the four starts do, because they solve with M alone
        return self.start_by != "linear_acceleration"

    def start(self, problem, u0, v0, dt):
        u_1, u_2, effort = starts[self.start_by](problem, u0, v0, dt)
        return History(u0, v0, initial_acceleration(problem, u0, v0), u_1, u_2), effort

    def step(self, problem, state, t, dt):
        u, _, a, u_1, u_2 = state
        c_u, c_v = dt**2 / 2, 11 * dt / 12
        u_predicted = (5 * u - 4 * u_1 + u_2) / 2
        v_predicted = (11 * u_predicted - 18 * u + 9 * u_1 - 2 * u_2) / (6 * dt)
        a, effort = balance(*at(problem, t + dt), u_predicted, v_predicted, c_u, c_v, guess=a)
        return History(u_predicted + c_u * a, v_predicted + c_v * a, a, u, u_1), effort


houbolt = Houbolt()
