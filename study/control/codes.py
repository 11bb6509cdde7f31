"""Estimators and controllers of finite element codes: Abaqus, Nastran, OpenSees."""

import math

import jax.numpy as jnp

from study.algebra.matrices import times
from study.control.controllers import SMALLEST, TINY, Controller, Decision
from study.control.estimators import Estimator, carried_acceleration, ends_of_step
from study.mechanics.balance import acceleration, load
from study.scheme.base import check_ranges


class HalfStepResidual(Estimator):
    r"""The force that is not balanced in the middle of the step.

    .. math::

        \ddot u_h &= (\ddot u_0 + \ddot u_1)/2, \quad
        u_h = u_0 + \tfrac{\Delta t}{2} \dot u_0 + \tfrac{\Delta t^2}{16} (\ddot u_0 + \ddot u_h) \\
        \eta &= \max |M \ddot u_h + C \dot u_h + p(u_h) - f(t_h)| / \max |M \ddot u|

    with u̇_h = u̇₀ + Δt (ü₀ + ü_h)/4. An α-method carries the accelerations at s Δt after both ends of the step, with
    s = α_m − α_f. Therefore s (ü₁ − ü₀) is first subtracted from both accelerations. If no force of the scheme is
    evaluated at the end of the step, ü₀ and ü₁ follow from the equation of motion instead, unless it is linear or an
    unknown has no mass. The estimate takes one additional force per step, or two. It is of second order in Δt, and the
    error of the step is of third order.

    References
    ----------
    H. D. Hibbitt, B. I. Karlsson, Analysis of pipe whip, EPRI Report NP-1208, Electric Power Research Institute, 1979.
    """

    title = "Half-step residual"
    source = "Hibbitt and Karlsson (1979)"
    doi = ""

    def exponent(self, scheme):
        return 2

    def refusal(self, scheme, problem):
        if scheme.acceleration_offset is None:
            return f"{self.title} needs a scheme that carries the acceleration, which '{scheme.title}' does not."
        return None

    def sizes(self, problem, state):
        return (jnp.max(jnp.abs(problem.momentum(carried_acceleration(state)))),)

    def start(self, scheme, problem, state):
        carries = scheme.force_at_end or problem.linear or problem.massless
        return () if carries else acceleration(problem, 0.0, state.u, state.v)

    def estimate(self, scheme, problem, carried, old, new, t, dt, effort):
        if isinstance(carried, tuple):
            before, after = ends_of_step(old, new)
            shift = scheme.acceleration_offset * (after - before)
            before, after = before - shift, after - shift
        else:
            before = carried
            carried = after = acceleration(problem, t + dt, new.u, new.v)
        half, a = dt / 2, (before + after) / 2
        u = old.u + half * old.v + half**2 / 4 * (before + a)
        v = old.v + half / 2 * (before + a)
        missing = problem.momentum(a) + problem.at_time(t + half).internal_force(u, v) - load(problem, t + half)
        if problem.damping is not None:
            missing = missing + times(problem.damping, v)
        return (jnp.max(jnp.abs(missing)),), carried


class ApparentFrequency(Estimator):
    r"""The step size as a fraction of the apparent period of the motion.

    .. math::

        \omega^2 = \frac{\Delta u^T \Delta p}{\Delta u^T M \Delta u}, \quad \eta = \frac{\omega\,\Delta t}{2 \pi}

    with the changes Δu and Δp of displacement and internal force over the step. A tolerance of 0.05 aims at twenty
    steps per period. This estimator does not estimate an error, and takes one additional force per step.

    References
    ----------
    P. G. Bergan, E. Mollestad, An automatic time-stepping algorithm for dynamic problems, Comput. Methods Appl. Mech.
    Eng. 49(3), 1985, 299-318.
    """

    title = "Apparent frequency"
    source = "Bergan and Mollestad (1985)"
    doi = "10.1016/0045-7825(85)90127-8"
    relative = False

    def exponent(self, scheme):
        return 1

    def sizes(self, problem, state):
        return (jnp.ones(()),)

    def start(self, scheme, problem, state):
        return problem.at_time(0.0).internal_force(state.u, state.v)

    def estimate(self, scheme, problem, carried, old, new, t, dt, effort):
        force, way = problem.at_time(t + dt).internal_force(new.u, new.v), new.u - old.u
        work, inertia = jnp.vdot(way, force - carried), jnp.vdot(way, problem.momentum(way))
        omega = jnp.sqrt(jnp.where(inertia > 0, jnp.maximum(work, 0.0) / inertia, 0.0))
        return (omega * dt / (2 * math.pi),), force


