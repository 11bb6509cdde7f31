"""Time marching with a controlled step size as one compiled loop, for a single run or for lanes side by side."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax

from study.algebra.counting import counting
from study.control.controllers import Controller
from study.control.estimators import Estimator
from study.marching.march import March
from study.marching.result import NO_SOLUTION, NOT_FINITE, UNBOUNDED
from study.mechanics.state import Effort
from study.scheme.contract import started

#: Status of a running march, and the two final statuses that runs with equal steps do not have.
RUNNING, STEP_TOO_SMALL, TOO_MANY_STEPS = -1, 4, 5

#: Factor of the step size after a step without convergence, or with a state or estimate that is not finite. Abaqus uses
#: the same factor.
AFTER_FAILURE = 0.25

#: Smallest step size, as a fraction of the duration.
SMALLEST_STEP = 1e-13

#: Names of the values stored for each step: the time at its end, its size, the estimate of its error, the number of
#: trial steps rejected by the estimate so far, and the number rejected so far because no finite solution was found.
STEP_VALUES = ("t", "step_size", "estimate", "rejected_by_estimate", "rejected_by_solver")

#: Name of the array that holds the values of each step.
STEP_ARRAY = "of each step"

#: Largest gap between the end of a step and a stated time, at which a step must end, as a fraction of the interval that
#: remains. The step is lengthened to close such a gap. Otherwise round-off would add a tiny step.
ROUND_OFF = 1e-9


class Trial(NamedTuple):
    """The progress of one run, between two trial steps.

    Attributes
    ----------
    status
        ``RUNNING``, or how the run ended.
    t, dt
        Time, and size of the next trial step.
    target
        Index of the next stated time, at which a step must end.
    steps, place
        Number of accepted steps, and index at which the next sample is stored.
    estimated, unsolved
        Number of trial steps rejected by the estimate, and number of trial steps rejected because no balance was found
        or a value was not finite.
    state, reduced, estimator, controller
        States of the scheme, the reductions, the estimator and the controller.
    scales
        Largest value so far of each size of the motion that the estimator measures.
    rejected
        Effort since the last accepted step, of trial steps that were rejected.
    """

    status: jax.Array
    t: jax.Array
    dt: jax.Array
    target: jax.Array
    steps: jax.Array
    place: jax.Array
    estimated: jax.Array
    unsolved: jax.Array
    state: Any
    reduced: tuple
    estimator: Any
    controller: Any
    scales: tuple
    rejected: Effort


class AdaptiveMarch(eqx.Module):
    """A march with an estimator and a controller, as pure functions of :class:`Trial`."""

    march: March
    estimator: Estimator
    controller: Controller
    #: Stated times, at which a step must end, (times,); the last one ends the run.
    times: jax.Array
    #: Largest number of accepted steps.
    most: jax.Array

    def begin(self, u0, v0, dt, tolerance, room: int) -> tuple[Trial, Any, dict[str, jax.Array]]:
        """Progress at t = 0, the initial state, and the arrays for samples, with the first sample stored.

        Parameters
        ----------
        u0, v0, dt
            Initial displacement and velocity, and size of the first step, which the controller may replace.
        room
            Number of samples for which the arrays have room; with zero no sample is stored.
        """
        march, problem = self.march, self.march.problem
        state, effort = started(march.scheme, problem, u0, v0, dt)
        here = problem.at(state).at_time(0.0)
        with counting() as control_effort:
            carried = self.controller.start(here, state, tolerance)
            dt = self.controller.first(carried, dt, tolerance)
            estimator = self.estimator.start(march.scheme, here, state)
        effort = effort.including(control_effort)
        status = jnp.where(effort.converged, jnp.where(_finite(state), RUNNING, NOT_FINITE), NO_SOLUTION)
        none = jnp.zeros((), int)
        trial = Trial(
            status,
            jnp.zeros(()),
            jnp.minimum(dt, self.times[-1]),
            none,
            none,
            none + 1,
            none,
            none,
            state,
            tuple(reduction.started(reduction.start(here, state), effort) for reduction in march.reductions),
            estimator,
            carried,
            self.estimator.sizes(here, state),
            Effort().trial_effort(),
        )
        if not room:
            return trial, state, {}
        sample = self._sample(trial, state, state, jnp.zeros(()), jnp.nan, jnp.nan)
        return trial, state, {n: jnp.zeros((room + 1, *x.shape)).at[0].set(x) for n, x in sample.items()}

    def _sample(self, trial: Trial, initial, state, t, dt, estimate) -> dict[str, jax.Array]:
        # in one array, because storing an array takes as long as a step of one unknown
        step_numbers = jnp.stack([t, dt, estimate, trial.estimated.astype(float), trial.unsolved.astype(float)])
        return {**self.march._sample(self.march.problem, initial, state, t), STEP_ARRAY: step_numbers}

    def turn(self, trial: Trial, initial, tolerance) -> tuple[Trial, dict[str, jax.Array]]:
        """Progress of the run after one trial step, and the sample of that step."""
        march, scheme = self.march, self.march.scheme
        t, end = trial.t, self.times[-1]
        way = self.times[trial.target] - t
        lands = trial.dt >= way * (1 - ROUND_OFF)
        # the last two steps before a stated time halve the interval that remains, so that neither is tiny
        halves = (trial.dt > way / 2) & (not self.controller.sizes_are_given)
        dt = jnp.where(lands, way, jnp.where(halves, way / 2, trial.dt))

        problem = march.problem.at(trial.state)
        now = jnp.where(lands, self.times[trial.target], t + dt)
        with counting() as control_effort:
            state, effort, estimates, estimator = self.estimator.step(
                scheme, problem, trial.estimator, trial.state, t, dt
            )
            here = march.problem.at(state).at_time(now)
            scales = tuple(map(jnp.maximum, trial.scales, self.estimator.sizes(here, state)))
            quotients = jnp.stack([e / jnp.where(s > 0, s, 1.0) for e, s in zip(estimates, scales, strict=True)])
            estimate = jnp.max(quotients)
            k = self.estimator.exponent(scheme)
            decision = self.controller.decide(
                trial.controller, estimate / tolerance, k, dt, here, state, now, tolerance
            )
        effort = effort.including(control_effort)
        solved = jnp.asarray(effort.converged) & _finite(state) & jnp.isfinite(estimate)
        solved &= ~jnp.asarray(self.estimator.misses(quotients))
        accepted = solved & decision.accepted
        # a step that was shortened because of a stated time does not reduce the size of the next step
        shortened = accepted & (dt < trial.dt) & (not self.controller.sizes_are_given)
        next_dt = jnp.where(shortened, jnp.maximum(decision.dt, trial.dt), decision.dt)
        next_dt = jnp.where(solved, jnp.minimum(next_dt, end), AFTER_FAILURE * dt)

        bounded = jnp.all(jnp.abs(state.u) <= march.bound)
        valid = accepted & bounded
        increment = valid.astype(int)
        steps = trial.steps + increment
        status = jnp.where(accepted & (now >= end), 0, RUNNING)
        status = jnp.where((status == RUNNING) & (steps >= self.most), TOO_MANY_STEPS, status)
        too_small = (status == RUNNING) & (next_dt < SMALLEST_STEP * end)
        status = jnp.where(too_small, jnp.where(jnp.isfinite(estimate), STEP_TOO_SMALL, NOT_FINITE), status)
        status = jnp.where(too_small & ~jnp.asarray(effort.converged), NO_SOLUTION, status)
        status = jnp.where(accepted & ~bounded, UNBOUNDED, status)

        with_rejected = effort.then(trial.rejected)._replace(converged=effort.converged)
        reduced = tuple(
            reduction.update(c, here, state, now, with_rejected)
            for reduction, c in zip(march.reductions, trial.reduced, strict=True)
        )
        rejected = trial.rejected.then(effort.trial_effort())
        old = trial.state, trial.reduced, trial.estimator, trial.controller, trial.scales, t, rejected
        new = state, reduced, estimator, decision.carried, scales, now, Effort().trial_effort()
        state_, reduced, estimator, controller, scales, t, rejected = jax.tree.map(partial(jnp.where, valid), new, old)
        return Trial(
            status,
            t,
            next_dt,
            trial.target + (valid & lands).astype(int),
            steps,
            trial.place + increment,
            trial.estimated + (solved & ~accepted).astype(int),
            trial.unsolved + (~solved).astype(int),
            state_,
            reduced,
            estimator,
            controller,
            scales,
            rejected,
        ), self._sample(trial, initial, state, now, dt, estimate)

    def result(self, trial: Trial) -> dict[str, jax.Array]:
        """Results of the reductions, by the name of the variable."""
        problem = self.march.problem.at(trial.state)
        return {
            name: value
            for reduction, c in zip(self.march.reductions, trial.reduced, strict=True)
            for name, value in reduction.result(c, problem, trial.state).items()
        }


#: Function that makes the march of a lane from the lane's arguments.
Of = Callable[[Any], AdaptiveMarch]


def proceed(
    of: Of, lanes: bool, arguments, trial: Trial, stored, initial, tolerance, room: int, turns
) -> tuple[Trial, dict[str, jax.Array]]:
    """March until every run has ended or filled its room for samples, or until ``turns`` trial steps were made.

    With ``lanes`` all arrays have an axis of lanes in front. A lane that has ended or has no room waits for the
    other lanes.
    """

    def goes_on(trial):
        return trial.status == RUNNING if not room else (trial.status == RUNNING) & (trial.place < room)

    def attempt(arguments, trial, initial, tolerance):
        new, sample = of(arguments).turn(trial, initial, tolerance)
        if lanes:
            new = jax.tree.map(partial(jnp.where, goes_on(trial)), new, trial)
        return new, {name: sample[name] for name in stored}

    def store(stored, sample, place):
        return {name: lax.dynamic_update_index_in_dim(x, sample[name], place, 0) for name, x in stored.items()}

    if lanes:
        attempt, store = jax.vmap(attempt), jax.vmap(store)

    def step(carry):
        """Make trial steps until at least one lane accepts a step or the loop ends, and store the accepted samples."""
        trial, stored, count = carry
        before = trial.place

        def again(carry):
            trial, _, count = carry
            return *attempt(arguments, trial, initial, tolerance), count + 1

        def unaccepted(carry):
            trial, _, count = carry
            return jnp.all(trial.place == before) & (count < turns) & jnp.any(goes_on(trial))

        sample = {name: jnp.zeros(x.shape[:1] * lanes + x.shape[1 + lanes :]) for name, x in stored.items()}
        # a separate loop: in a loop with large arrays XLA would run the small operations of a step on a pool of threads
        trial, sample, count = lax.while_loop(unaccepted, again, (trial, sample, count))
        # the sample of a lane that accepted no step goes to the additional place at the end, which is not read
        return trial, store(stored, sample, jnp.where(trial.place > before, before, room)), count

    carry = trial, stored, jnp.zeros((), int)
    return lax.while_loop(lambda carry: (carry[2] < turns) & jnp.any(goes_on(carry[0])), step, carry)[:2]


def _finite(state):
    return jnp.all(jnp.isfinite(state.u)) & jnp.all(jnp.isfinite(state.v))
