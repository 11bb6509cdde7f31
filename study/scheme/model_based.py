"""Explicit methods with a linear model of the structure in their coefficients: Chen and Ricles', and Chang's."""

import math
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp

from study.algebra.arrays import Matrix, ScalarLike, Vector
from study.algebra.counting import counting
from study.algebra.elimination import solve
from study.algebra.matrices import add, product, times
from study.mechanics.balance import acceleration, acceleration_within
from study.mechanics.definition import Problem
from study.mechanics.state import Effort, Motion
from study.mechanics.tangent import force_and_tangent
from study.scheme.base import OneStep


def mass_of(problem: Problem) -> Matrix:
    """M; the number 1 if the problem declares no mass."""
    return 1.0 if problem.mass is None else problem.mass


def viscous(problem: Problem, u: Vector, factor: ScalarLike) -> Matrix:
    """The matrix ``factor`` (C + ∂p/∂u̇) of the undeformed structure at rest; None without damping."""
    terms = [] if problem.damping is None else [product(factor, problem.damping, u.size)]
    if problem.takes_velocity:
        at_rest, undeformed = jnp.zeros_like(u), problem.at_rest()
        with counting():  # not counted: the model is the same in every step
            _, viscosity = force_and_tangent(lambda v: undeformed.varying_force(at_rest, v), at_rest, problem.tangent)
        terms.append(product(factor, viscosity, u.size))
    return add(*terms, n=u.size) if terms else None


def model(problem: Problem, u: Vector, damping_factor: ScalarLike, stiffness_factor: ScalarLike) -> Matrix:
    """The matrix ``damping_factor`` (C + ∂p/∂u̇) + ``stiffness_factor`` K of the undeformed structure at rest.

    Of ``u`` only the shape matters.
    """
    with counting():  # not counted: the model is the same in every step
        stiffness = product(stiffness_factor, problem.at_rest().stiffness_at(jnp.zeros_like(u)), u.size)
    damping = viscous(problem, u, damping_factor)
    return stiffness if damping is None else add(stiffness, damping, n=u.size)


class ChenRicles(OneStep):
    r"""The CR method of Chen and Ricles, from discrete control theory.

    With the stiffness K = ∂p/∂u of the undeformed structure at rest, where the C in S includes ∂p/∂u̇,

    .. math::

        S &= M + \tfrac12 \Delta t\,C + \tfrac14 \Delta t^2 K, \quad \alpha = S^{-1} M \\
        \dot u_1 &= \dot u_0 + \Delta t\,\alpha\,\ddot u_0 \\
        u_1 &= u_0 + \Delta t\,\dot u_0 + \Delta t^2 \alpha\,\ddot u_0 \\
        M \ddot u_1 + C \dot u_1 + p(u_1) &= f(t_1)

    For a linear structure the eigenvalues are those of the trapezoidal rule, which is of second order, unconditionally
    stable and without numerical damping. The carried velocity lags by half a step, so a motion that starts with an
    acceleration is of first order; from :math:`\dot u_0 - \tfrac12 \Delta t\,\ddot u_0` it is of second order, unless
    the force is non-linear in the velocity. If the tangent k exceeds K, as in a structure that hardens, it is stable
    without damping only while k ≤ K + 4/Δt² M. Carries u, u̇ and ü; one force per step, and two solutions of linear
    systems. The history of a force is committed at u₁, where the forces balance; K remains the stiffness at rest.

    References
    ----------
    C. Chen, J. M. Ricles, Development of direct integration algorithms for structural dynamics using discrete control
    theory, J. Eng. Mech. 134(8), 2008, 676-683.
    """

    title: str = eqx.field(default="Chen-Ricles", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Chen and Ricles (2008)"
    #: The lag of the carried velocity in steps.
    velocity_lag: ClassVar[float] = 0.5
    doi: ClassVar[str] = "10.1061/(ASCE)0733-9399(2008)134:8(676)"
    order = 1
    explicit = True
    acceleration_offset = 0.0
    stability_limit = math.inf
    keeps_energy = True

    def increment(self, problem, state, t, dt):
        u, v, a = state
        mass = mass_of(problem)
        effective = add(mass, model(problem, u, dt / 2, dt**2 / 4), n=u.size)
        dv = dt * solve(effective, times(mass, a))
        du = dt * (v + dv)
        return Motion(du, dv, acceleration(problem, t + dt, u + du, v + dv)), Effort()


class Chang(OneStep):
    r"""Chang's explicit method of 2002, with the velocity of the trapezoidal rule.

    With the stiffness K = ∂p/∂u of the undeformed structure at rest, where C in S and in the equation of u₁ includes
    ∂p/∂u̇,

    .. math::

        S &= M + \tfrac12 \Delta t\,C + \tfrac14 \Delta t^2 K \\
        u_1 &= u_0 + S^{-1} [(M + \tfrac12 \Delta t\,C)\,\Delta t\,\dot u_0 + \tfrac12 \Delta t^2 M \ddot u_0] \\
        \dot u_1 &= \dot u_0 + \tfrac12 \Delta t\,(\ddot u_0 + \ddot u_1) \\
        M \ddot u_1 + C \dot u_1 + p(u_1) &= f(t_1)

    Second order. For a linear structure without load it is the trapezoidal rule: unconditionally stable, without
    numerical damping. If the tangent k exceeds K, as in a structure that hardens, it is stable without damping only
    while k ≤ K + 4/Δt² M. Carries u, u̇ and ü; one force per step, and two solutions of linear systems, without
    iteration unless the force depends on the velocity. The history of a force is committed at u₁, where the forces
    balance; K remains the stiffness at rest.

    References
    ----------
    S.-Y. Chang, Explicit pseudodynamic algorithm with unconditional stability, J. Eng. Mech. 128(9), 2002, 935-947.
    """

    title: str = eqx.field(default="Chang", static=True)

    family: ClassVar[str] = "Explicit with dissipation"
    source: ClassVar[str] = "Chang (2002)"
    doi: ClassVar[str] = "10.1061/(ASCE)0733-9399(2002)128:9(935)"
    order = 2
    explicit = True
    force_at_end = True
    stability_limit = math.inf
    keeps_energy = True

    def increment(self, problem, state, t, dt):
        u, v, a = state
        mass, damping = mass_of(problem), viscous(problem, u, dt / 2)
        damped = mass if damping is None else add(mass, damping, n=u.size)
        effective = add(mass, model(problem, u, dt / 2, dt**2 / 4), n=u.size)
        du = dt * solve(effective, times(damped, v) + dt / 2 * times(mass, a))
        dv = dt / 2 * a
        a, effort = acceleration_within(problem, t + dt, u + du, v + dv, dt / 2, guess=a)
        return Motion(du, dv + dt / 2 * a, a), effort


chen_ricles = ChenRicles()
chang = Chang()
