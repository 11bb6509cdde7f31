"""The one balance of forces that every scheme asks for, and the Newton-Raphson iteration that finds it.

In every implicit scheme the new displacement and velocity are affine in one unknown acceleration a,

    u = ũ + c_u a,    u̇ = ṽ + c_v a,    M a + C (ṽ + c_v a) + w p(ũ + c_u a) = r,

so a scheme is its ũ, ṽ, c_u, c_v, the weight w of its internal force and its right side r.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax

from study.problem import Problem

#: Newton stops once a correction moves the displacement by less than this part of it. Convergence is quadratic, so
#: the error that is left is of the order of the square: round-off.
TOLERANCE = 1e-12
MAX_ITERATIONS = 50
#: Systems of up to this many unknowns are eliminated in place.
SMALL = 4


class Effort(NamedTuple):
    """What a step took: Newton iterations (each one tangent and one solve), and whether they converged."""

    iterations: jax.Array | int = 0
    converged: jax.Array | bool = True

    def then(self, other: "Effort") -> "Effort":
        """What two balances took together."""
        return Effort(self.iterations + other.iterations, self.converged & other.converged)


class Phase(NamedTuple):
    """Displacement and velocity, each of shape () or (n,)."""

    u: jax.Array
    v: jax.Array


class Motion(NamedTuple):
    """Displacement, velocity and (algorithmic) acceleration at one time, each of shape () or (n,)."""

    u: jax.Array
    v: jax.Array
    a: jax.Array


def times(matrix, x):
    """Product of a number, a diagonal (n,) or a matrix (n, n) with a vector."""
    return matrix @ x if jnp.ndim(matrix) == 2 else matrix * x


def add(*terms, size):
    """Sum of numbers, diagonals (n,) and matrices (n, n), in the least of these forms that holds it."""
    if max(map(jnp.ndim, terms)) == 2:
        terms = [t if jnp.ndim(t) == 2 else jnp.diag(jnp.broadcast_to(t, size)) for t in terms]
    return sum(terms[1:], start=terms[0])


def _product(one, other):
    """Product of a number, a diagonal (n,) or a matrix (n, n) with a number or a matrix."""
    if jnp.ndim(one) == 2 and jnp.ndim(other) == 2:
        return one @ other
    return one[:, None] * other if jnp.ndim(one) == 1 and jnp.ndim(other) == 2 else one * other


def _eliminate(matrix, rhs):
    """Gaussian elimination with partial pivoting, written out: a call of LAPACK would take longer."""
    n = len(rhs)
    rows = [[*(matrix[i, j] for j in range(n)), rhs[i]] for i in range(n)]
    for k in range(n):
        for i in range(k + 1, n):
            swap = jnp.abs(rows[i][k]) > jnp.abs(rows[k][k])
            pivot = [jnp.where(swap, lower, upper) for upper, lower in zip(rows[k], rows[i], strict=True)]
            rest = [jnp.where(swap, upper, lower) for upper, lower in zip(rows[k], rows[i], strict=True)]
            factor = rest[k] / pivot[k]
            rows[k], rows[i] = pivot, [low - factor * high for low, high in zip(rest, pivot, strict=True)]
    x: list = []
    for k in reversed(range(n)):
        known = sum(rows[k][n - 1 - i] * x[i] for i in range(len(x)))
        x.append((rows[k][n] - known) / rows[k][k])
    return jnp.stack(x[::-1])


def solve(matrix, rhs):
    """Solution of a linear system with a number, a diagonal or a matrix; a small one is eliminated in place."""
    if jnp.ndim(matrix) < 2:
        return rhs / matrix
    return _eliminate(matrix, rhs) if len(rhs) <= SMALL else jnp.linalg.solve(matrix, rhs)


def _inertia(problem: Problem, c_v, size):
    """M + c_v C."""
    mass = 1.0 if problem.mass is None else problem.mass
    return mass if problem.damping is None else add(mass, _product(problem.damping, c_v), size=size)


def _resisted(problem: Problem, rhs, v):
    """The right side less C v."""
    return rhs if problem.damping is None else rhs - times(problem.damping, v)


def load(problem: Problem, t):
    """f(t), or a plain zero that the compiler drops."""
    return 0.0 if problem.load is None else problem.load(t)


def acceleration(problem: Problem, t, u, v, c_v=0.0):
    """Acceleration a that balances M a + C (v + c_v a) + p(u) = f(t): one force, one linear solve, no iteration."""
    rhs = _resisted(problem, load(problem, t) - problem.force(u), v)
    return solve(_inertia(problem, c_v, u.shape), rhs)


def force_and_tangent(force: Callable, u):
    """p(u) and its full derivative ∂p/∂u by automatic differentiation."""
    if jnp.ndim(u) == 0:
        return jax.jvp(force, (u,), (jnp.ones_like(u),))
    tangent, value = jax.jacfwd(lambda x: (force(x),) * 2, has_aux=True)(u)
    return value, tangent


def balance(problem: Problem, rhs, u, v, c_u, c_v, guess, weight=1.0, force=None):
    """Acceleration a that balances M a + C (v + c_v a) + w p(u + c_u a) = r, by Newton-Raphson with the full tangent.

    Parameters
    ----------
    rhs
        r, of the shape of ``u``.
    u, v
        The predictors ũ and ṽ.
    c_u, c_v
        What an acceleration adds to displacement and velocity: numbers, or matrices (n, n).
    guess
        Where the iteration starts.
    weight
        w, the weight of the internal force.
    force
        The internal force as a function of u + c_u a, where it is not the problem's own p.

    Returns
    -------
    tuple
        The acceleration and the :class:`Effort`, which says where Newton has not converged within ``MAX_ITERATIONS``.
        A number that is not finite ends the iteration at once, and shows in the acceleration.
    """
    force = problem.force if force is None else force
    inertia = _inertia(problem, c_v, u.shape)
    rhs = _resisted(problem, rhs, v)

    def iterate(a):
        internal, tangent = force_and_tangent(force, u + times(c_u, a))
        out_of_balance = times(inertia, a) + weight * internal - rhs
        correction = solve(add(inertia, _product(tangent, weight * c_u), size=u.shape), out_of_balance)
        a = a - correction
        moved = jnp.max(jnp.abs(times(c_u, correction)))
        return a, moved > TOLERANCE * jnp.max(jnp.abs(u) + jnp.abs(times(c_u, a)))

    def again(carry):
        a, _, iterations = carry
        return *iterate(a), iterations + 1

    def to_go(carry):
        _, unfinished, iterations = carry
        return unfinished & (iterations < MAX_ITERATIONS)

    # it takes one iteration to correct and one to see that it did; few steps take more, so the loop stands aside
    once, _ = iterate(guess)
    a, unfinished = iterate(once)
    a, unfinished, iterations = lax.cond(
        unfinished, partial(lax.while_loop, to_go, again), lambda carry: carry, (a, unfinished, jnp.full((), 2))
    )
    return a, Effort(iterations, ~unfinished)
