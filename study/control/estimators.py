"""Estimators of the error of a step.

An estimator returns one or several norms of an estimate, such as one of u and one of u̇. A run divides each norm by the
largest value so far of the corresponding norm of the motion; the largest quotient is η. An estimator also states the
power k of Δt with which the estimate falls, so that a controller can choose the next step size.
"""

import abc
from functools import partial
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax

from study.algebra.arrays import ScalarLike, Vector
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.mechanics.state import Effort
from study.scheme.base import Scheme, WrapperState
from study.scheme.contract import stepped
from study.scheme.embedded_nystrom import EmbeddedNystrom
from study.scheme.wrapper.unequal_steps import StateOfStep

#: One or several norms of an estimate or of the motion.
Sizes = tuple[jax.Array, ...]


class Estimator(eqx.Module):
    """An estimator of the error of a step; its methods are pure functions that JAX compiles into the march."""

    title: ClassVar[str]
    source: ClassVar[str]
    doi: ClassVar[str]
    #: Whether estimates are relative to sizes of the motion. If one of these sizes is zero at the start, a trial run
    #: with equal steps then measures them.
    relative: ClassVar[bool] = True

    @abc.abstractmethod
    def exponent(self, scheme: Scheme) -> int:
        """Power k of Δt with which the estimate falls."""

    def refusal(self, scheme: Scheme, problem: Problem) -> str | None:
        """Why the error of this scheme cannot be estimated, in one sentence; None if it can."""
        return None

    def sizes(self, problem: Problem, state: Any) -> Sizes:
        """One norm of the motion per estimate; the run divides the estimate by the largest value of its norm so far."""
        return (size(state.u),)

    def start(self, scheme: Scheme, problem: Problem, state: Any) -> Any:
        """State of the estimator at t = 0."""
        return ()

    def step(
        self, scheme: Scheme, problem: Problem, carried: Any, state: Any, t: ScalarLike, dt: ScalarLike
    ) -> tuple[Any, Effort, Sizes, Any]:
        """The state after a step, the effort and the estimates of this step, and the next state of the estimator."""
        new, effort = stepped(scheme, problem, state, t, dt)
        estimates, carried = self.estimate(scheme, problem, carried, state, new, t, dt, effort)
        return new, effort, estimates, carried

    def misses(self, quotients: jax.Array) -> jax.Array | bool:
        """Whether a step is no solution, from its estimates, each divided by the largest value so far of its norm."""
        return False

    def estimate(self, scheme, problem, carried, old, new, t, dt, effort) -> tuple[Sizes, Any]:
        """The estimates for a step from the state ``old`` to ``new``, and the next state of the estimator."""
        raise NotImplementedError


class Unestimated(Estimator):
    """An estimator that returns zero, for controllers that choose the steps without an estimate."""

    title = "none"
    source = ""
    doi = ""
    relative = False

    def exponent(self, scheme):
        return 1

    def sizes(self, problem, state):
        return (jnp.ones(()),)

    def estimate(self, scheme, problem, carried, old, new, t, dt, effort):
        return (jnp.zeros(()),), ()


def size(x: Vector) -> jax.Array:
    """The Euclidean norm of a vector, or the absolute value of a number."""
    return jnp.abs(x) if jnp.ndim(x) == 0 else jnp.sqrt(jnp.vdot(x, x))


class _OfAcceleration(Estimator):
    """An estimator that integrates an interpolation of the acceleration, and so needs ü at both ends of a step."""

    def exponent(self, scheme):
        return 3

    def refusal(self, scheme, problem):
        if scheme.order > 2:
            return (
                f"{self.title} estimates errors of the third order of a step, and those of '{scheme.title}' are of "
                f"order {scheme.order + 1}: take the estimator step_doubling."
            )
        if problem.massless:
            return f"{self.title} needs a mass at every unknown, and the mass of '{problem.title}' is singular."
        return None

    def start(self, scheme, problem, state):
        return acceleration(problem, 0.0, state.u, state.v)

    def ends(self, scheme, problem, before, old, new, t, dt) -> tuple[Vector, Vector, float]:
        """Accelerations ü(t + s Δt) and ü(t + Δt + s Δt) for a step that starts at ``t``, and the offset s.

        If the scheme has an ``acceleration_offset``, this is s, and the scheme carries both accelerations. Otherwise s
        is zero, ``before`` is ü at the start of the step, and the equation of motion gives ü at the end.
        """
        if scheme.acceleration_offset is not None:
            return *ends_of_step(old, new), scheme.acceleration_offset
        return before, acceleration(problem, t + dt, new.u, new.v), 0.0


