"""The Newton-Raphson iteration."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.arrays import Scalar, Vector
from study.algebra.round_off import EVALUATIONS


class Tolerances(NamedTuple):
    """Criteria by which Newton's iteration ends, for one floating-point precision.

    Parameters
    ----------
    displacement
        The iteration ends when a correction changes the displacement, or the velocity if the force depends on it, by
        less than this fraction. Convergence is quadratic, so the remaining error is of the order of the square of this
        fraction, which is below round-off.
    near, predicted
        With one unknown and a smooth force the iteration also ends after the second correction, if this correction is
        smaller than ``near`` and the third would be smaller than ``predicted``, both as fractions of the displacement.
        After corrections of the sizes d₁ and d₂ the third is about :math:`d_2^3/d_1^2` (Deuflhard, 2004, section 2.1).
    force, round_off
        With several unknowns the residual before the last correction must also be smaller than the fraction ``force``
        of the forces in balance. This is not required if the correction was smaller than the fraction ``round_off`` of
        the displacement, since the force of a stiff member is not known more accurately.

        If an unknown has no mass, and in runs with a safeguard, the iteration also ends at a correction that is not
        shorter than half of the one before, if the residual of each row is smaller than the fraction ``force`` of the
        forces in this row, plus the fraction ``round_off`` of its
        :func:`sensitivity <study.algebra.round_off.sensitivity>` to its numbers: no row is known more accurately. The
        round-off of a multiplier, for example, grows with 1/Δt².
    """

    displacement: float
    near: float
    predicted: float
    force: float
    round_off: float


TOLERANCES = {
    np.dtype("float64"): Tolerances(1e-12, near=1e-8, predicted=1e-17, force=1e-8, round_off=1e-14),
    np.dtype("float32"): Tolerances(5e-6, near=1e-4, predicted=5e-9, force=1e-4, round_off=5e-6),
}

_LOOSE: ContextVar[float | None] = ContextVar("loose", default=None)


@contextmanager
def ending_at(tolerance: float) -> Iterator[None]:
    """Within this context, iterations are traced with one tolerance for displacement and force, as in other codes."""
    token = _LOOSE.set(tolerance)
    try:
        yield
    finally:
        _LOOSE.reset(token)


def tolerances_of(dtype: np.dtype) -> Tolerances:
    """Tolerances of a floating-point precision.

    Within :func:`ending_at`, the prediction is disabled, and all other criteria have the tolerance of this context.
    """
    loose = _LOOSE.get()
    return TOLERANCES[dtype] if loose is None else Tolerances(loose, 0.0, 0.0, loose, loose)


#: Largest number of Newton iterations, and of further iterations with a safeguard.
MAX_ITERATIONS, MAX_SAFEGUARDED = 50, 1000

#: Fraction of the component of the residual along a correction. The correction is shortened if it changes the sign of
#: the component and leaves more than this fraction of its size.
OVERSHOOT = 0.1

#: Largest number of halvings of a correction.
HALVINGS = 20

#: Largest number of residuals evaluated to shorten a correction. Every second evaluation bisects the bracket, so that
#: the slopes of a force may differ by a factor of up to 2⁵⁰.
MOST_RESIDUALS = 100


def norm(x: Vector | float) -> Scalar:
    """Euclidean norm."""
    return jnp.abs(x) if jnp.ndim(x) == 0 else jnp.sqrt(jnp.sum(x * x))


def _goes_on(carry, most):
    _, _, unfinished, iterations, _ = carry
    return unfinished & (iterations < most)


def any_lane(flags):
    """Whether any flag (lanes,) is set, by joining halves of the array: XLA's reduction takes one flag at a time."""
    lanes = len(flags)
    while lanes > 8 and lanes % 2 == 0:
        lanes //= 2
        flags = flags[:lanes] | flags[lanes:]
    return jnp.any(flags)


