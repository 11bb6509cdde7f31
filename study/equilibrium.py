"""The one balance of forces that every scheme asks for, and the Newton-Raphson iteration that finds it.

In every implicit scheme the new displacement and velocity are affine in one unknown acceleration a,

    u = ũ + c_u a,    u̇ = ṽ + c_v a,    M a + C (ṽ + c_v a) + w p(ũ + c_u a) = r,

so a scheme is its ũ, ṽ, c_u, c_v, the weight w of its internal force and its right side r.
"""

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


class Effort(NamedTuple):
    """What a step took: Newton iterations (each one force, one tangent, one solve), and whether they converged."""

    iterations: jax.Array | int = 0
    converged: jax.Array | bool = True


class Motion(NamedTuple):
    """Displacement, velocity and (algorithmic) acceleration at one time, each of shape () or (n,)."""

    u: jax.Array
    v: jax.Array
    a: jax.Array


def _times(matrix, x):
    return matrix @ x if jnp.ndim(matrix) == 2 else matrix * x


def _sum(*terms, size):
    """Sum of numbers, diagonals (n,) and matrices (n, n), in the least of these forms that holds it."""
    if max(map(jnp.ndim, terms)) == 2:
        terms = [t if jnp.ndim(t) == 2 else jnp.diag(jnp.broadcast_to(t, size)) for t in terms]
    return sum(terms[1:], start=terms[0])


def _solve(matrix, rhs):
    return jnp.linalg.solve(matrix, rhs) if jnp.ndim(matrix) == 2 else rhs / matrix


def _inertia(problem: Problem, c_v, size):
    """M + c_v C."""
    mass = 1.0 if problem.mass is None else problem.mass
    return mass if problem.damping is None else _sum(mass, c_v * problem.damping, size=size)


def _resisted(problem: Problem, rhs, v):
    """The right side less C v."""
    return rhs if problem.damping is None else rhs - _times(problem.damping, v)


def load(problem: Problem, t):
    """f(t), or a plain zero that the compiler drops."""
    return 0.0 if problem.load is None else problem.load(t)


def acceleration(problem: Problem, t, u, v, c_v=0.0):
    """Acceleration a that balances M a + C (v + c_v a) + p(u) = f(t): one force, one linear solve, no iteration."""
    rhs = _resisted(problem, load(problem, t) - problem.force(u), v)
    return _solve(_inertia(problem, c_v, u.shape), rhs)


def _force_and_tangent(problem: Problem, u):
    """p(u) and its full derivative ∂p/∂u by automatic differentiation."""
    if jnp.ndim(u) == 0:
        return jax.jvp(problem.force, (u,), (jnp.ones_like(u),))
    tangent, force = jax.jacfwd(lambda x: (problem.force(x),) * 2, has_aux=True)(u)
    return force, tangent


def balance(problem: Problem, rhs, u, v, c_u, c_v, guess, weight=1.0):
    """Acceleration a that balances M a + C (v + c_v a) + w p(u + c_u a) = r, by Newton-Raphson with the full tangent.

    Parameters
    ----------
    rhs
        r, of the shape of ``u``.
    u, v
        The predictors ũ and ṽ.
    c_u, c_v
        What an acceleration adds to displacement and velocity.
    guess
        Where the iteration starts.
    weight
        w, the weight of the internal force.

    Returns
    -------
    tuple
        The acceleration and the :class:`Effort`, which says where Newton has not converged within ``MAX_ITERATIONS``.
        A number that is not finite ends the iteration at once, and shows in the acceleration.
    """
    inertia = _inertia(problem, c_v, u.shape)
    rhs = _resisted(problem, rhs, v)

    def iterate(a):
        force, tangent = _force_and_tangent(problem, u + c_u * a)
        inertial = _times(inertia, a)
        correction = _solve(_sum(inertia, weight * c_u * tangent, size=u.shape), inertial + weight * force - rhs)
        a = a - correction
        moved = jnp.max(jnp.abs(c_u * correction))
        return a, moved > TOLERANCE * jnp.max(jnp.abs(u) + jnp.abs(c_u * a))

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
