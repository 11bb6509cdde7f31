"""The one balance of forces that every scheme asks for, and the Newton-Raphson iteration that finds it.

In every implicit scheme the new displacement and velocity are affine in one unknown acceleration a,

    u = ũ + c_u a,    u̇ = ṽ + c_v a,    M a + C (ṽ + c_v a) + w p(ũ + c_u a) = r,

so a scheme is its ũ, ṽ, c_u, c_v, the weight w of its internal force and its right side r.

Newton's steps are taken whole. Halving those that do not bring the forces nearer to balance was measured to save half
of the runs that fail, those of softening springs at steps beyond a fifth of the period, and to lose more of structures
with stiff members that turn.

References
----------
P. Deuflhard, Newton methods for nonlinear problems, Springer, 2004.
"""

import jax.numpy as jnp
from jax import lax

from study.algebra.elimination import solve
from study.algebra.matrices import SMALL, Banded, add, dense, product, times
from study.equilibrium.newton import TOLERANCES, iterated, norm, opened_closure, root
from study.equilibrium.state import Effort
from study.problem.definition import Problem
from study.problem.tangent import force_and_tangent


def _inertia(problem: Problem, c_v, n: int):
    """M + c_v C."""
    mass = 1.0 if problem.mass is None else problem.mass
    return mass if problem.damping is None else add(mass, product(problem.damping, c_v, n), n=n)


def _resisted(problem: Problem, rhs, v):
    """The right side less C v."""
    return rhs if problem.damping is None else rhs - times(problem.damping, v)


def load(problem: Problem, t):
    """f(t), or a plain zero that the compiler drops."""
    return 0.0 if problem.load is None else problem.load(t)


def acceleration(problem: Problem, t, u, v, c_v=0.0):
    """Acceleration a that balances M a + C (v + c_v a) + p(u) = f(t): one force, one linear solve, no iteration."""
    rhs = _resisted(problem, load(problem, t) - problem.force(u), v)
    return solve(_inertia(problem, c_v, u.size), rhs)


def initial_acceleration(problem: Problem, u0, v0):
    """Acceleration at t = 0; zero where there is no mass, as the equation of motion tells nothing of it there."""
    if not problem.massless:
        return acceleration(problem, 0.0, u0, v0)
    rhs = _resisted(problem, load(problem, 0.0) - problem.force(u0), v0)
    if not isinstance(problem.mass, Banded) and jnp.ndim(problem.mass) == 1:
        return jnp.where(problem.mass > 0, rhs / problem.mass, 0.0)
    return jnp.linalg.pinv(dense(problem.mass, u0.size), hermitian=True) @ rhs


def balance(problem: Problem, rhs, u, v, c_u, c_v, guess, weight=1.0, force=None, symmetric=True, tolerance=None):
    """Acceleration a that balances M a + C (v + c_v a) + w p(u + c_u a) = r, by Newton-Raphson with the full tangent.

    Parameters
    ----------
    rhs
        r, of the shape of ``u``.
    u, v
        The predictors ũ and ṽ.
    c_u, c_v
        What an acceleration adds to displacement and velocity: numbers, or matrices (n, n) of any form.
    guess
        Where the iteration starts.
    weight
        w, the weight of the internal force.
    force
        The internal force as a function of u + c_u a, where it is not the problem's own p.
    symmetric
        Whether the tangent is, with symmetric M and C.
    tolerance
        Newton stops at the latest once a correction moves the displacement by less than this part of it; that of
        ``TOLERANCES`` where none is given.

    Returns
    -------
    tuple
        The acceleration and the :class:`Effort`, which says where Newton has not converged within ``MAX_ITERATIONS``.
        A number that is not finite ends the iteration at once, and shows in the acceleration.
    """
    force = problem.force if force is None else force
    n, tolerances = u.size, TOLERANCES[u.dtype]
    tolerance = tolerances.displacement if tolerance is None else tolerance
    inertia = _inertia(problem, c_v, n)
    rhs = _resisted(problem, rhs, v)
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
            foretold = moved**3 <= tolerances.foretold * size * before**2
            unfinished &= ~((moved <= tolerances.near * size) & foretold)
        return a, unfinished, moved

    def differentiable(a):
        residual, given = opened_closure(lambda a: times(inertia, a) + weight * force(u + times(c_u, a)) - rhs, a)
        solution, fixed = opened_closure(lambda r, a: solve(internal_and_effective(a)[1], r, symmetric), a, a)
        return root(residual, solution, a, given, fixed)

    nothing = jnp.zeros((), u.dtype)
    opened, given = opened_closure(iterate, guess, nothing)
    given = lax.stop_gradient(given)
    a, unfinished, iterations = lax.stop_gradient(guess), jnp.ones((), bool), jnp.zeros((), int)
    if n <= SMALL:
        # it takes one iteration to correct and one to see that it did; few steps take more, so the loop stands aside
        once, _, moved = opened((a, nothing), given)
        (a, unfinished, _), iterations = opened((once, moved), given), jnp.full((), 2)
    a, unfinished, iterations = iterated(opened, given, (a, unfinished, iterations))
    return differentiable(a), Effort(iterations, ~unfinished)
