"""The balance of forces that every scheme solves, and the Newton-Raphson iteration that solves it.

In every implicit scheme the new displacement and velocity are affine in one unknown acceleration a,

    u = ũ + c_u a,    u̇ = ṽ + c_v a,    M a + C (ṽ + c_v a) + w p(ũ + c_u a) = r.

The schemes differ in ũ, ṽ, c_u and c_v, in the weight w of the internal force and in the right side r.

Newton corrections are never shortened. Halving those that do not reduce the out-of-balance force was tried: it saves
half of the runs that fail on softening springs with steps beyond a fifth of the period, but loses more runs of
structures with stiff members that rotate.

References
----------
P. Deuflhard, Newton methods for nonlinear problems, Springer, 2004.
"""

from collections.abc import Callable
from typing import Protocol

import jax.numpy as jnp
from jax import lax

from study.algebra.arrays import Matrix, ScalarLike, Vector
from study.algebra.elimination import solve
from study.algebra.matrices import Banded, add, dense, product, times
from study.equilibrium.newton import TOLERANCES, iterated, norm, opened_closure, root
from study.equilibrium.state import Effort
from study.problem.definition import Problem
from study.problem.tangent import force_and_tangent


class System(Protocol):
    """The terms of a problem that a balance needs: p(u), M, C and the form of ∂p/∂u."""

    @property
    def force(self) -> Callable:
        """Internal force p(u)."""

    @property
    def mass(self) -> Matrix:
        """M, the identity if None."""

    @property
    def damping(self) -> Matrix:
        """C, zero if None."""

    @property
    def tangent(self) -> str | int | None:
        """Form of ∂p/∂u as in :func:`study.problem.tangent.force_and_tangent`."""


def _inertia(problem: System, c_v: Matrix, n: int) -> Matrix:
    """M + c_v C; without c_v, M keeps its form, a diagonal where C is a band."""
    mass = 1.0 if problem.mass is None else problem.mass
    without = problem.damping is None or (isinstance(c_v, float) and c_v == 0)
    return mass if without else add(mass, product(problem.damping, c_v, n), n=n)


def _less_damping(problem: System, rhs, v: Vector):
    """The right side minus C v."""
    return rhs if problem.damping is None else rhs - times(problem.damping, v)


def load(problem: Problem, t: ScalarLike) -> Vector | float:
    """f(t), or without a load the constant zero, which the compiler drops."""
    return 0.0 if problem.load is None else problem.load(jnp.asarray(t))


def acceleration(problem: Problem, t: ScalarLike, u: Vector, v: Vector, c_v: ScalarLike = 0.0) -> Vector:
    """Acceleration a with M a + C (v + c_v a) + p(u) = f(t): one force, one linear solve, no iteration."""
    rhs = _less_damping(problem, load(problem, t) - problem.force(u), v)
    return solve(_inertia(problem, c_v, u.size), rhs)


def initial_acceleration(problem: Problem, u0: Vector, v0: Vector) -> Vector:
    """Acceleration at t = 0; zero for an unknown without mass, which the equation of motion leaves undetermined."""
    if not problem.massless:
        return acceleration(problem, 0.0, u0, v0)
    rhs = _less_damping(problem, load(problem, 0.0) - problem.force(u0), v0)
    if not isinstance(problem.mass, Banded) and jnp.ndim(problem.mass) == 1:
        return jnp.where(problem.mass > 0, rhs / problem.mass, 0.0)
    return jnp.linalg.pinv(dense(problem.mass, u0.size), hermitian=True) @ rhs


def balance(
    problem: System,
    rhs: Vector | float,
    u: Vector,
    v: Vector,
    c_u: Matrix,
    c_v: Matrix,
    guess: Vector,
    weight: ScalarLike = 1.0,
    force: Callable | None = None,
    symmetric: bool = True,
    tolerance: ScalarLike | None = None,
) -> tuple[Vector, Effort]:
    """Acceleration a with M a + C (v + c_v a) + w p(u + c_u a) = r, by Newton-Raphson iteration with the full tangent.

    Parameters
    ----------
    problem
        The terms M, C and p.
    rhs
        r, of the shape of ``u``.
    u, v
        The predictors ũ and ṽ.
    c_u, c_v
        Factors of the acceleration in displacement and velocity: numbers, or matrices (n, n) in any form.
    guess
        Acceleration at which the iteration starts.
    weight
        w, the weight of the internal force.
    force
        Internal force as a function of u + c_u a, in place of the problem's p.
    symmetric
        Whether the tangent is symmetric if M and C are.
    tolerance
        The iteration ends at the latest when a correction changes the displacement by less than this part of it; by
        default that of ``TOLERANCES``.

    Returns
    -------
    tuple
        The acceleration, and the :class:`Effort` with its flag of convergence within ``MAX_ITERATIONS``. A value that
        is not finite ends the iteration at once and remains in the acceleration.
    """
    force = problem.force if force is None else force
    n, tolerances = u.size, TOLERANCES[u.dtype]
    tolerance = tolerances.displacement if tolerance is None else tolerance
    inertia = _inertia(problem, c_v, n)
    rhs = _less_damping(problem, rhs, v)
    weighted = product(weight, c_u, n)

    def internal_and_effective(a):
        internal, tangent = force_and_tangent(force, u + times(c_u, a), problem.tangent)
        return weight * internal, add(inertia, product(tangent, weighted, n), n=n)

    def iterate(a, before):
        internal, effective = internal_and_effective(a)
        inertial = times(inertia, a)
        out_of_balance = inertial + internal - rhs
        correction = solve(effective, out_of_balance, symmetric)
        a = a - correction
        moved, size = norm(times(c_u, correction)), norm(u) + norm(times(c_u, a))
        unfinished = moved > tolerance * size
        if jnp.ndim(u):
            forces = norm(inertial) + norm(internal) + norm(rhs)
            unfinished |= (norm(out_of_balance) > tolerances.force * forces) & (moved > tolerances.round_off * size)
        else:
            predicted = moved**3 <= tolerances.predicted * size * before**2
            unfinished &= ~((moved <= tolerances.near * size) & predicted)
        return a, unfinished, moved

    def differentiable(a):
        residual, given = opened_closure(lambda a: times(inertia, a) + weight * force(u + times(c_u, a)) - rhs, a)
        solution, fixed = opened_closure(lambda r, a: solve(internal_and_effective(a)[1], r, symmetric), a, a)
        return root(residual, solution, a, given, fixed)

    nothing = jnp.zeros((), u.dtype)
    opened, given = opened_closure(iterate, guess, nothing)
    given = lax.stop_gradient(given)
    a, unfinished, iterations = lax.stop_gradient(guess), jnp.ones((), bool), jnp.zeros((), int)
    if not jnp.ndim(u):
        # most steps need two iterations, one to correct and one to confirm: these two are written out before the loop,
        # which for several unknowns would double what is compiled and save little
        once, _, moved = opened((a, nothing), given)
        (a, unfinished, _), iterations = opened((once, moved), given), jnp.full((), 2)
    a, unfinished, iterations = iterated(opened, given, (a, unfinished, iterations))
    return differentiable(a), Effort(iterations, ~unfinished)
