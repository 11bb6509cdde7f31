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

from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.linear import SMALL, Banded, add, dense, product, solve, times
from study.problem import Problem
from study.tangent import force_and_tangent


class Tolerances(NamedTuple):
    """When Newton stops, by the precision of the numbers.

    Parameters
    ----------
    displacement
        Once a correction moves the displacement by less than this part of it. Convergence is quadratic, so the error
        that is left is of the order of the square: round-off.
    near, foretold
        With one unknown also once the second correction, of less than the first part, foretells that the third would be
        less than the second part: after |d₁| and |d₂| comes about |d₂|³/|d₁|² (Deuflhard, 2004, section 2.1).
    force, round_off
        With several unknowns the force that the last correction removed must also have been less than this part of the
        forces in the balance, unless the correction was round-off: a stiff member's force is no better known than that.
    """

    displacement: float
    near: float
    foretold: float
    force: float
    round_off: float


TOLERANCES = {
    np.dtype("float64"): Tolerances(1e-12, near=1e-8, foretold=1e-17, force=1e-8, round_off=1e-14),
    np.dtype("float32"): Tolerances(5e-6, near=1e-4, foretold=5e-9, force=1e-4, round_off=5e-6),
}
MAX_ITERATIONS = 50


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


def _norm(x):
    """Euclidean norm."""
    return jnp.abs(x) if jnp.ndim(x) == 0 else jnp.sqrt(jnp.sum(x * x))


def _goes_on(carry):
    _, unfinished, iterations = carry
    return unfinished & (iterations < MAX_ITERATIONS)


def _any(flags):
    """Whether any flag of (lanes,) is set, by halves as far as that goes: XLA's own reduction takes one at a time."""
    lanes = len(flags)
    while lanes > 8 and lanes % 2 == 0:
        lanes //= 2
        flags = flags[:lanes] | flags[lanes:]
    return jnp.any(flags)


def _iterated(iterate, given, carry):
    """``(a, unfinished, iterations)`` after as many turns of ``a, unfinished, _ = iterate((a, 0), given)`` as it takes.

    Zero foretells nothing: to hand on how far the last turn moved takes longer than it saves.
    """

    def again(carry, given):
        a, _, iterations = carry
        a, unfinished, _ = iterate((a, jnp.zeros((), a.dtype)), given)
        return a, unfinished, iterations + 1

    @jax.custom_batching.custom_vmap
    def to_the_end(carry, given):
        def loop(carry):
            return lax.while_loop(_goes_on, partial(again, given=given), carry)

        return loop(carry) if carry[0].size > SMALL else lax.cond(_goes_on(carry), loop, lambda carry: carry, carry)

    @to_the_end.def_vmap
    def in_lanes(lanes, batched, carry, given):
        carry = jax.tree.map(lambda x, b: x if b else jnp.broadcast_to(x, (lanes, *x.shape)), carry, batched[0])
        each = jax.vmap(again, in_axes=(0, jax.tree.map(lambda b: 0 if b else None, batched[1])))

        def those_that_go_on(carry):
            def newest(goes_on, new, old):
                return jax.tree.map(partial(jnp.where, goes_on), new, old)

            return jax.vmap(newest)(_goes_on(carry), each(carry, given), carry)

        return lax.while_loop(lambda carry: _any(_goes_on(carry)), those_that_go_on, carry), (True,) * 3

    return to_the_end(carry, given)


def _opened(function, *examples):
    """The function with what it closes over as arguments, and these: (lanes of) arrays must not pass unseen."""
    closed, structure = jax.tree.flatten(eqx.filter_closure_convert(function, *examples))
    arrays, rest = eqx.partition(closed, eqx.is_array)

    def opened(arguments, arrays):
        return jax.tree.unflatten(structure, eqx.combine(arrays, rest))(*arguments)

    return opened, arrays


@partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def _root(residual, solution, a, given, fixed):
    """The root a of ``residual((a,), given)``; ``solution((r, a), fixed)`` solves with the residual's slope there."""
    return a


@_root.defjvp
def _derivative_of_root(residual, solution, primals, tangents):
    """Not through the iteration, but by the implicit function theorem."""
    _, given, fixed = primals
    a = _root(residual, solution, *primals)
    _, change = jax.jvp(lambda given: residual((a,), given), (given,), (tangents[1],))
    return a, -solution((change, a), fixed)


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
        moved, size = _norm(times(c_u, correction)), _norm(u) + _norm(times(c_u, a))
        unfinished = moved > tolerance * size
        if jnp.ndim(u):
            forces = _norm(inertial) + _norm(internal) + _norm(rhs)
            unfinished |= (_norm(out_of_balance) > tolerances.force * forces) & (moved > tolerances.round_off * size)
        else:
            foretold = moved**3 <= tolerances.foretold * size * before**2
            unfinished &= ~((moved <= tolerances.near * size) & foretold)
        return a, unfinished, moved

    def differentiable(a):
        residual, given = _opened(lambda a: times(inertia, a) + weight * force(u + times(c_u, a)) - rhs, a)
        solution, fixed = _opened(lambda r, a: solve(internal_and_effective(a)[1], r, symmetric), a, a)
        return _root(residual, solution, a, given, fixed)

    nothing = jnp.zeros((), u.dtype)
    opened, given = _opened(iterate, guess, nothing)
    given = lax.stop_gradient(given)
    a, unfinished, iterations = lax.stop_gradient(guess), jnp.ones((), bool), jnp.zeros((), int)
    if n <= SMALL:
        # it takes one iteration to correct and one to see that it did; few steps take more, so the loop stands aside
        once, _, moved = opened((a, nothing), given)
        (a, unfinished, _), iterations = opened((once, moved), given), jnp.full((), 2)
    a, unfinished, iterations = _iterated(opened, given, (a, unfinished, iterations))
    return differentiable(a), Effort(iterations, ~unfinished)
