r"""The balance of forces that every implicit scheme solves, and the Newton-Raphson iteration that solves it.

In every implicit scheme the new displacement and velocity are affine in one unknown acceleration a,

.. math::

    u &= \tilde u + c_u a, \quad \dot u = \tilde v + c_v a \\
    M a + C (\tilde v + c_v a) + w\,p(\tilde u + c_u a) &= r

The schemes differ in ũ, ṽ, c_u and c_v, in the weight w of the internal force and in the right side r. A force may take
the velocity ṽ + c_v a too, and a history, which the iteration does not change. A problem may have a constant
stiffness K, so that its internal force is K u + p; then only p is differentiated.

If the force is smooth, Newton corrections are not shortened, except by the safeguard below. If the slope of the force
may jump, the iteration could oscillate between two branches without end. With one unknown the iterate is then kept in a
bracket, between two accelerations with residuals of opposite signs. The bracket is bisected if Newton's correction
leaves it or is longer than half of the last change. With several unknowns a correction that is too long is shortened to
a point where the component of the residual along the correction is nearly zero.

If the problem is ``safeguarded``, an iteration that fails is started again with a safeguard. With one unknown this is a
bracket, which finds a root of every continuous residual that changes its sign. With several unknowns a correction is
halved until the next correction with the same tangent is sufficiently shorter (Deuflhard, 2004, section 3.3). A test
for a smaller residual would stall where stiff members rotate.

References
----------
P. Deuflhard, Newton methods for nonlinear problems, Springer, 2004.
M. A. Crisfield, Non-linear finite element analysis of solids and structures, vol. 1, Wiley, 1991, section 9.2.
"""

from collections.abc import Callable
from functools import partial

import jax.numpy as jnp
from jax import lax

from study.algebra.arrays import Matrix, Scalar, ScalarLike, Vector
from study.algebra.counting import Counted, count
from study.algebra.elimination import solve
from study.algebra.matrices import Banded, add, dense, product, times
from study.algebra.round_off import EVALUATIONS, sensitivity
from study.algebra.sparse import Sparse
from study.mechanics.definition import Problem
from study.mechanics.newton import (
    MAX_SAFEGUARDED,
    backtracked,
    iterated,
    narrowed,
    norm,
    opened_closure,
    root,
    shortened,
    tolerances_of,
)
from study.mechanics.sparse_tangent import SparseTangent
from study.mechanics.state import Effort
from study.mechanics.system import System
from study.mechanics.tangent import FormOfTangent, force_and_tangent


def _inertia(problem: System, c_v: Matrix, n: int) -> Matrix:
    """M + c_v C, or M itself if c_v is zero: a diagonal M then stays diagonal although C is banded."""
    mass = 1.0 if problem.mass is None else problem.mass
    without = problem.damping is None or (isinstance(c_v, float) and c_v == 0)
    return mass if without else add(mass, product(problem.damping, c_v, n), n=n)


def _less_damping(problem: System, rhs, v: Vector):
    """The right side minus C v."""
    return rhs if problem.damping is None else rhs - times(problem.damping, v)


def load(problem: Problem, t: ScalarLike) -> Vector | float:
    """f(t); for a problem without a load the constant zero, which the compiler drops."""
    return 0.0 if problem.load is None else problem.load(jnp.asarray(t))


def at(problem: Problem, t: ScalarLike) -> tuple[Problem, Vector | float]:
    """The problem with its force at the time t, and f(t): the first two arguments of :func:`balance`."""
    return problem.at_time(t), load(problem, t)


def acceleration(problem: Problem, t: ScalarLike, u: Vector, v: Vector, c_v: ScalarLike = 0.0) -> Vector:
    """Acceleration a with M a + C (v + c_v a) + K u + p(u, v) = f(t), by one evaluation of p and one linear solve."""
    problem, f = at(problem, t)
    return solve(_inertia(problem, c_v, u.size), _less_damping(problem, f - problem.internal_force(u, v), v))


def acceleration_within(
    problem: Problem, t: ScalarLike, u: Vector, v: Vector, c_v: ScalarLike, guess: Vector
) -> tuple[Vector, Effort]:
    """Acceleration a with M a + C (v + c_v a) + K u + p(u, v + c_v a) = f(t), and the effort to find it.

    If the internal force does not depend on the velocity, this is :func:`acceleration`, without iteration.
    """
    if not problem.takes_velocity:
        return acceleration(problem, t, u, v, c_v), Effort()
    return balance(*at(problem, t), u, v, 0.0, c_v, guess)


