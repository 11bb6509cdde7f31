"""The force at the end of a step, which some schemes do not evaluate, in the estimate of the error of the step."""

from typing import Any

import jax
import jax.numpy as jnp

from study.algebra.arrays import ScalarLike, Vector
from study.algebra.elimination import solve
from study.algebra.matrices import times
from study.control.estimators import Estimator
from study.mechanics.balance import load
from study.mechanics.definition import Problem

#: Part of a step by which the load is evaluated within the step, because it may jump at a time at which steps end.
WITHIN = 1e-9

#: Round-off of a displacement, as a multiple of the precision, that is taken off the defect of a step.
ROUND_OFF = 8

#: Largest η of an accepted step, whatever the tolerance.
FAR = 1.0


class WithEnd(Estimator):
    r"""Another estimate, and in addition the work of the force at the end of a step that the step does not foretell.

    A scheme that balances the forces within a step, such as generalized-α or Gauss' method, may end a step deep in a
    contact that no force of the step has met. With the force :math:`g = f - C \dot u - p` at both ends of the step,

    .. math::

        d &= u_1 - u_0 - \tfrac{\Delta t}{2} (\dot u_0 + \dot u_1), \quad
        r = g_1 - g_0 + \tfrac{12}{\Delta t^2} M d, \quad
        \theta = \min(1, |r| / \max(|g_0|, |g_1|)) \\
        e &= |M (\dot u_1 - \dot u_0) - \tfrac{\Delta t}{2} (g_0 + g_1)| + \kappa\,\tfrac{\Delta t}{2} |r|, \quad
        \eta = \frac{|u_1 - u_0|^T M^{-1} (\theta^2 e)}{\Delta t \max (\dot u^T \dot u)}

    where θ is taken for each unknown. The force r is the difference between g₁ and M ü of the polynomial of fourth
    degree through u, u̇ and ü at the start and u and u̇ at the end. The factor κ is one for a force whose slope may
    jump, and otherwise zero: without it, e is zero for average acceleration, whose trapezoidal rule errs by up to
    Δt/2 r where a step enters or leaves a contact. Where a motion is smooth, θ is at most of the order of Δt for
    schemes of second order and of Δt² for schemes of fourth order, and η is below the error of the step. If an unknown
    has no mass, M⁻¹ is left out, and the kinetic energy takes the place of u̇ᵀu̇. One additional force per step.

    A step with η above ``FAR`` counts as a step without a solution, because some controllers accept every estimate.
    """

    estimator: Estimator

    source = ""
    doi = ""

    @property
    def title(self) -> str:  # type: ignore[override]
        """Title of the other estimator."""
        return self.estimator.title

    @property
    def relative(self) -> bool:  # type: ignore[override]
        """True, because η is relative to the largest velocity."""
        return True

    def exponent(self, scheme):
        return self.estimator.exponent(scheme)

    def refusal(self, scheme, problem):
        return self.estimator.refusal(scheme, problem)

    def sizes(self, problem, state):
        momentum = problem.momentum(state.v) if problem.massless else state.v
        return *self.estimator.sizes(problem, state), jnp.vdot(state.v, momentum)

    def start(self, scheme, problem, state):
        return self.estimator.start(scheme, problem, state), _resistance(problem.at_time(0.0), state)

    def step(self, scheme, problem, carried, state, t, dt):
        estimator_state, before = carried
        new, effort, estimates, estimator_state = self.estimator.step(scheme, problem, estimator_state, state, t, dt)
        after = _resistance(problem.at(new).at_time(t + dt), new)
        forces = load(problem, t + WITHIN * dt) - before, load(problem, t + (1 - WITHIN) * dt) - after
        return new, effort, (*estimates, _unforeseen(problem, state, new, *forces, dt)), (estimator_state, after)

    def misses(self, quotients):
        return quotients[-1] > FAR


def _resistance(problem: Problem, state: Any) -> Vector:
    """C u̇ + p at a state."""
    force = problem.internal_force(state.u, state.v)
    return force if problem.damping is None else force + times(problem.damping, state.v)


def _unforeseen(problem: Problem, old: Any, new: Any, before: Vector, after: Vector, dt: ScalarLike) -> jax.Array:
    """The numerator of η over Δt, from the forces g₀ and g₁."""
    way = new.u - old.u
    defect = way - dt / 2 * (old.v + new.v)
    round_off = ROUND_OFF * jnp.finfo(way.dtype).eps * (jnp.abs(old.u) + jnp.abs(new.u))
    defect = jnp.sign(defect) * jnp.maximum(jnp.abs(defect) - round_off, 0.0)
    rest = after - before + 12 / dt**2 * problem.momentum(defect)
    largest = jnp.maximum(jnp.abs(before), jnp.abs(after))
    part = jnp.minimum(1.0, jnp.abs(rest) / jnp.where(largest > 0, largest, 1.0))
    missing = jnp.abs(problem.momentum(new.v - old.v) - dt / 2 * (before + after))
    if problem.kinked:
        missing += dt / 2 * jnp.abs(rest)
    missing = part**2 * missing
    if not (problem.massless or problem.mass is None):
        missing = solve(problem.mass, missing)
    return jnp.sum(jnp.abs(way * missing)) / dt
