"""Scalar auxiliary variable: BDF2 with an explicit non-linear force, and an energy that does not grow."""

import math
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax.numpy as jnp

from study.algebra.arrays import Matrix, Scalar, Vector
from study.algebra.counting import count
from study.algebra.elimination import solve
from study.algebra.matrices import add, product, times
from study.mechanics.balance import load
from study.mechanics.definition import Problem
from study.mechanics.state import Effort
from study.scheme.base import Scheme, check_ranges
from study.scheme.newmark import average_acceleration


class Auxiliary(NamedTuple):
    """Displacement and velocity, each of shape () or (n,), and the number r, at tₙ and at tₙ₋₁."""

    u: Vector
    v: Vector
    r: Scalar
    u_1: Vector
    v_1: Vector
    r_1: Scalar


class AuxiliaryVariable(Scheme):
    r"""BDF2 with an auxiliary variable r in place of :math:`\sqrt{V(u) + c}`: no iteration, and no stability limit.

    With the extrapolated :math:`\bar u = 2u_0 - u_{-1}` and :math:`q = \sqrt{V(\bar u) + c}`,

    .. math::

        \Delta t\,\dot y_1 &= \tfrac32 y_1 - 2 y_0 + \tfrac12 y_{-1} \quad\text{for } y = u \text{ and } y = \dot u \\
        M \ddot u_1 + C \dot u_1 + K u_1 + \frac{r_1}{q}\,p(\bar u) &= f(t_1) \\
        3 r_1 - 4 r_0 + r_{-1} &= \frac{p(\bar u)}{2q} \cdot (3 u_1 - 4 u_0 + u_{-1})

    where K is a constant stiffness in addition to the force p, and V the potential of p. The equations are linear, and
    are solved with one matrix for two right sides. Second order. Without load the quadratic form of BDF2 in u̇, u and r,
    which represents the energy :math:`\tfrac12 \dot u^T M \dot u + \tfrac12 u^T K u + r^2`, does not grow at any step
    size; r itself may drift from :math:`\sqrt{V + c}`. Without p it is BDF2. The average acceleration method, run
    backwards, finds the motion before the start. Needs the potential V. Carries u, u̇ and r at two times; one force and
    one potential per step, which count as two forces.

    Parameters
    ----------
    shift
        c ≥ 0, so large that V + c is positive.

    Raises
    ------
    ValueError
        If c is out of its range.

    References
    ----------
    J. Shen, J. Xu, J. Yang, The scalar auxiliary variable (SAV) approach for gradient flows, J. Comput. Phys. 353,
    2018, 407-416.
    """

    shift: float = 1.0
    title: str = eqx.field(default="SAV-BDF2", static=True)

    family: ClassVar[str] = "Auxiliary variable"
    source: ClassVar[str] = "Shen et al. (2018)"
    doi: ClassVar[str] = "10.1016/j.jcp.2017.10.021"
    order = 2
    explicit = True
    stability_limit = math.inf

    def __check_init__(self):
        check_ranges(self, shift=(0.0, math.inf))

    def refusal(self, problem):
        if problem.potential is None or problem.dissipative:
            return f"'{self.title}' needs a force of '{problem.title}' that is the gradient of a potential."
        return super().refusal(problem)

    def _root(self, problem: Problem, u: Vector) -> Scalar:
        """The square root of V + c, where V is the potential of p, which counts as a force."""
        count(forces=1)
        return jnp.sqrt(problem.potential(u) + self.shift)  # type: ignore[misc]

    def start(self, problem, u0, v0, dt):
        state, effort = average_acceleration.start(problem, u0, v0, dt)
        previous, more = average_acceleration.step(problem, state, 0.0, -dt)
        roots = self._root(problem, u0), self._root(problem, previous.u)
        return Auxiliary(u0, v0, roots[0], previous.u, previous.v, roots[1]), effort.then(more)

    def step(self, problem, state, t, dt) -> tuple[Auxiliary, Effort]:
        h = 2 * dt / 3
        u, v, r = ((4 * value - previous) / 3 for value, previous in zip(state[:3], state[3:], strict=True))
        extrapolated = 2 * state.u - state.u_1
        q = self._root(problem, extrapolated)
        slope = problem.varying_force(extrapolated, v) / q if not problem.linear else jnp.zeros_like(u)

        # u₁ = u + h v + h² a, u̇₁ = v + h a and r₁ = r + slopeᵀ (h v + h² a)/2
        effective = _effective(problem, u, h)
        residual = load(problem, t + dt) - (r + h * jnp.vdot(slope, v) / 2) * slope
        if problem.damping is not None:
            residual = residual - times(problem.damping, v)
        if problem.stiffness is not None:
            residual = residual - times(problem.stiffness, u + h * v)
        a, slope_response = solve(effective, residual), solve(effective, slope)
        a = a - h**2 * jnp.vdot(slope, a) / (2 + h**2 * jnp.vdot(slope, slope_response)) * slope_response
        du = h * v + h**2 * a
        return Auxiliary(u + du, v + h * a, r + jnp.vdot(slope, du) / 2, *state[:3]), Effort()


def _effective(problem: Problem, u: Vector, h) -> Matrix:
    """The matrix M + h C + h² K."""
    terms = [1.0 if problem.mass is None else problem.mass]
    terms += [product(h, problem.damping, u.size)] if problem.damping is not None else []
    terms += [product(h**2, problem.stiffness, u.size)] if problem.stiffness is not None else []
    return add(*terms, n=u.size)
