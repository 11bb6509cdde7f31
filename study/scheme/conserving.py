"""Implicit conserving methods: the midpoint rule, and two methods that conserve energy."""

import math
from collections.abc import Callable
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.arrays import Vector
from study.algebra.counting import count
from study.algebra.scalars import is_whole
from study.mechanics.balance import at, balance, load
from study.mechanics.definition import Problem
from study.mechanics.state import Motion
from study.mechanics.terms import StrainEnergy
from study.scheme.base import OneStep, Scheme


class ImplicitMidpoint(OneStep):
    r"""The implicit midpoint rule.

    .. math::

        M (\dot u_1 - \dot u_0)/\Delta t + C \dot u_m + p(u_m) &= f(t_0 + \tfrac12 \Delta t) \\
        \dot u_m = (u_1 - u_0)/\Delta t &= (\dot u_0 + \dot u_1)/2, \quad u_m = (u_0 + u_1)/2

    Second order and symplectic; conserves linear and angular momentum. For linear systems it is the trapezoidal rule:
    unconditionally stable, without numerical damping. Carries u, u̇ and a guess of ü; one force per Newton iteration.
    The history of a force is committed at u₁, not at the midpoint where the forces balance.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, section II.1.
    J. C. Butcher, Implicit Runge-Kutta processes, Math. Comput. 18(85), 1964, 50-64 (the Gauss method of one stage).
    J. C. Simo, N. Tarnow, K. K. Wong, Exact energy-momentum conserving algorithms and symplectic schemes for nonlinear
    dynamics, Comput. Methods Appl. Mech. Eng. 100(1), 1992, 63-116.
    """

    title: str = eqx.field(default="Implicit midpoint", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Butcher (1964)"
    doi: ClassVar[str] = "10.1090/S0025-5718-1964-0159424-9"
    order = 2
    explicit = False
    stability_limit = math.inf
    keeps_energy = True

    def increment(self, problem, state, t, dt):
        u, v, guess = state
        a, effort = balance(*at(problem, t + dt / 2), u + dt / 2 * v, v, dt**2 / 4, dt / 2, guess)
        return Motion(dt * v + dt**2 / 2 * a, dt * a, a), effort


#: Relative change of a strain (or displacement) in a step, below which the force at the midpoint replaces the quotient
#: of the changes of energy and strain. The round-off of the quotient would exceed the third-order error of the
#: midpoint. The value is about the cube root of round-off.
STANDSTILL = {np.dtype("float64"): 1e-5, np.dtype("float32"): 8e-3}

#: Absolute change of a strain below which the force at the midpoint is also used, because the square of the change
#: underflows. Such changes occur ahead of a wave.
SMALLEST = {np.dtype("float64"): 1e-150, np.dtype("float32"): 1e-18}


def _mean_force_of_strains(potential: StrainEnergy, u0: Vector) -> Callable:
    """The mean force p̄ of a strain energy, computed strain by strain, as a function of u₁."""
    strains, density = potential.strains, potential.density
    slope = jax.grad(lambda strain: jnp.sum(density(strain)))
    before = strains(u0)
    energy = density(before)
    count(forces=1)

    def mean_force(u1):
        count(forces=2)
        after = strains(u1)
        change = after - before
        sizes = jnp.abs(before) + jnp.abs(after)
        moves = jnp.abs(change) > STANDSTILL[u0.dtype] * sizes + SMALLEST[u0.dtype]
        quotient = (density(after) - energy) / jnp.where(moves, change, 1.0)
        stress = jnp.where(moves, quotient, slope((before + after) / 2))
        return jax.vjp(strains, (u0 + u1) / 2)[1](stress)[0]

    return mean_force


def discrete_gradient(problem: Problem, u0: Vector) -> Callable:
    """Gonzalez's mean force p̄ from u₀ to u₁, with p̄ᵀ (u₁ − u₀) = V(u₁) − V(u₀), as a function of u₁.

    A potential counts as a force.
    """
    potential = problem.potential
    if potential is None:
        raise ValueError("a discrete gradient needs a potential: give Problem(potential=...).")
    if isinstance(potential, StrainEnergy):
        return _mean_force_of_strains(potential, u0)
    count(forces=1)
    energy = potential(u0)

    def mean_force(u1):
        middle, change = (u0 + u1) / 2, u1 - u0
        length = jnp.vdot(change, change)
        moves = length > STANDSTILL[u0.dtype] ** 2 * (jnp.vdot(u0, u0) + jnp.vdot(u1, u1))
        if jnp.ndim(u0) == 0:
            # with one unknown, p(u_m) cancels from the formula
            count(forces=1)
            return lax.cond(moves, lambda: (potential(u1) - energy) / change, lambda: problem.force(middle))
        count(forces=2)
        force = problem.force(middle)
        missing = (potential(u1) - energy - jnp.vdot(force, change)) / jnp.where(moves, length, 1.0)
        return force + jnp.where(moves, missing, 0.0) * change

    return mean_force


class EnergyMomentum(OneStep):
    r"""The energy-momentum method: the midpoint rule with Gonzalez's discrete gradient p̄ in place of the force.

    .. math::

        M (\dot u_1 - \dot u_0)/\Delta t + C \dot u_m + \bar p(u_0, u_1) &= f(t_0 + \tfrac12 \Delta t) \\
        \dot u_m = (u_1 - u_0)/\Delta t &= (\dot u_0 + \dot u_1)/2

    There are two formulas for p̄, with u_m = (u₀ + u₁)/2, ε₀ = ε(u₀) and ε₁ = ε(u₁). The first is for a strain energy,
    with a mean stress σ̄ for each strain. The second is for any other potential:

    .. math::

        \bar p &= (\partial\varepsilon/\partial u)^T \bar\sigma \text{ at } u_m,
            \quad \bar\sigma = \frac{w(\varepsilon_1) - w(\varepsilon_0)}{\varepsilon_1 - \varepsilon_0} \\
        \bar p &= p(u_m) + \frac{V(u_1) - V(u_0) - p(u_m)^T (u_1 - u_0)}{|u_1 - u_0|^2}\,(u_1 - u_0)

    Second order. Without damping and load the energy ½ u̇ᵀ M u̇ + V(u) is constant to round-off. With a strain energy,
    linear and angular momentum are constant too. The second formula changes them by O(Δt³) a step, and its tangent
    is full. For one unknown both formulas are p̄ = (V(u₁) − V(u₀))/(u₁ − u₀), the method of Simo
    and Tarnow for a spring. For linear systems it is the trapezoidal rule, unconditionally stable. Needs the problem's
    potential. Carries u, u̇ and a guess of ü; one force and one potential per Newton iteration, and one potential per
    step. A potential counts as a force.

    References
    ----------
    O. Gonzalez, Time integration and discrete Hamiltonian systems, J. Nonlinear Sci. 6(5), 1996, 449-467.
    J. C. Simo, N. Tarnow, The discrete energy-momentum method: conserving algorithms for nonlinear elastodynamics, Z.
    Angew. Math. Phys. 43(5), 1992, 757-792.
    """

    title: str = eqx.field(default="Energy-momentum", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Gonzalez (1996)"
    doi: ClassVar[str] = "10.1007/BF02440162"
    order = 2
    explicit = False
    force_at_end = True
    stability_limit = math.inf
    keeps_energy = True

    def refusal(self, problem):
        if problem.dissipative:
            return f"'{self.title}' takes the force from the potential, and the force of '{problem.title}' has none."
        if problem.stiffness is not None:
            return _with_stiffness(self, problem)
        if problem.potential is None:
            return f"'{self.title}' needs the potential of '{problem.title}': give Problem(potential=...)."
        if problem.tangent not in (None, "dense") and not isinstance(problem.potential, StrainEnergy):
            return (
                f"'{self.title}' makes the tangent of '{problem.title}' full: give it a StrainEnergy as potential, or "
                "tangent='dense'."
            )
        return super().refusal(problem)

    def increment(self, problem, state, t, dt):
        u, v, guess = state
        rhs = load(problem, t + dt / 2)
        gradient = discrete_gradient(problem, u)

        def mean_force(u1, v_m):
            return gradient(u1)

        a, effort = balance(problem, rhs, u + dt * v, v, dt**2 / 2, dt / 2, guess, force=mean_force, symmetric=False)
        return Motion(dt * v + dt**2 / 2 * a, dt * a, a), effort


def _with_stiffness(scheme: Scheme, problem: Problem) -> str:
    return (
        f"'{scheme.title}' takes a mean of the whole force, and '{problem.title}' has a stiffness next to its force: "
        "make it part of the force and of the potential."
    )


class AverageVectorField(OneStep):
    r"""The average vector field method: the midpoint rule with the mean force along the step.

    .. math::

        M (\dot u_1 - \dot u_0)/\Delta t + C \dot u_m + \int_0^1 p((1 - s)\,u_0 + s u_1)\,ds
            &= f(t_0 + \tfrac12 \Delta t) \\
        \dot u_m = (u_1 - u_0)/\Delta t &= (\dot u_0 + \dot u_1)/2

    Gauss quadrature with m = ``points`` points evaluates the integral. The method conserves the energy exactly if p is
    a polynomial of degree 2m − 1 or less, and nearly otherwise. Second order. For linear systems it is the trapezoidal
    rule, unconditionally stable. Needs no potential. Carries u, u̇ and a guess of ü; m forces per Newton iteration. The
    history of a force is committed at u₁; the forces at all points of the mean start from the history at u₀.

    Parameters
    ----------
    points
        Number of quadrature points, at least one; with one it is the midpoint rule.

    Raises
    ------
    ValueError
        If ``points`` is not a whole number of at least one.

    References
    ----------
    G. R. W. Quispel, D. I. McLaren, A new class of energy-preserving numerical integration methods, J. Phys. A 41(4),
    2008, 045206.
    """

    points: int = eqx.field(default=3, static=True)
    title: str = eqx.field(default="Average vector field", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Quispel and McLaren (2008)"
    doi: ClassVar[str] = "10.1088/1751-8113/41/4/045206"
    order = 2
    explicit = False
    stability_limit = math.inf
    keeps_energy = True

    def __check_init__(self):
        if not is_whole(self.points, 1):
            raise ValueError(f"AverageVectorField(points={self.points}): points must be a whole number of at least 1.")

    def refusal(self, problem):
        return _with_stiffness(self, problem) if problem.stiffness is not None else super().refusal(problem)

    def increment(self, problem, state, t, dt):
        u, v, guess = state
        nodes, weights = np.polynomial.legendre.leggauss(self.points)
        middle, f = at(problem, t + dt / 2)

        def mean_force(u1, v_m):
            forces = [middle.internal_force(u + (1 + s) / 2 * (u1 - u), v_m) for s in nodes.tolist()]
            return sum(w / 2 * force for w, force in zip(weights.tolist(), forces, strict=True))

        a, effort = balance(middle, f, u + dt * v, v, dt**2 / 2, dt / 2, guess, force=mean_force)
        return Motion(dt * v + dt**2 / 2 * a, dt * a, a), effort


implicit_midpoint = ImplicitMidpoint()
energy_momentum = EnergyMomentum()
average_vector_field = AverageVectorField()