def iterated(iterate: Callable, captured, carry: tuple, most: int = MAX_ITERATIONS) -> tuple:
    """Repeat ``a, unfinished, size, more = iterate((a, before), captured)`` while ``unfinished``, up to ``most`` times.

    ``carry`` is ``(a, before, unfinished, iterations, residuals)``, and the result is its final value. ``before`` is
    the size of the last correction. If it is None, every iteration gets a zero in its place, which disables the
    prediction of the next correction: with one unknown, carrying this size costs more than it saves. ``residuals`` is
    the sum of ``more``, the numbers of residuals that iterations evaluate in addition to their own.
    """
    goes_on = partial(_goes_on, most=most)

    def advance(carry, captured):
        a, before, _, iterations, residuals = carry
        a, unfinished, size, more = iterate((a, jnp.zeros((), a.dtype) if before is None else before), captured)
        return a, None if before is None else size, unfinished, iterations + 1, residuals + more

    @jax.custom_batching.custom_vmap
    def to_the_end(carry, captured):
        def loop(carry):
            return lax.while_loop(goes_on, partial(advance, captured=captured), carry)

        # one unknown: two iterations precede the loop, so that most steps skip it
        return loop(carry) if carry[0].ndim else lax.cond(goes_on(carry), loop, lambda carry: carry, carry)

    @to_the_end.def_vmap
    def in_lanes(lanes, batched, carry, captured):
        carry = jax.tree.map(lambda x, b: x if b else jnp.broadcast_to(x, (lanes, *x.shape)), carry, batched[0])
        advance_lanes = jax.vmap(advance, in_axes=(0, jax.tree.map(lambda b: 0 if b else None, batched[1])))

        def those_that_go_on(carry):
            def newest(unfinished, new, old):
                return jax.tree.map(partial(jnp.where, unfinished), new, old)

            return jax.vmap(newest)(goes_on(carry), advance_lanes(carry, captured), carry)

        ended = lax.while_loop(lambda carry: any_lane(goes_on(carry)), those_that_go_on, carry)
        return ended, jax.tree.map(lambda _: True, ended)

    return to_the_end(carry, captured)


def narrowed(bracket: Vector, residual: Vector, correction: Vector) -> Vector:
    """The bracket of one unknown after the next iteration.

    ``bracket`` (4,) holds the acceleration, the accelerations with negative and positive residual, and the last change.
    The next acceleration is Newton's, or the middle of the bracket if Newton's leaves it or converges slowly. Until
    both signs of the residual have occurred, a correction longer than half of the last change is replaced by twice the
    last change, against the sign of the residual. Far from the root the inertia sets this sign.
    """
    a, negative, positive, last = bracket
    negative, positive = jnp.where(residual < 0, a, negative), jnp.where(residual < 0, positive, a)
    new = a - correction
    leaves = (new - negative) * (new - positive) > 0
    crawls = ~(jnp.abs(correction) <= jnp.abs(last) / 2)
    farther = jnp.where(crawls & jnp.isfinite(last), a - 2 * jnp.sign(residual) * jnp.abs(last), new)
    nearer = jnp.where(leaves | crawls, (negative + positive) / 2, new)
    new = jnp.where(jnp.isfinite(negative) & jnp.isfinite(positive), nearer, farther)
    return jnp.stack([new, negative, positive, new - a])


def backtracked(residual: Callable, a: Vector, correction: Vector, solved: Callable) -> tuple[Vector, jax.Array]:
    """A Newton correction of several unknowns, halved until the next correction with the same tangent is shorter.

    The number of residuals evaluated is returned too.

    After a part λ of the correction, the next correction must be at most 1 − λ/4 times as long as the whole one. There
    are at most ``HALVINGS`` halvings. This natural monotonicity test depends neither on units nor on how stiff a member
    is.

    References
    ----------
    P. Deuflhard, Newton methods for nonlinear problems, Springer, 2004, section 3.3.
    """

    def too_long(carry):
        part, halvings = carry
        following = solved(residual(a - part * correction))
        return ~(norm(following) <= (1 - part / 4) * norm(correction)) & (halvings < HALVINGS)

    start = jnp.ones((), a.dtype), jnp.zeros((), int)
    part, halvings = lax.while_loop(too_long, lambda carry: (carry[0] / 2, carry[1] + 1), start)
    return part * correction, halvings + 1


