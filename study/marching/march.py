"""Time marching as one compiled loop: of a single run, or of a tile of lanes side by side."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.observer.base import Record, Reduction
from study.problem.definition import Problem
from study.scheme.base import Scheme

COMPLETED, NEWTON_FAILED, NOT_FINITE = 0, 1, 2

STATUS_MEANINGS = "completed newton_not_converged not_finite"

#: Steps of a single run with one unknown in one turn of the loop. Within a turn values pass from step to step in
#: registers, between turns through memory, which at ten nanoseconds a step is felt, and with two unknowns no more.
BLOCK = 3

#: Steps of a tile between two looks at whether any of its lanes goes on.
PATIENCE = 64


class Progress(NamedTuple):
    """How far a run has come, and all that it takes to go on.

    ``failure`` is 0 as long as the run goes on; after a failure at step k it is k + 1 where the state is not finite,
    and −(k + 1) where Newton did not converge. ``stored`` has the samples along its first axis. All but ``step``
    have an axis of lanes where there are lanes.
    """

    step: jax.Array
    failure: jax.Array
    state: Any
    carried: tuple
    stored: dict[str, jax.Array]


class Outcome(NamedTuple):
    """What a run gives back.

    ``status`` and ``failed_at_step`` (−1 where nothing failed) always; ``values`` holds the variables of the
    reductions, which mean nothing where a run failed, and ``samples`` those of the records with the samples along the
    first axis, NaN from a failure on.
    """

    status: jax.Array
    failed_at_step: jax.Array
    values: dict[str, jax.Array]
    samples: dict[str, jax.Array]


class March(eqx.Module):
    """A scheme on a problem under observation, as pure functions of its progress.

    With ``lanes`` all of them take and give arrays with an axis of lanes in front: many runs that share each turn of
    the loop, and none of which depends on its neighbours.
    """

    problem: Problem = eqx.field(converter=Problem.untitled)
    scheme: Scheme
    reductions: tuple[Reduction, ...]
    records: tuple[Record, ...]
    lanes: bool = eqx.field(static=True, default=False)

    def _each(self, function):
        """The function of one run, for every lane where there are lanes."""
        return jax.vmap(function) if self.lanes else function

    def _failure(self, state, effort, step):
        """What a failure at this step is recorded as, 0 where there is none."""
        finite = jnp.all(jnp.isfinite(state.u)) & jnp.all(jnp.isfinite(state.v))
        return jnp.where(finite, jnp.where(effort.converged, 0, -(step + 1)), step + 1)

    def _sample(self, initial, state, failure) -> dict[str, jax.Array]:
        values = {n: v for record in self.records for n, v in record.sample(self.problem, initial, state).items()}
        return {name: jnp.where(failure == 0, jnp.asarray(value, float), jnp.nan) for name, value in values.items()}

    def start(self, u0, dt, samples: int) -> tuple[Progress, Any]:
        """Progress at t = 0 with room for ``samples`` samples behind the first, and the initial state."""

        def one(u0, dt):
            state, effort = self.scheme.start(self.problem, u0, jnp.asarray(self.problem.v0), dt)
            carried = tuple(reduction.start(self.problem, state) for reduction in self.reductions)
            failure = self._failure(state, effort, jnp.zeros((), int))
            return state, carried, failure, self._sample(state, state, failure)

        state, carried, failure, first = self._each(one)(u0, dt)
        stored = {n: jnp.full((samples + 1, *v.shape), jnp.nan).at[0].set(v) for n, v in first.items()}
        return Progress(jnp.zeros((), int), failure, state, carried, stored), state

    def _step(self, progress: Progress, dt, steps=None) -> Progress:
        """One step of every run, or with ``steps`` of every lane that has not taken its own."""

        def one(step, state, carried, dt):
            # time is a product, not a running sum, whose round-off would grow with the number of steps
            state, effort = self.scheme.step(self.problem, state, step.astype(dt.dtype) * dt, dt)
            now = (step + 1).astype(dt.dtype) * dt
            carried = tuple(
                reduction.update(c, self.problem, state, now, effort)
                for reduction, c in zip(self.reductions, carried, strict=True)
            )
            return state, carried, self._failure(state, effort, step + 1)

        state, carried, failure = self._each(partial(one, progress.step))(progress.state, progress.carried, dt)
        failure = jnp.where(progress.failure == 0, failure, progress.failure)
        if self.lanes:
            # a lane that has failed goes on as NaN, on which Newton's iteration ends at once; the steps to come carry
            # it from one number of the state to all
            *leaves, last = jax.tree.leaves(state)
            state = jax.tree.unflatten(jax.tree.structure(state), [*leaves, _where(failure == 0, last, jnp.nan)])
        now = Progress(progress.step + 1, failure, state, carried, progress.stored)
        if steps is None:
            return now
        goes_on = progress.step < steps
        return jax.tree.map(partial(_where, goes_on), now, progress)._replace(step=now.step)

    def _advance(self, progress: Progress, step: Callable[[Progress], Progress], until) -> Progress:
        """Up to step ``until``, or until every run has failed."""

        def goes_on(p, ahead=1):
            return (p.step + ahead <= until) & jnp.any(p.failure == 0)

        step = jax.jit(step)  # traced once, however often it is repeated

        def block(p):
            for _ in range(BLOCK):
                p = step(p)
            return p

        def patiently(p):
            pause = jnp.minimum(p.step + PATIENCE, until)
            return lax.while_loop(lambda p: p.step < pause, step, p)

        if self.lanes:
            return lax.while_loop(goes_on, patiently, progress)
        if not np.ndim(self.problem.u0):
            progress = lax.while_loop(partial(goes_on, ahead=BLOCK), block, progress)
        return lax.while_loop(goes_on, step, progress)

    def proceed(self, progress: Progress, initial, dt, until, every, each_step: bool, steps=None) -> Progress:
        """March to step ``until``, with a sample at every ``every`` steps where something is recorded.

        Parameters
        ----------
        progress, initial
            As :meth:`start` gave them, or with the progress of an earlier call.
        until
            Where to pause, or end.
        every, each_step
            Samples are this many steps apart, and whether that is one.
        steps
            Where each lane ends, if not all at ``until``; nothing can be recorded then.
        """

        def step(p):
            return self._step(p, dt)

        def store(p):
            sample = self._each(self._sample)(initial, p.state, p.failure)
            # before the next sample is due its place holds the last state, so that a pause does no harm
            place = (p.step + every - 1) // every if not each_step else p.step
            return p._replace(stored={name: p.stored[name].at[place].set(value) for name, value in sample.items()})

        def next_sample(p):
            return store(
                step(p) if each_step else self._advance(p, step, jnp.minimum((p.step // every + 1) * every, until))
            )

        if not self.records:
            # all lanes together while none has ended, then those that go on
            together = until if steps is None else jnp.minimum(steps.min(), until)
            progress = self._advance(progress, step, together)
            return progress if steps is None else self._advance(progress, lambda p: self._step(p, dt, steps), until)
        return lax.while_loop(lambda p: (p.step < until) & jnp.any(p.failure == 0), next_sample, progress)

    def outcome(self, progress: Progress) -> Outcome:
        """What is known so far; complete at the last step."""

        def one(state, carried):
            return {
                name: value
                for reduction, c in zip(self.reductions, carried, strict=True)
                for name, value in reduction.result(c, self.problem, state).items()
            }

        failure = progress.failure
        failed = jnp.where(failure < 0, NEWTON_FAILED, NOT_FINITE)
        values = self._each(one)(progress.state, progress.carried)
        return Outcome(jnp.where(failure == 0, COMPLETED, failed), jnp.abs(failure) - 1, values, progress.stored)


def _where(condition, value, other):
    """``value`` in the lanes where the condition holds, elsewhere ``other``."""
    return jnp.where(condition.reshape(condition.shape + (1,) * (jnp.ndim(value) - 1)), value, other)


@eqx.filter_jit
def march(
    definition: March,
    u0,
    dt,
    until,
    every,
    samples: int = 0,
    each_step: bool = False,
    steps=None,
    progress: tuple[Progress, Any] | None = None,
) -> tuple[tuple[Progress, Any], Outcome]:
    """March from the start, or from an earlier progress, to step ``until``: the progress, and the outcome so far.

    Parameters
    ----------
    u0, dt
        Initial displacement and step size, of each lane where there are lanes.
    until, every, each_step, steps
        As in :meth:`March.proceed`. All but ``each_step`` may be traced: one compilation serves all.
    samples
        How many samples the run has behind the first.
    """
    now, initial = definition.start(u0, dt, samples) if progress is None else progress
    now = definition.proceed(now, initial, dt, until, every, each_step, steps)
    return (now, initial), definition.outcome(now)
