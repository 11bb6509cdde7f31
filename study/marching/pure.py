"""A run as a pure function, which JAX differentiates, vectorises and compiles with its surroundings."""

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.arrays import Scalar, ScalarLike, Vector, VectorLike, real_numbers
from study.algebra.derivatives import watched
from study.algebra.reads import reading, reads_of
from study.marching.arguments import checked_observers, positive_integer, resolve
from study.marching.march import March
from study.mechanics.definition import Problem
from study.mechanics.function_checks import DOUBLE_WHERE
from study.observer.base import Observer
from study.observer.named import observers as named_observers
from study.problem.named import problems
from study.scheme.base import Scheme
from study.scheme.named import schemes


def final_state(
    problem: str | Problem,
    scheme: str | Scheme,
    *,
    dt: ScalarLike,
    steps: int,
    observe: str | Observer | Sequence[str | Observer] = (),
    u0: VectorLike | None = None,
    v0: VectorLike | None = None,
) -> dict[str, jax.Array]:
    """The final state and reductions of a run, as a pure function of all numbers in problem, scheme, dt, u0 and v0.

    ``jax.grad``, ``jax.jvp``, ``jax.vmap`` and ``jax.jit`` apply to this function, also if the problem depends on their
    arguments. Newton's iteration is differentiated by the implicit function theorem, exactly and not iteration by
    iteration. Derivatives in reverse mode keep about 2√steps states and march twice.

    Newton's iteration has no safeguard here unless the problem comes from ``with_safeguard()``. The displacement has no
    bound, and a step beyond the stability limit is not reported.

    Third derivatives of implicit schemes are right if the first and the second are taken in forward mode.

    Where steps end at kinks of the load, such as samples of a record, the motion has no derivative with respect to
    ``dt`` or to the times of the kinks; the value returned there is that of neither side.

    Derivatives are NaN where the force couples unknowns that the form of its tangent leaves out, see ``tangent`` of
    :class:`study.Problem`, and where a function has no finite derivative, such as ``jnp.sqrt(u**2)`` at u = 0.
    Derivatives in reverse mode are also NaN if ``jnp.where`` leaves out a branch that is not finite or has no finite
    slope, such as ``jnp.where(u > 0, u**1.5, 0.0)`` at u < 0. A warning is given when such a derivative is computed.

    Parameters
    ----------
    problem, scheme, dt, u0, v0
        As in :func:`study.run`, but not for an ensemble: use ``jax.vmap``.
    steps
        Number of steps, which is fixed when JAX compiles.
    observe
        Names in ``study.observers``, or your own :class:`study.Reduction` or reduced :class:`study.Quantity`.

    Returns
    -------
    dict
        ``u`` and ``v`` at the end, ``failed_at_step`` (−1 for a run that completed), and the variables observed.

    Warns
    -----
    RuntimeWarning
        If a computed derivative is NaN.

    Raises
    ------
    ValueError
        If an observer records along time, if scheme or observers do not fit the problem, or if ``dt``, ``steps`` or
        the shape of ``u0`` or ``v0`` is invalid.

    Examples
    --------
    >>> import jax, study
    >>> def end(stiffness):
    ...     spring = study.Problem(lambda u: stiffness * u, u0=1.0)
    ...     end = study.final_state(spring, "average_acceleration", dt=0.01, steps=100)
    ...     return end["u"]
    >>> print(f"{jax.grad(end)(4.0):.4f}")
    -0.2273
    """
    equation = resolve(problem, problems, Problem)
    method = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    chosen = checked_observers(observe)
    count = positive_integer("steps", steps)
    for reason in (method.refusal(equation), *(observer.refusal(equation) for observer in chosen)):
        if reason:
            raise ValueError(reason)
    starts = []
    for name, start, default in (("u0", u0, equation.u0), ("v0", v0, equation.v0)):
        given = default if start is None else start
        if any(isinstance(x, jax.core.Tracer) for x in jax.tree.leaves(given)):
            given = jnp.asarray(given, float)
        elif not np.isfinite(real_numbers(name, given)).all():
            raise ValueError(f"{name} must be finite, not {given!r}.")
        if np.shape(given) != np.shape(default):
            raise ValueError(f"{name} must have the shape {np.shape(default)} of the problem, not {np.shape(given)}.")
        starts.append(jnp.asarray(given, float))
    if np.ndim(dt) or not (isinstance(dt, jax.core.Tracer) or 0 < real_numbers("dt", dt) < np.inf):
        raise ValueError(f"dt must be one number, finite and greater than zero, not {dt}.")
    march = March.of(equation, method, chosen)
    if march.records:
        name = next(iter(march.records[0].variables))
        fit = [known for known in named_observers if not March.of(equation, method, [named_observers[known]]).records]
        raise ValueError(
            f"'{name}' is recorded along time, and final_state returns one value per run: observe a reduction, such as "
            f"{', '.join(fit[:3])}, or a Quantity with reduce=."
        )
    arguments, reads = (starts[0], starts[1], jnp.asarray(dt, float)), reads_of(march)
    with reading(reads):
        if not (reads.traced or any(isinstance(x, jax.core.Tracer) for x in jax.tree.leaves((march, arguments)))):
            return _end(march, *arguments, count)
        message = (
            f"a derivative of the final state of '{equation.title}' is NaN, because the run failed, because the force "
            "couples unknowns that the form of its tangent leaves out (declare it with Problem(tangent='dense')), or "
            f"because a function of the problem has no finite derivative where its value is finite: {DOUBLE_WHERE}."
        )
        # the numbers that JAX differentiates may also be captured by functions
        converted, numbers = jax.closure_convert(lambda u0, v0, dt: _end(march, u0, v0, dt, count), *arguments)
        return watched(converted(*watched(arguments, message), *watched(numbers, message)), message)


@eqx.filter_jit
def _end(march: March, u0: Vector, v0: Vector, dt: Scalar, count: int) -> dict[str, jax.Array]:
    """The final state and the variables of the observers."""
    progress = march.start(u0, v0, dt, 0)[0]
    block = max(math.isqrt(count), 1)

    @jax.checkpoint
    def several(progress, _):
        return _steps(march, progress, dt, block), None

    progress, _ = lax.scan(several, progress, length=count // block)
    progress = _steps(march, progress, dt, count % block)
    failure, values = march.result(progress)
    return {"u": progress.state.u, "v": progress.state.v, "failed_at_step": failure // 3 - 1, **values}


def _steps(march: March, progress: Any, dt: Scalar, count: int) -> Any:
    """The progress after ``count`` more steps."""
    step = partial(march.stepped, dt=dt)
    return lax.scan(lambda progress, _: (step(progress), None), progress, length=count)[0]
