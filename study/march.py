"""Time marching as one compiled loop."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax

from study.observers import Record, Reduction
from study.problem import Problem
from study.schemes.scheme import Scheme

COMPLETED, NEWTON_FAILED, NOT_FINITE = 0, 1, 2
STATUS_MEANINGS = "completed newton_not_converged not_finite"


class _Progress(NamedTuple):
    """What one step hands to the next."""

    step: jax.Array
    status: jax.Array
    state: Any
    carried: tuple


class Outcome(NamedTuple):
    """What a run gives back.

    ``status`` and ``failed_at_step`` (−1 where nothing failed) always; ``values`` holds the variables of the
    reductions, ``samples`` those of the records with the samples along the first axis.
    """

    status: jax.Array
    failed_at_step: jax.Array
    values: dict[str, jax.Array]
    samples: dict[str, jax.Array]


def _status_after(state, effort):
    finite = jnp.all(jnp.isfinite(state.u)) & jnp.all(jnp.isfinite(state.v))
    return jnp.where(finite, jnp.where(effort.converged, COMPLETED, NEWTON_FAILED), NOT_FINITE)


def _or_nan(valid, values: dict) -> dict:
    return {name: jnp.where(valid, jnp.asarray(value, float), jnp.nan) for name, value in values.items()}


def march(
    problem: Problem,
    scheme: Scheme,
    reductions: tuple[Reduction, ...],
    records: tuple[Record, ...],
    u0,
    dt,
    steps,
    samples: int = 0,
) -> Outcome:
    """March ``steps`` steps of Δt from (u0, problem.v0), observed as it goes.

    The loop ends at the first step whose Newton iteration does not converge or whose state is not finite; the status
    tells which and where. Values of a run that failed are NaN, and so are its samples from the failure on.

    Parameters
    ----------
    u0
        Initial displacement, of the problem's shape.
    dt, steps
        Step size and number of steps. Both may be traced: one compilation serves all.
    samples
        How many times the records are stored after t = 0, evenly spread; it must divide ``steps``. Without records 0.
    """

    def step(progress: _Progress) -> _Progress:
        # time is a product, not a running sum, whose round-off would grow with the number of steps
        state, effort = scheme.step(problem, progress.state, progress.step.astype(dt.dtype) * dt, dt)
        carried = tuple(
            reduction.update(c, problem, state, effort)
            for reduction, c in zip(reductions, progress.carried, strict=True)
        )
        return _Progress(progress.step + 1, _status_after(state, effort), state, carried)

    def advance(progress: _Progress, until) -> _Progress:
        return lax.while_loop(lambda p: (p.step < until) & (p.status == COMPLETED), step, progress)

    def sample(state) -> dict:
        return {name: value for record in records for name, value in record.sample(problem, initial, state).items()}

    dt, steps = jnp.asarray(dt), jnp.asarray(steps)
    initial, effort = scheme.start(problem, u0, jnp.asarray(problem.v0), dt)
    progress = _Progress(
        jnp.zeros((), int),
        _status_after(initial, effort),
        initial,
        tuple(reduction.start(problem, initial) for reduction in reductions),
    )
    stored = {}
    if records:
        every = steps // samples

        def to_next_sample(progress, k):
            progress = advance(progress, (k + 1) * every)
            return progress, _or_nan(progress.status == COMPLETED, sample(progress.state))

        first = sample(initial)
        progress, rest = lax.scan(to_next_sample, progress, jnp.arange(samples))
        stored = {name: jnp.concatenate([first[name][None], rest[name]]) for name in first}
    else:
        progress = advance(progress, steps)

    completed = progress.status == COMPLETED
    values = {
        name: value
        for reduction, carried in zip(reductions, progress.carried, strict=True)
        for name, value in reduction.result(carried, problem, progress.state).items()
    }
    return Outcome(
        progress.status,
        jnp.where(completed, -1, progress.step),
        _or_nan(completed, values),
        stored,
    )


march_one = eqx.filter_jit(march)