class Iterations(Estimator):
    r"""The number of Newton iterations of the step: a tolerance of 6 aims at six iterations.

    This estimator measures the work of the solver, not an error. A linear structure needs few iterations for any step
    size, so the step size grows as far as the controller allows.

    References
    ----------
    F. T. McKenna, Object-oriented finite element programming: frameworks for analysis, algorithms and parallel
    computing, Thesis, University of California, Berkeley, 1997.
    """

    title = "Newton iterations"
    source = "McKenna (1997)"
    doi = ""
    relative = False

    def exponent(self, scheme):
        return 1

    def refusal(self, scheme, problem):
        if scheme.explicit:
            return f"'{scheme.title}' takes no Newton iterations, by which {self.title} chooses the step."
        return None

    def sizes(self, problem, state):
        return (jnp.ones(()),)

    def estimate(self, scheme, problem, carried, old, new, t, dt, effort):
        return (jnp.asarray(effort.iterations, float),), ()


class HalfIncrement(Controller):
    r"""The controller of Abaqus: a step is repeated with :math:`0.85\,\Delta t/r` if r > 1.

    The step size shrinks by at most a factor of five. It grows by a factor of 1.25 after three consecutive steps with
    r ≤ 0.85.

    References
    ----------
    H. D. Hibbitt, B. I. Karlsson, Analysis of pipe whip, EPRI Report NP-1208, Electric Power Research Institute, 1979.
    """

    title = "Half-increment"
    source = "Hibbitt and Karlsson (1979)"
    doi = ""

    def start(self, problem, state, tolerance):
        return jnp.zeros((), int)

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        good = jnp.where(r <= 0.85, carried + 1, 0)
        grows = good >= 3
        factor = jnp.where(r > 1, jnp.maximum(0.85 / r, SMALLEST), jnp.where(grows, 1.25, 1.0))
        return Decision(r <= 1, dt * factor, jnp.where(grows, 0, good))


class Nastran(Controller):
    r"""The controller of TSTEPNL for the apparent frequency: the step size changes by powers of two.

    The frequency allows 1/r times the present step size. The step size is multiplied by ¼ if 1/r < R/2, otherwise by ½
    if 1/r < R, by 1 if 1/r < 2, by 2 if 1/r < 3/R, and by 4 otherwise. A step is repeated only if no finite solution
    was found.

    Parameters
    ----------
    bound
        The bound R, 0 < R ≤ 1.
    """

    bound: float = 0.75

    title = "Powers of two"
    source = "MSC Nastran"
    doi = ""

    def __check_init__(self):
        check_ranges(self, bound=(0.0, 1.0))

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        allowed = 1 / jnp.maximum(r, TINY)
        limits = jnp.array([self.bound / 2, self.bound, 2.0, 3 / self.bound])
        factor = jnp.array([0.25, 0.5, 1.0, 2.0, 4.0])[jnp.searchsorted(limits, allowed, side="right")]
        return Decision(True, dt * factor, ())


class Proportional(Controller):
    r"""The controller of OpenSees, :math:`\Delta t' = \Delta t/r` within limits.

    A step is repeated only if no finite solution was found.

    Parameters
    ----------
    smallest, largest
        Limits of the step size in s.

    References
    ----------
    F. T. McKenna, Object-oriented finite element programming: frameworks for analysis, algorithms and parallel
    computing, Thesis, University of California, Berkeley, 1997.
    """

    smallest: float = 0.0
    largest: float = float("inf")

    title = "Proportional"
    source = "McKenna (1997)"
    doi = ""

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        return Decision(True, jnp.clip(dt / jnp.maximum(r, TINY), self.smallest, self.largest), ())
