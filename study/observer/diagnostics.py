"""Diagnostics of a run: Newton iterations, the Lyapunov exponent, and errors of momentum."""

import jax.numpy as jnp

from study.mechanics.definition import Problem
from study.observer.base import Reduction


class NewtonIterations(Reduction):
    """Number of Newton iterations of a run, and the largest number in one step."""

    variables = {
        "newton_iterations": {"long_name": "Newton iterations in all steps", "units": "1"},
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
    }

    def start(self, problem, state):
        return jnp.zeros((), int), jnp.zeros((), int)

    def update(self, carried, problem, state, t, effort):
        total, most = carried
        return total + effort.iterations, jnp.maximum(most, effort.iterations)

    def result(self, carried, problem, state):
        return dict(zip(self.variables, carried, strict=True))


class Restarts(Reduction):
    """Number of times that Newton's iteration failed and was started again with a safeguard, over the run."""

    variables = {"newton_restarts": {"long_name": "Newton iterations started again with a safeguard", "units": "1"}}

    def start(self, problem, state):
        return jnp.zeros((), int)

    def update(self, carried, problem, state, t, effort):
        # the next steps of a failed lane are NaN, and their iterations fail too
        return carried + jnp.where(jnp.isfinite(state.u).all(), effort.restarts, 0)

    def result(self, carried, problem, state):
        return {"newton_restarts": carried}


class Evaluations(Reduction):
    """Numbers of forces, tangents and factorisations of a run, with its start.

    Every evaluation of p(u, ...) that the scheme makes is counted: in Newton's iterations, when a correction is
    shortened, and when a history is committed. K u of a linear problem counts as a force, and so does a potential that
    takes the place of a force. Where a force is evaluated together with its tangent, both are counted. The model of the
    structure at rest, which some explicit schemes use in every step, is not counted.

    A factorisation is a linear system with a new matrix: one per Newton iteration. A matrix that depends on the step
    size alone is new when the step size changes, and counts unless it is diagonal or matrix-free. A linear problem
    takes one such matrix for each balance of a step.

    With controlled steps, the trial steps that were rejected and the estimates are counted too. The forces of a trial
    run that measures the sizes of the motion stand apart, in ``trial_run_force_evaluations``. A run that starts again
    with a safeguard is counted alone.
    """

    variables = {
        "force_evaluations": {"long_name": "internal forces evaluated", "units": "1"},
        "tangent_evaluations": {"long_name": "tangents of the internal force evaluated", "units": "1"},
        "factorisations": {"long_name": "linear systems with a new matrix", "units": "1"},
    }

    def start(self, problem, state):
        return (jnp.zeros((), int),) * 3, (jnp.zeros(()), jnp.zeros(()))

    def started(self, carried, effort):
        counts = effort.forces, effort.tangents, effort.factorisations + effort.fixed_factorisations
        return tuple(map(jnp.add, carried[0], counts)), carried[1]

    def update(self, carried, problem, state, t, effort):
        (forces, tangents, factorisations), (before, dt_before) = carried
        dt = t - before
        # the difference of two times has their round-off
        is_new = jnp.abs(dt - dt_before) > 8 * jnp.finfo(dt.dtype).eps * t
        factorisations += effort.factorisations + jnp.where(is_new, effort.fixed_factorisations, 0)
        return (forces + effort.forces, tangents + effort.tangents, factorisations), (t, dt)

    def result(self, carried, problem, state):
        return dict(zip(self.variables, carried[0], strict=True))


#: log₂ of the growth that lifts round-off to the size of the motion.
APART = 33


class LyapunovExponent(Reduction):
    r"""Largest Lyapunov exponent of the numerical map, and the time from which on neighbouring motions are far apart.

    The exponent is :math:`\lambda = \ln|\delta(t)|/t`, where δ is the distance in displacement and velocity that
    :class:`study.scheme.wrapper.linearised.Linearised` carries. At the start, the displacement in δ has length one. For
    regular motions λ is of the order of ln t/t. Motions are far apart once a component of δ has grown to 2³³ = 8.6e9.
    """

    variables = {
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"},
        "apart_from": {"long_name": "time from which on a perturbation is 8.6e9 times as large", "units": "s"},
    }
    needs_equal_steps = True
    needs_neighbour = True

    def start(self, problem, state):
        return jnp.zeros(()), jnp.full((), jnp.inf)

    def update(self, carried, problem, state, t, effort):
        _, first = carried
        return t, jnp.where(state.exponent >= APART, jnp.minimum(first, t), jnp.inf)

    def result(self, carried, problem, state):
        t, first = carried
        size = jnp.sqrt(jnp.sum(state.distance.u**2 + state.distance.v**2))
        growth = jnp.log(size) + jnp.log(2.0) * state.exponent.astype(size.dtype)
        return {"lyapunov_exponent": growth / t, "apart_from": first}


def _momenta(problem: Problem, state):
    """Linear and angular momentum of every point, of shape (points, directions) and (points, 3)."""
    points, directions = jnp.shape(problem.positions)
    p = problem.momentum(state.v).reshape(points, directions)
    x = problem.positions + state.u.reshape(points, directions)
    in_space = [(0, 0), (0, 3 - directions)]
    return p, jnp.cross(jnp.pad(x, in_space), jnp.pad(p, in_space))


class MomentumErrors(Reduction):
    """Largest change of the total linear momentum and of the total angular momentum, both relative.

    Each change is divided by the sum of the sizes of the momenta of all points, at the time when this sum is largest.
    The quotient is NaN if no point has momentum at any time.
    """

    variables = {
        "max_linear_momentum_error": {"long_name": "largest change of linear momentum, relative", "units": "1"},
        "max_angular_momentum_error": {"long_name": "largest change of angular momentum, relative", "units": "1"},
    }
    needs_positions = True

    def start(self, problem, state):
        momenta = _momenta(problem, state)
        return [m.sum(axis=0) for m in momenta], jnp.zeros(2), jnp.stack([_sizes(m) for m in momenta])

    def update(self, carried, problem, state, t, effort):
        at_start, errors, scales = carried
        momenta = _momenta(problem, state)
        changes = [jnp.linalg.norm(m.sum(axis=0) - before) for m, before in zip(momenta, at_start, strict=True)]
        return (
            at_start,
            jnp.maximum(errors, jnp.stack(changes)),
            jnp.maximum(scales, jnp.stack([_sizes(m) for m in momenta])),
        )

    def result(self, carried, problem, state):
        _, errors, scales = carried
        return dict(zip(self.variables, errors / scales, strict=True))


def _sizes(momenta):
    """Sum of the sizes of the momenta (points, ...) over all points."""
    return jnp.linalg.norm(momenta, axis=1).sum()