def initial_acceleration(problem: Problem, u0: Vector, v0: Vector) -> Vector:
    """Acceleration at t = 0; zero for an unknown without mass, whose acceleration the equation does not determine."""
    if not problem.massless:
        return acceleration(problem, 0.0, u0, v0)
    problem, f = at(problem, 0.0)
    rhs = _less_damping(problem, f - problem.internal_force(u0, v0), v0)
    if isinstance(problem.mass, Sparse):
        diagonal = problem.mass.pattern.diagonal
        massless = problem.mass.values[diagonal] == 0
        regular_mass = problem.mass.plus(massless.astype(rhs.dtype), diagonal)
        return solve(regular_mass, jnp.where(massless, 0.0, rhs))
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
    r"""Acceleration a that balances the forces, by Newton-Raphson iteration.

    .. math::

        M a + C (v + c_v a) + w\,p(u + c_u a, v + c_v a) = r

    If the problem has a constant stiffness K, the internal force is K u + p. A force with a history, and its tangent,
    start from the committed history.

    Parameters
    ----------
    problem
        The terms M, C, K and p, and the form of the tangent.
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
        Internal force as a function of u + c_u a and v + c_v a, in place of the problem's p. The problem must then
        have no stiffness K.
    symmetric
        Whether the tangent is symmetric if M and C are.
    tolerance
        Tolerance of the last correction, relative to the displacement, or to the velocity if the force depends on it.
        The default is ``displacement`` of ``tolerances_of``, which also returns the tolerances of further criteria.

    Returns
    -------
    tuple
        The acceleration and the :class:`Effort`. Its flag ``converged`` is false if the iteration has not ended within
        ``MAX_ITERATIONS``; a safeguard adds up to ``MAX_SAFEGUARDED`` iterations. A value that is not finite ends the
        iteration at once, and remains in the acceleration unless a safeguard finds a finite one.
    """
    force, total_force = (problem.varying_force, problem.internal_force) if force is None else (force, force)
    n, tolerances = u.size, tolerances_of(u.dtype)
    tolerance = tolerances.displacement if tolerance is None else tolerance
    inertia = _inertia(problem, c_v, n)
    rhs = _less_damping(problem, rhs, v)
    weighted_c_u = product(weight, c_u, n)
    # constant part of the effective matrix, assembled once; each iteration adds the tangent of p
    constant = inertia if problem.stiffness is None else add(inertia, product(problem.stiffness, weighted_c_u, n), n=n)
    # a correction is measured by the norm of its product with reach, relative to |start| + |reach a|
    start, reach = (v, c_v) if problem.takes_velocity else (u, c_u)
    # to compare each row with its round-off takes lanes longer than the forces, so only runs that need it do
    by_row = jnp.ndim(u) > 0 and (problem.massless or problem.safeguarded)

    def internal_force(function, a):
        velocity = v + times(c_v, a) if problem.takes_velocity else v
        return function(u + times(c_u, a), velocity)

    @Counted
    def internal_and_effective(a):
        if problem.takes_velocity:
            value, tangent = force_and_tangent(partial(internal_force, force), a, _coupled(problem.tangent, c_u))
            tangent = product(weight, tangent, n)
        else:
            value, tangent = force_and_tangent(lambda u: force(u, v), u + times(c_u, a), problem.tangent)
            tangent = product(tangent, weighted_c_u, n)
        if problem.stiffness is not None:
            value = value + times(problem.stiffness, u + times(c_u, a))
        return weight * value, add(constant, tangent, n=n)

    @Counted
    def residual(a):
        return times(inertia, a) + weight * internal_force(total_force, a) - rhs

    @Counted
    def solve_effective(effective, x):
        return solve(effective, x, symmetric and not problem.takes_velocity)

    def effort(iterations, residuals, **outcome):
        iteration_counts, residual_counts = internal_and_effective.counts, residual.counts
        count(forces_of_iteration=iteration_counts.forces)
        return Effort(
            iterations,
            forces=iterations * iteration_counts.forces + residuals * residual_counts.forces,
            tangents=iterations * iteration_counts.tangents,
            factorisations=iterations,
            **outcome,
        )

    if problem.linear:
        a = guess - solve_effective(constant, residual(guess))
        return a, Effort(jnp.ones((), int), forces=residual.counts.forces, fixed_factorisations=1)

    def iterate(a, before, halved=False):
        internal, effective = internal_and_effective(a)
        inertial = times(inertia, a)
        out_of_balance = inertial + internal - rhs

        def round_off(a=a):
            return tolerances.round_off * sensitivity(residual, a, out_of_balance)

        correction = solve_effective(effective, out_of_balance)
        residuals: Scalar | int = 0
        if halved:
            # the whole correction is measured: one that was halved many times is short without convergence
            change = norm(times(reach, correction))
            part, residuals = backtracked(residual, a, correction, partial(solve_effective, effective))
            a = a - part
        else:
            if problem.kinked and jnp.ndim(u):
                # near the solution the sign of the residual is round-off, and no part of the correction would be found
                settled = norm(times(reach, correction)) <= tolerance * (norm(start) + norm(times(reach, a)))
                row_round_off = round_off if by_row else None
                correction, residuals = shortened(residual, a, correction, out_of_balance, settled, row_round_off)
            a = a - correction
            change = norm(times(reach, correction))
        size = norm(start) + norm(times(reach, a))
        unfinished = change > tolerance * size
        if jnp.ndim(u):
            forces = norm(inertial) + norm(internal) + norm(rhs)
            unfinished |= (norm(out_of_balance) > tolerances.force * forces) & (change > tolerances.round_off * size)
            if by_row:
                # if the forces of each row balance, a correction that is not shorter than half of the last is round-off
                stalls = unfinished & (2 * change >= before)
                row_tolerance = tolerances.force * (jnp.abs(inertial) + jnp.abs(internal) + jnp.abs(rhs))
                unfinished = lax.cond(
                    stalls, lambda: jnp.any(jnp.abs(out_of_balance) > row_tolerance + round_off()), lambda: unfinished
                )
                residuals += jnp.where(stalls, EVALUATIONS, 0)
        else:
            predicted = change**3 <= tolerances.predicted * size * before**2
            unfinished &= ~((change <= tolerances.near * size) & predicted)
        return a, unfinished, change, residuals

    def iterate_between(bracket, before):
        a = bracket[0]
        internal, effective = internal_and_effective(a)
        out_of_balance = times(inertia, a) + internal - rhs
        bracket = narrowed(bracket, out_of_balance, solve_effective(effective, out_of_balance))
        change, size = norm(reach * (bracket[0] - a)), norm(start) + norm(reach * bracket[0])
        return bracket, change > tolerance * size, change, 0

    def differentiable(a):
        opened, captured = opened_closure(residual, a)
        solution, fixed = opened_closure(lambda r, a: solve_effective(internal_and_effective(a)[1], r), a, a)
        whole = not isinstance(problem.tangent, int | SparseTangent)
        return root(opened, solution, whole, a, captured, fixed)

    zero, first = jnp.zeros((), u.dtype), lax.stop_gradient(guess)
    iterates: Callable = iterate
    safeguarded: Callable = partial(iterate, halved=True)
    begin, last = first, jnp.full((), jnp.inf, u.dtype) if by_row else None
    if not jnp.ndim(u):
        safeguarded, begin = iterate_between, jnp.stack([first, -jnp.inf, jnp.inf, jnp.inf])
        if problem.kinked:
            iterates, first = safeguarded, begin
    opened, captured = opened_closure(iterates, first, zero)
    captured = lax.stop_gradient(captured)
    none = jnp.zeros((), int)
    solution, unfinished, iterations = first, jnp.ones((), bool), none
    if not jnp.ndim(first) and tolerances.near > 0:
        # Most steps need two iterations, one to correct and one to confirm. These two are written out before the loop.
        # With several unknowns this would double the program and save little.
        once, _, change, _ = opened((first, zero), captured)
        (solution, unfinished, *_), iterations = opened((once, change), captured), jnp.full((), 2)
    carry = solution, last, unfinished, iterations, none
    solution, _, unfinished, iterations, residuals = iterated(opened, captured, carry)
    a = solution if solution.shape == u.shape else solution[0]
    if not problem.safeguarded:
        return differentiable(a), effort(iterations, residuals, converged=~unfinished)

    failed = unfinished | ~jnp.all(jnp.isfinite(a))
    opened, captured = opened_closure(safeguarded, begin, zero)
    carry = begin, last, failed, none, none
    solution, _, unfinished, more, tried = iterated(opened, lax.stop_gradient(captured), carry, MAX_SAFEGUARDED)
    a = jnp.where(failed, solution if jnp.ndim(u) else solution[0], a)
    outcome = {"converged": ~unfinished, "restarts": failed.astype(int)}
    return differentiable(a), effort(iterations + more, residuals + tried, **outcome)


def _coupled(form: FormOfTangent, c_u: Matrix) -> FormOfTangent:
    """Form of the product of a tangent with ``c_u``."""
    return form + c_u.half_bandwidth if isinstance(form, int) and isinstance(c_u, Banded) else form