def carried_acceleration(state: Any) -> Vector:
    """The ü that the state of a scheme carries."""
    return carried_acceleration(state.inner) if isinstance(state, WrapperState) else state.a


def ends_of_step(old: Any, new: Any) -> tuple[Vector, Vector]:
    """The carried accelerations ü(t₀ + s Δt) and ü(t₁ + s Δt) of a step, with the ``acceleration_offset`` s."""
    inner = new
    while isinstance(inner, WrapperState):
        if isinstance(inner, StateOfStep):
            return inner.before, inner.inner.a
        inner = inner.inner
    return carried_acceleration(old), carried_acceleration(new)


class ZienkiewiczXie(_OfAcceleration):
    r"""The displacement after a step minus the displacement of a motion with linear acceleration in the step.

    .. math::

        e = u_1 - u_0 - \Delta t\,\dot u_0 - \Delta t^2 (\tfrac13 \ddot u_0 + \tfrac16 \ddot u_1), \quad
        \eta = |e| / \max |u|

    For Newmark's method :math:`e = (\beta - \tfrac16)\,\Delta t^2 (\ddot u_1 - \ddot u_0)`. An α-method carries the
    acceleration of the time :math:`t_1 + s\,\Delta t` with s = α_m − α_f, which adds
    :math:`\tfrac{s}{2} \Delta t^2 (\ddot u_1 - \ddot u_0)` to e. The estimate vanishes where the third derivative of u
    is zero, as at every turning point of a free undamped vibration. The estimate ignores the error of the velocity.

    References
    ----------
    O. C. Zienkiewicz, Y. M. Xie, A simple error estimator and adaptive time stepping procedure for dynamic analysis,
    Earthquake Eng. Struct. Dyn. 20(9), 1991, 871-887.
    """

    title = "Zienkiewicz-Xie"
    source = "Zienkiewicz and Xie (1991)"
    doi = "10.1002/eqe.4290200907"

    def refusal(self, scheme, problem):
        if getattr(scheme, "beta", None) == 1 / 6 and scheme.acceleration_offset == 0:
            return (
                f"{self.title} measures the distance from a motion with linear acceleration, which '{scheme.title}' "
                "assumes itself: take the estimator three_point."
            )
        return super().refusal(scheme, problem)

    def estimate(self, scheme, problem, carried, old, new, t, dt, effort):
        before, after, offset = self.ends(scheme, problem, carried, old, new, t, dt)
        change = after - before
        e = new.u - old.u - dt * old.v - dt**2 * (before / 2 + (1 / 6 - offset / 2) * change)
        return (size(e),), after


class ThreePoint(_OfAcceleration):
    r"""The motion after a step minus a motion whose acceleration is the parabola through ü at three times.

    The parabola passes through ü at both ends of this step and at the start of the previous step, and is integrated
    over this step. The estimate is the larger of the errors of u and u̇, each relative to the largest :math:`|u|` or
    :math:`|\dot u|` so far. For Newmark's method with equal steps, the error of u is
    :math:`\Delta t^2 [(\beta - \tfrac18) \ddot u_1 + (\tfrac1{12} - \beta) \ddot u_0 + \tfrac1{24} \ddot u_{-1}]`.
    The estimate of the error of u̇ is centred half a step too early. Both estimates are wrong after a kink of the force.

    References
    ----------
    L. F. Zeng, N.-E. Wiberg, X. D. Li, Y. M. Xie, A posteriori local error estimation and adaptive time-stepping for
    Newmark integration in dynamic analysis, Earthquake Eng. Struct. Dyn. 21(7), 1992, 555-571.
    N.-E. Wiberg, X. D. Li, A post-processing technique and an a posteriori error estimate for the Newmark method in
    dynamic analysis, Earthquake Eng. Struct. Dyn. 22(6), 1993, 465-489.
    """

    title = "Three points"
    source = "Zeng et al. (1992)"
    doi = "10.1002/eqe.4290210701"

    def sizes(self, problem, state):
        return size(state.u), size(state.v)

    def start(self, scheme, problem, state):
        now = super().start(scheme, problem, state)
        # a slope of zero means that there is no earlier step: the first step uses a straight line, not a parabola
        return now, jnp.zeros_like(now), jnp.ones(())

    def estimate(self, scheme, problem, carried, old, new, t, dt, effort):
        a0, slope_before, dt_before = carried
        before, after, offset = self.ends(scheme, problem, a0, old, new, t, dt)
        # Newton's form of the parabola through the accelerations, at the times to which they belong
        start, end = offset * dt, (1 + offset) * dt
        slope = (after - before) / dt
        bend = jnp.where(slope_before == 0, 0.0, (slope - slope_before) / (dt + dt_before))
        slope_once, slope_twice = dt**2 / 2 - start * dt, dt**3 / 6 - start * dt**2 / 2
        bend_once = dt**3 / 3 - (start + end) * dt**2 / 2 + start * end * dt
        bend_twice = dt**4 / 12 - (start + end) * dt**3 / 6 + start * end * dt**2 / 2
        e_v = new.v - old.v - (dt * before + slope_once * slope + bend_once * bend)
        e_u = new.u - old.u - dt * old.v - (dt**2 / 2 * before + slope_twice * slope + bend_twice * bend)
        return (size(e_u), size(e_v)), (after, slope, dt)