def shortened(
    residual: Callable,
    a: Vector,
    correction: Vector,
    out_of_balance: Vector,
    settled: jax.Array,
    round_off: Callable[[], Vector] | None,
) -> tuple[Vector, jax.Array]:
    """A Newton correction of several unknowns, shortened until the component of the residual along it nearly vanishes.

    A correction that is ``settled``, so small that the iteration ends, is returned unchanged. The number of residuals
    evaluated is returned too.

    A correction that is short enough (``OVERSHOOT``) is returned unchanged. The same holds for a correction after which
    the residual is within ``round_off()``, if it is given. If the tangent is symmetric and positive definite, a
    shortened correction ends where the energy along it is least, and every correction reduces the distance to the
    solution. The length is found by secants and bisections in turn. The secants use the Illinois method: the value at
    an end that stays is halved.
    """

    def along(part):
        return jnp.vdot(correction, residual(a - part * correction))

    def searches(carry):
        *_, is_short, evaluations = carry
        return ~is_short & (evaluations < MOST_RESIDUALS)

    def evaluate(carry):
        low, at_low, high, at_high, _, evaluations = carry
        secant = (low * at_high - high * at_low) / (at_high - at_low)
        part = jnp.where(evaluations % 2 == 0, jnp.clip(secant, 0.99 * low + 0.01 * high, high), (low + high) / 2)
        value = along(part)
        opposite, is_short = value * before < 0, jnp.abs(value) <= OVERSHOOT * jnp.abs(before)
        low, at_low = jnp.where(opposite, low, part), jnp.where(opposite, at_low / 2, value)
        high, at_high = jnp.where(opposite | is_short, part, high), jnp.where(opposite, value, at_high / 2)
        return low, at_low, high, at_high, is_short, evaluations + 1

    before, whole = jnp.vdot(correction, out_of_balance), along(jnp.ones((), a.dtype))
    beyond = ~settled & (whole * before < 0) & (jnp.abs(whole) > OVERSHOOT * jnp.abs(before))
    is_short, examined = ~beyond, jnp.zeros((), int)
    if round_off is not None:
        limit = lax.cond(beyond, lambda: jnp.vdot(jnp.abs(correction), round_off()), lambda: 0.0 * whole)
        is_short, examined = is_short | (jnp.abs(whole) <= limit), jnp.where(beyond, EVALUATIONS, 0)
    ends = jnp.zeros((), a.dtype), before, jnp.ones((), a.dtype), whole
    _, _, part, *_, evaluations = lax.while_loop(searches, evaluate, (*ends, is_short, jnp.zeros((), int)))
    return part * correction, evaluations + 1 + examined


def opened_closure(function: Callable, *examples) -> tuple[Callable, list]:
    """The function with its captured arrays as further arguments, and these arrays.

    In an ensemble, JAX batches the arguments of the function over the lanes, but not its captured arrays.
    """
    closed, structure = jax.tree.flatten(eqx.filter_closure_convert(function, *examples))
    arrays, rest = eqx.partition(closed, eqx.is_array)

    def opened(arguments, arrays):
        return jax.tree.unflatten(structure, eqx.combine(arrays, rest))(*arguments)

    return opened, arrays


@partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2))
def root(residual: Callable, solution: Callable, whole: bool, a: Vector, captured, fixed) -> Vector:
    """The given root ``a`` of ``residual((a,), captured)``, with its derivative with respect to ``captured``.

    ``solution((r, a), fixed)`` is Newton's correction for a residual r. Unless its matrix is known to be the ``whole``
    tangent, the derivative is NaN where the matrix lacks entries of the tangent: the iteration converges without them,
    and the derivative would be wrong.
    """
    return a


@partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2))
def _corrected(residual: Callable, solution: Callable, whole: bool, a: Vector, captured, fixed) -> Vector:
    """As :func:`root`, with one correction more, below round-off, whose own derivative is that of the root.

    JAX 0.10 ignores the rule below where it differentiates a derivative in reverse mode within a scan.
    """
    a = lax.stop_gradient(a)
    return a - solution((residual((a,), captured), a), fixed)


@root.defjvp
@_corrected.defjvp
def _derivative_of_root(residual, solution, whole, primals, tangents):
    """Derivative by the implicit function theorem, not through the iteration."""
    _, captured, fixed = primals
    a = _corrected(residual, solution, whole, *primals)
    _, change = jax.jvp(lambda captured: residual((a,), captured), (captured,), (tangents[1],))
    derivative = -solution((change, a), fixed)
    if not whole:
        lacks = _lacks_entries(residual, solution, *lax.stop_gradient((a, captured, fixed)))
        derivative *= jnp.where(lacks, jnp.nan, 1.0)
    return a, derivative


def _lacks_entries(residual: Callable, solution: Callable, a: Vector, captured, fixed) -> jax.Array:
    """Whether the product of the tangent with a vector changes if the vector is recovered from it by ``solution``."""
    _, product = jax.linearize(lambda a: residual((a,), captured), a)
    along = product(jnp.cos(jnp.arange(a.size, dtype=a.dtype)))
    again = product(solution((along, a), fixed))
    return jnp.abs(again - along).max() > tolerances_of(a.dtype).force * jnp.abs(along).max()
