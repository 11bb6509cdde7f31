"""A run as a pure function, which JAX differentiates, vectorises and compiles with its surroundings."""

import math
import warnings
from collections.abc import Sequence
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.arrays import Scalar, ScalarLike, Vector, VectorLike
from study.algebra.reads import reading, reads_of
from study.marching.arguments import checked_observers, positive_integer, resolve
from study.marching.march import March
from study.mechanics.definition import Problem
from study.mechanics.function_checks import DOUBLE_WHERE, displacements, is_lost_in_reverse, known
from study.observer.base import Observer
from study.observer.named import observers as named_observers
from study.problem.named import problems
from study.scheme.base import Scheme
from study.scheme.named import schemes

#: Number of times at which the derivative of a load is examined.
TIMES = 65


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

    Second derivatives of implicit schemes are right if the first derivative is taken in forward mode, as in
    ``jax.jacfwd(jax.jacfwd(f))`` and ``jax.grad(jax.jacfwd(f))``. They are wrong if the first derivative is taken in
    reverse mode. JAX 0.10 then ignores the rule for derivatives of an implicit root in a scan, even for its own
    ``lax.custom_root``.

    Derivatives in reverse mode are NaN if ``jnp.where`` leaves out a branch that is not finite or has no finite slope,
    such as ``jnp.where(u > 0, u**1.5, 0.0)`` at u < 0. Derivatives in forward mode are right. If JAX traces the run,
    force and load are examined at some displacements and times.

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
        If derivatives in reverse mode of the force or the load are NaN where their values and their derivatives in
        forward mode are finite.

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
    for name, given, own in (("u0", u0, equation.u0), ("v0", v0, equation.v0)):
        if given is not None and np.shape(given) != np.shape(own):
            raise ValueError(f"{name} must have the shape {np.shape(own)} of the problem, not {np.shape(given)}.")
        starts.append(jnp.asarray(own if given is None else given, float))
    if np.ndim(dt) or (not isinstance(dt, jax.core.Tracer) and not (np.isfinite(dt) and dt > 0)):
        raise ValueError(f"dt must be one number, finite and greater than zero, not {dt}.")
    march = March.of(equation, method, chosen)
    if march.records:
        name = next(iter(march.records[0].variables))
        fit = [known for known in named_observers if not March.of(equation, method, [named_observers[known]]).records]
        raise ValueError(
            f"'{name}' is recorded along time, and final_state returns one value per run: observe a reduction, such as "
            f"{', '.join(fit[:3])}, or a Quantity with reduce=."
        )
    with reading(reads_of(march)):
        end = _end(march, starts[0], starts[1], jnp.asarray(dt, float), count)
    if any(isinstance(value, jax.core.Tracer) for value in end.values()):
        _check_derivatives(equation, dt, count)
    return end


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


def _check_derivatives(problem: Problem, dt: ScalarLike, steps: int) -> None:
    """Warn if derivatives in reverse mode would be NaN although derivatives in forward mode are finite."""
    with jax.ensure_compile_time_eval():  # JAX may trace u₀ and Δt
        u = displacements(problem.u0)
        times = np.linspace(0, 1, TIMES) * steps * np.asarray(known(dt))
    functions = {
        "force": None if problem.linear else (lambda u: problem.varying_force(u, problem.v0), u),
        "load": None if problem.load is None else (problem.load, times),
    }
    for name, given in functions.items():
        if given and is_lost_in_reverse(*given):
            warnings.warn(
                f"derivatives in reverse mode, as by jax.grad, are NaN for the {name} of '{problem.title}', although "
                f"derivatives in forward mode, as by jax.jacfwd, are finite: {DOUBLE_WHERE}.",
                RuntimeWarning,
                stacklevel=3,
            )


def _steps(march: March, progress: Any, dt: Scalar, count: int) -> Any:
    """The progress after ``count`` more steps."""
    step = partial(march.stepped, dt=dt)
    return lax.scan(lambda progress, _: (step(progress), None), progress, length=count)[0]