class StepDoubling(Estimator):
    r"""The difference between one step and two half steps, for any one-step scheme.

    .. math::

        \eta = \frac{|y_{2 \times \Delta t/2} - y_{\Delta t}|}{(2^p - 1) \max |y|} \quad\text{for } y = u, \dot u

    where p is the order of the scheme with damping or load. The run continues from the two half steps. A trial step
    evaluates three times the forces of a step.

    References
    ----------
    E. Hairer, S. P. Nørsett, G. Wanner, Solving ordinary differential equations I, 2nd ed., Springer, 1993, section
    II.4.
    """

    title = "Step doubling"
    source = "Hairer et al. (1993)"
    doi = "10.1007/978-3-540-78862-1"

    def exponent(self, scheme):
        return scheme.order_with_damping + 1

    def sizes(self, problem, state):
        return size(state.u), size(state.v)

    def step(self, scheme, problem, carried, state, t, dt):
        def take(start, i):
            begin, length = jnp.where(i == 2, t + dt / 2, t), jnp.where(i == 0, dt, dt / 2)
            new, effort = stepped(scheme, problem, start, begin, length)
            return jax.tree.map(partial(jnp.where, i == 0), state, new), (new.u, new.v, effort)

        # a loop over the whole step and both halves; without a loop, XLA would compute some of their work twice
        fine, (u, v, efforts) = lax.scan(take, state, jnp.arange(3))
        effort = jax.tree.map(jnp.sum, efforts)._replace(converged=efforts.converged.all())
        factor = 2**scheme.order_with_damping - 1
        return fine, effort, (size(u[2] - u[0]) / factor, size(v[2] - v[0]) / factor), carried


class EmbeddedPair(Estimator):
    r"""The difference from an embedded method of lower order, which uses the same forces.

    .. math::

        \eta = |\hat y_1 - y_1| / \max |y| \quad\text{for } y = u, \dot u

    with :math:`\hat y_1` of the method of lower order, whose error is the estimate. The run continues with the method
    of higher order. The estimate takes no additional forces.

    References
    ----------
    J. R. Dormand, P. J. Prince, Runge-Kutta-Nyström triples, Comput. Math. Appl. 13(12), 1987, 937-949.
    """

    title = "Embedded pair"
    source = "Dormand and Prince (1987)"
    doi = "10.1016/0898-1221(87)90066-8"

    def exponent(self, scheme):
        return scheme.embedded_order + 1

    def refusal(self, scheme, problem):
        if not isinstance(scheme, EmbeddedNystrom) or problem.history is not None:
            return (
                f"{self.title} needs a scheme with an embedded one, such as dormand_prince6, and a force without "
                f"history: take the estimator step_doubling for '{scheme.title}' on '{problem.title}'."
            )
        return None

    def sizes(self, problem, state):
        return size(state.u), size(state.v)

    def step(self, scheme, problem, carried, state, t, dt):
        new, difference = scheme.pair(problem, state, t, dt)
        new = new._replace(u=state.u + new.u, v=state.v + new.v)
        return new, Effort(), (size(difference.u), size(difference.v)), carried
