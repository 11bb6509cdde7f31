"""Time marching as one compiled loop: of a single run, or of a tile of lanes side by side."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.matrices import SMALL
from study.marching import kernel
from study.marching.components import across, joined, together
from study.mechanics.definition import Problem
from study.observer.base import Observer, Record, Reduction
from study.observer.diagnostics import Restarts
from study.scheme.base import Scheme
from study.scheme.contract import started, stepped
from study.scheme.wrapper.linearised import Linearised
from study.scheme.wrapper.with_history import WithHistory

#: Number of steps of a tile between two checks whether any of its lanes still runs.
PATIENCE = 64


class Progress(NamedTuple):
    """The progress of a run, with everything needed to continue it.

    With lanes, every array except ``step`` has an axis of lanes in front, or is divided into
    :class:`study.marching.components.Components`.

    Attributes
    ----------
    step
        Number of steps taken.
    failure
        0 without a failure. After a failure at step k: 3 (k + 1), plus 0 if no balance was found, 1 if the state
        was not finite, or 2 if the displacement left its bound.
    state
        State of the scheme.
    carried
        State of each reduction.
    """

    step: jax.Array
    failure: jax.Array
    state: Any
    carried: tuple


class _Unmade(NamedTuple):
    """What a march must know of the problems of a family before it makes them."""

    u0: np.ndarray
    safeguarded: bool


class March(eqx.Module):
    """A scheme on a problem with its observers, as pure functions of :class:`Progress`.

    With ``lanes``, the functions take and return arrays with an axis of lanes. The lanes share each turn of the loop,
    and none depends on its neighbours. In a family, each lane has its own problem.
    """

    problem: Problem
    scheme: Scheme
    reductions: tuple[Reduction, ...]
    records: tuple[Record, ...]
    lanes: bool = eqx.field(static=True, default=False)
    #: Largest displacement, beyond which a run ends as unbounded.
    bound: float = eqx.field(default=np.inf, converter=np.float64)
    #: Function that makes the problem of a lane, or None.
    make: Callable[..., Problem] | None = None
    #: Arguments of ``make`` in all lanes.
    arguments: Any = None
    #: Whether blocks of lanes march in kernels.
    in_kernels: bool = eqx.field(static=True, default=False)

    @classmethod
    def of(
        cls,
        problem: Problem,
        scheme: Scheme,
        observers: Sequence[Observer],
        lanes: bool = False,
        bound: float = np.inf,
        make: Callable[..., Problem] | None = None,
    ) -> "March":
        """The march of a scheme on a problem, or on the problems that ``make`` returns.

        The scheme is wrapped in :class:`WithHistory` if the problem has a history, and in :class:`Linearised` if an
        observer needs a neighbouring run.
        """
        if problem.history is not None:
            scheme = WithHistory(scheme=scheme)
        if any(observer.needs_neighbour for observer in observers):
            scheme = Linearised(scheme=scheme)
        parts = [observer.marched() for observer in observers]
        if problem.safeguarded:
            parts.append(Restarts())
        reductions = tuple(part for part in parts if isinstance(part, Reduction))
        records = tuple(part for part in parts if isinstance(part, Record))
        model: Any = problem if make is None else _Unmade(np.zeros_like(problem.u0), problem.safeguarded)
        in_kernels = lanes and kernel.is_chosen(np.size(problem.u0))
        return cls(model, scheme, reductions, records, lanes, bound, make, in_kernels=in_kernels)

    def with_arguments(self, arguments: Any) -> "March":
        """The march of a family in which ``make`` has these arguments, with an axis of lanes."""
        if self.make is None:
            return self
        arguments = self._across(lambda leaf: leaf)(arguments)
        return eqx.tree_at(lambda march: march.arguments, self, arguments, is_leaf=lambda x: x is None)

    def _problem(self, arguments: Any) -> Problem:
        """The problem of a lane."""
        if self.make is None:
            return self.problem
        problem = self.make(**arguments)
        return problem.with_safeguard() if self.problem.safeguarded else problem

    @property
    def _across(self) -> Callable[[Callable], Callable]:
        return together if self.in_kernels else across(np.shape(self.problem.u0))

    def _each(self, function, over_lanes=None):
        """``function(problem, ...)`` without its first argument, mapped over the lanes if there are any."""
        if not self.lanes:
            return partial(function, self.problem)
        over_lanes = over_lanes or self._across
        return partial(over_lanes(lambda arguments, *rest: function(self._problem(arguments), *rest)), self.arguments)

    def _failure(self, state, effort, step):
        """``Progress.failure`` after this step."""
        finite = jnp.all(jnp.isfinite(state.u)) & jnp.all(jnp.isfinite(state.v))
        bounded = jnp.all(jnp.abs(state.u) <= self.bound)
        kind = jnp.where(effort.converged, jnp.where(finite, 2, 1), 0)
        return jnp.where(finite & bounded & effort.converged, 0, 3 * (step + 1) + kind)

    def _sample(self, problem, initial, state, t) -> dict[str, jax.Array]:
        problem = problem.at(state).at_time(t)
        values = {n: v for record in self.records for n, v in record.sample(problem, initial, state, t).items()}
        return {name: jnp.asarray(value, float) for name, value in values.items()}

    def start(self, u0, v0, dt, room: int) -> tuple[Progress, Any, dict[str, jax.Array]]:
        """Progress at t = 0, the initial state, and the arrays for samples, with the first sample stored.

        The arrays have an additional last place, which takes all samples for which there is no room. A lane of a family
        starts from u₀ and v₀ of its problem, unless ``u0`` is NaN.
        """

        def lane_start(problem, u0, v0, dt):
            if self.make is not None:
                u0, v0 = jnp.where(jnp.isnan(u0), u0, problem.u0), jnp.asarray(problem.v0)
            state, effort = started(self.scheme, problem, u0, v0, dt)
            here = problem.at(state).at_time(0.0)
            carried = tuple(reduction.started(reduction.start(here, state), effort) for reduction in self.reductions)
            return (
                state,
                carried,
                self._failure(state, effort, jnp.zeros((), int)),
                self._sample(problem, state, state, 0.0 * dt),
            )

        # a start by components would take long to compile, and is computed only once
        state, carried, failure, first = self._each(lane_start, together)(u0, v0, dt)
        if self.lanes:
            state, carried = self._across(lambda *parts: parts)(state, carried)
        stored = {name: jnp.zeros((room + 1, *value.shape)).at[0].set(value) for name, value in first.items()}
        return Progress(jnp.zeros((), int), failure, state, carried), state, stored

    def step_of_lane(self, problem, step, failure, state, carried, dt, steps=None) -> tuple:
        """``Progress.failure``, the state and the states of the reductions of a lane after one more step."""

        def unless_ended(new, old):
            return new if steps is None or new is old else jnp.where(step < steps, new, old)

        # the time of a lane that has ended stands still, so that observers have nothing to catch up with
        number = step if steps is None else jnp.minimum(step, steps - 1)
        # the round-off of a running sum would grow with the number of steps; the round-off of a product does not
        new, effort = stepped(self.scheme, problem, state, number.astype(dt.dtype) * dt, dt)
        end = (number + 1).astype(dt.dtype) * dt
        problem = problem.at(new).at_time(end)
        updated = tuple(
            reduction.update(c, problem, new, end, effort)
            for reduction, c in zip(self.reductions, carried, strict=True)
        )
        failure_after = jnp.where(failure == 0, self._failure(new, effort, number + 1), failure)
        if self.lanes:
            # A failed lane is set to NaN, which ends Newton's iteration at once. One leaf of the state is enough: the
            # next steps spread it.
            *leaves, last = jax.tree.leaves(new)
            last = jnp.where(failure_after == 0, last, jnp.nan)
            new = jax.tree.unflatten(jax.tree.structure(new), [*leaves, last])
        return jax.tree.map(unless_ended, (failure_after, new, updated), (failure, state, carried))

    def stepped(self, progress: Progress, dt, steps=None) -> Progress:
        """Progress after one more step; with ``steps``, lanes that have taken this many steps stay as they are."""
        step, failure, state, carried = progress
        return Progress(step + 1, *self._each(self.step_of_lane)(step, failure, state, carried, dt, steps))

    def _advance(self, progress: Progress, dt, until, steps) -> Progress:
        """March to step ``until``, or until every run has failed."""
        if self.in_kernels and (advanced := self._advance_in_kernels(progress, dt, until, steps)) is not None:
            return advanced

        def step(p):
            return self.stepped(p, dt, steps)

        def goes_on(p):
            return (p.step < until) & jnp.any(p.failure == 0)

        def patiently(p):
            pause = jnp.minimum(p.step + PATIENCE, until)
            return lax.while_loop(lambda p: p.step < pause, step, p)

        return lax.while_loop(goes_on, patiently if self.lanes else step, progress)

    def _advance_in_kernels(self, progress: Progress, dt, until, steps) -> Progress | None:
        """As :meth:`_advance`, in kernels; None if they are refused."""

        def step(number, lane, inputs):
            (failure, state, carried), (dt, steps, arguments) = lane, inputs
            lane = self.step_of_lane(self._problem(arguments), number, failure, state, carried, dt, steps)
            goes_on = lane[0] == 0
            return lane, goes_on if steps is None else goes_on & (number + 1 < steps)

        begin, *lanes = progress
        inputs = jnp.broadcast_to(dt, progress.failure.shape), steps, self.arguments
        interpret = jax.default_backend() == "cpu"
        end = kernel.advanced(step, tuple(lanes), inputs, begin, until, PATIENCE, interpret)
        return None if end is None else Progress(until, *end)

    def proceed(
        self, progress: Progress, stored, initial, dt, until, every, first, each_step: bool, steps=None
    ) -> tuple[Progress, dict[str, jax.Array]]:
        """March to step ``until``, and store a sample every ``every`` steps if there are records.

        Parameters
        ----------
        progress, stored, initial
            As :meth:`start` or the previous call returned them. ``stored`` has the samples along the first axis.
        until
            Step at which to pause or end.
        every, each_step
            Number of steps between two samples. If it is one, ``each_step`` may be true: there is then no inner loop.
        first
            Number of the sample in the first place of ``stored``; samples beyond the end of ``stored`` share the last
            place.
        steps
            Last step of each lane, if the lanes do not all end at ``until``. Records are not allowed then.
        """

        def step(p):
            return self.stepped(p, dt, steps)

        each_step &= not self.in_kernels

        def stored_at(place, p, stored):
            sample = joined(self._each(self._sample)(initial, p.state, p.step.astype(dt.dtype) * dt))
            return {
                name: lax.dynamic_update_index_in_dim(stored[name], value, place, 0) for name, value in sample.items()
            }

        def next_sample(carry):
            p, stored = carry
            p = step(p) if each_step else self._advance(p, dt, jnp.minimum((p.step // every + 1) * every, until), steps)
            # until the next sample is due, its place holds the last state, so that a run can pause between two samples
            number = (p.step + every - 1) // every if not each_step else p.step
            return p, stored_at(number - first, p, stored)

        def next_step(carry):
            # like ``next_sample``, but without an inner loop
            p, stored, place, due = carry
            p = step(p)
            stored = stored_at(place, p, stored)
            is_due = p.step == due
            return p, stored, place + is_due.astype(int), due + jnp.where(is_due, every, 0)

        if not self.records:
            return self._advance(progress, dt, until, steps), stored

        def go_on(carry):
            p = carry[0]
            return (p.step < until) & jnp.any(p.failure == 0)

        if self.in_kernels or not 1 < np.size(self.problem.u0) <= SMALL:
            return lax.while_loop(go_on, next_sample, (progress, stored))
        number = progress.step // every + 1
        progress, stored, *_ = lax.while_loop(go_on, next_step, (progress, stored, number - first, number * every))
        return progress, stored

    def result(self, progress: Progress) -> tuple[jax.Array, dict[str, jax.Array]]:
        """``Progress.failure`` and the variables of the reductions after the steps so far."""

        def lane_result(problem, state, carried):
            values: dict[str, jax.Array] = {}
            for reduction, c in zip(self.reductions, carried, strict=True):
                result = reduction.result(c, problem.at(state), state)
                if unknown := result.keys() - reduction.variables.keys():
                    raise ValueError(
                        f"{type(reduction).__name__}.result returns {', '.join(sorted(unknown))}, which is none of its "
                        f"variables: {', '.join(reduction.variables)}."
                    )
                values |= result
            return values

        return progress.failure, joined(self._each(lane_result)(progress.state, progress.carried))
