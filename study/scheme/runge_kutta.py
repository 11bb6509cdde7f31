"""Runge-Kutta methods: the classical one, Nyström's, and the two-stage Gauss method."""

import math
from collections.abc import Callable
from functools import partial
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import Matrix, ScalarLike, Vector
from study.algebra.matrices import Banded, MatrixFree, product
from study.mechanics.balance import acceleration, balance, initial_acceleration
from study.mechanics.definition import Problem
from study.mechanics.sparse_tangent import SparseTangent
from study.mechanics.state import Effort, Phase
from study.mechanics.tangent import FormOfTangent
from study.scheme.base import OneStep


class RungeKutta4(OneStep):
    r"""The classical fourth order Runge-Kutta method, Xie (1996), eqs (13) to (16).

    .. math::

        y &= (u, v), \quad F(t, y) = (v, M^{-1} (f(t) - C v - p(u))) \\
        y_1 &= y_0 + k_1/6 + k_2/3 + k_3/3 + k_4/6 \\
        k_1 &= \Delta t\,F(t_0, y_0), \quad k_2 = \Delta t\,F(t_0 + \tfrac12 \Delta t, y_0 + \tfrac12 k_1) \\
        k_3 &= \Delta t\,F(t_0 + \tfrac12 \Delta t, y_0 + \tfrac12 k_2), \quad k_4 = \Delta t\,F(t_1, y_0 + k_3)

    Fourth order; stable without damping for ωΔt ≤ 2√2. Carries u and u̇; four forces per step. The history of a force is
    committed at u₁; all stages start from the history at u₀.

    References
    ----------
    W. Kutta, Beitrag zur näherungsweisen Integration totaler Differentialgleichungen, Z. Math. Phys. 46, 1901, 435-453.
    """

    title: str = eqx.field(default="Runge-Kutta", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Kutta (1901)"
    doi: ClassVar[str] = ""
    order = 4
    explicit = True
    force_at_end = True
    stability_limit = 2 * math.sqrt(2)

    def start(self, problem, u0, v0, dt):
        return Phase(u0, v0), Effort()

    def increment(self, problem, state, t, dt):
        def k(c, du, dv):
            u, v = state.u + du, state.v + dv
            return dt * v, dt * acceleration(problem, t + c * dt, u, v)

        u1, v1 = k(0.0, 0.0, 0.0)
        u2, v2 = k(0.5, u1 / 2, v1 / 2)
        u3, v3 = k(0.5, u2 / 2, v2 / 2)
        u4, v4 = k(1.0, u3, v3)
        return Phase((u1 + u4) / 6 + (u2 + u3) / 3, (v1 + v4) / 6 + (v2 + v3) / 3), Effort()


class Nystrom4(OneStep):
    r"""Nyström's method of fourth order for ü = F(t, u, u̇) = M⁻¹ (f − C u̇ − p(u)).

    .. math::

        k_1 &= F(t_0, u_0, \dot u_0), \quad u_h = u_0 + \tfrac12 \Delta t\,\dot u_0 + \tfrac18 \Delta t^2 k_1 \\
        k_2 &= F(t_0 + \tfrac12 \Delta t, u_h, \dot u_0 + \tfrac12 \Delta t\,k_1) \\
        k_3 &= F(t_0 + \tfrac12 \Delta t, u_h, \dot u_0 + \tfrac12 \Delta t\,k_2) \\
        k_4 &= F(t_1, u_0 + \Delta t\,\dot u_0 + \tfrac12 \Delta t^2 k_3, \dot u_0 + \Delta t\,k_3) \\
        u_1 &= u_0 + \Delta t\,\dot u_0 + \tfrac16 \Delta t^2 (k_1 + k_2 + k_3) \\
        \dot u_1 &= \dot u_0 + \tfrac16 \Delta t\,(k_1 + 2 k_2 + 2 k_3 + k_4)

    Fourth order; stable without damping for ωΔt ≤ 2.586, which is :math:`\sqrt{8 + 2^{7/3} - 2^{8/3}}`. Carries u and
    u̇; three forces per step, because k₂ and k₃ take the force at the same displacement. Without damping k₃ = k₂. The
    history of a force is committed at u₁; all stages start from the history at u₀.

    References
    ----------
    E. J. Nyström, Über die numerische Integration von Differentialgleichungen, Acta Soc. Sci. Fenn. 50(13), 1925, 1-54.
    """

    title: str = eqx.field(default="Nyström", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Nyström (1925)"
    doi: ClassVar[str] = ""
    order = 4
    explicit = True
    force_at_end = True
    stability_limit = math.sqrt(8 + 2 ** (7 / 3) - 2 ** (8 / 3))

    def start(self, problem, u0, v0, dt):
        return Phase(u0, v0), Effort()

    def increment(self, problem, state, t, dt):
        u, v = state
        half = dt / 2
        k1 = acceleration(problem, t, u, v)
        u_half = u + half * v + half**2 / 2 * k1
        k2 = acceleration(problem, t + half, u_half, v + half * k1)
        k3 = k2 if not problem.damped else acceleration(problem, t + half, u_half, v + half * k2)
        k4 = acceleration(problem, t + dt, u + dt * v + dt * half * k3, v + dt * k3)
        return Phase(dt * v + dt**2 / 6 * (k1 + k2 + k3), dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)), Effort()


class Stages(NamedTuple):
    """Displacement and velocity, each of shape () or (n,), and accelerations (2, ...) of the last step's two stages."""

    u: Vector
    v: Vector
    a: jax.Array


class _Twice(NamedTuple):
    """Two stages of a problem as one system of twice as many unknowns; the stages of an unknown are neighbours."""

    internal_force: Callable
    varying_force: Callable
    linear: bool
    takes_velocity: bool
    kinked: bool
    safeguarded: bool
    stiffness: Matrix
    mass: Matrix
    massless: bool
    damping: Matrix
    tangent: FormOfTangent


def _twice(problem: Problem, times: tuple[ScalarLike, ScalarLike], u) -> _Twice:
    """The stages at the two times."""
    first, second = map(problem.at_time, times)

    def interleaved(first_force, second_force, u_stages, v_stages):
        (first_u, second_u), (first_v, second_v) = (x.reshape(*u.shape, 2).T for x in (u_stages, v_stages))
        return jnp.stack([first_force(first_u, first_v), second_force(second_u, second_v)]).T.ravel()

    def doubled(matrix):
        if matrix is None or (isinstance(matrix, np.ndarray | jax.Array) and matrix.ndim == 0):
            return matrix
        if isinstance(matrix, Banded):
            bands = jnp.repeat(jnp.stack(tuple(matrix.bands)), 2, axis=1)
            return Banded(jnp.zeros((2 * len(bands) - 1, 2 * u.size)).at[::2].set(bands))
        if isinstance(matrix, MatrixFree):
            twice = jax.vmap(matrix.product, in_axes=1, out_axes=1)
            return MatrixFree(
                lambda x: twice(x.reshape(-1, 2)).ravel(), jnp.repeat(jnp.broadcast_to(matrix.diagonal, u.shape), 2)
            )
        return jnp.repeat(matrix, 2) if jnp.ndim(matrix) == 1 else jnp.kron(matrix, jnp.eye(2))

    structure = 2 * problem.tangent if isinstance(problem.tangent, int) else "dense" if u.ndim == 0 else problem.tangent
    return _Twice(
        partial(interleaved, first.internal_force, second.internal_force),
        partial(interleaved, first.varying_force, second.varying_force),
        problem.linear,
        problem.takes_velocity,
        problem.kinked,
        problem.safeguarded,
        doubled(problem.stiffness),
        doubled(problem.mass),
        problem.massless,
        doubled(problem.damping),
        structure,
    )


def _stage_matrix(weights: np.ndarray, problem: Problem, size: int) -> Matrix:
    """The weights (2, 2) for every unknown, as a matrix (2n, 2n): full if the tangent is full, otherwise a band."""
    if problem.tangent in (None, "dense"):
        return np.kron(np.eye(size), weights)
    (first, high), (low, second) = weights
    return Banded(np.tile([[0.0, low], [first, second], [high, 0.0]], size))


#: Weights A (2, 2) of the two-stage Gauss method.
_GAUSS = np.array([[1 / 4, 1 / 4 - np.sqrt(3) / 6], [1 / 4 + np.sqrt(3) / 6, 1 / 4]])

#: Times c of the two stages.
_GAUSS_TIMES = _GAUSS.sum(axis=1)


class Gauss4(OneStep):
    r"""The Gauss method of two stages, for the equation of motion in its second-order form.

    .. math::

        M \ddot u_i + C \dot u_i + p(u_i) &= f(t_0 + c_i \Delta t), \quad c_i = \tfrac12 \mp \tfrac16 \sqrt 3 \\
        \dot u_i &= \dot u_0 + \Delta t \sum_j A_{ij} \ddot u_j \\
        u_i &= u_0 + c_i \Delta t\,\dot u_0 + \Delta t^2 \sum_j (A^2)_{ij} \ddot u_j \\
        \dot u(t_1) &= \dot u_0 + \tfrac12 \Delta t\,(\ddot u_1 + \ddot u_2) \\
        u(t_1) &= u_0 + \Delta t\,\dot u_0 + \tfrac12 \Delta t^2 \sum_i (1 - c_i)\,\ddot u_i

    Fourth order and symplectic; unconditionally stable for linear systems, without numerical damping. Both stages are
    solved together. Carries u, u̇ and both stage accelerations, which are the guess for the next step; two forces per
    Newton iteration, and one solution for 2n unknowns. The history of a force is committed at u₁; all stages start from
    the history at u₀.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, section II.1.
    P. C. Hammer, J. W. Hollingsworth, Trapezoidal methods of approximating solutions of differential equations, Math.
    Tables Aids Comput. 9, 1955, 92-96.
    J. C. Butcher, Implicit Runge-Kutta processes, Math. Comput. 18(85), 1964, 50-64.
    """

    title: str = eqx.field(default="Gauss, order 4", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Hammer and Hollingsworth (1955)"
    doi: ClassVar[str] = ""
    order = 4
    explicit = False
    stability_limit = math.inf
    keeps_energy = True

    def refusal(self, problem):
        if isinstance(problem.tangent, SparseTangent):
            return (
                f"'{self.title}' solves for two stages together, which is not supported for the sparse matrices of "
                f"'{problem.title}': take a scheme that solves for one acceleration, such as a composite one."
            )
        return super().refusal(problem)

    def start(self, problem, u0, v0, dt):
        a0 = initial_acceleration(problem, u0, v0)
        return Stages(u0, v0, jnp.stack([a0, a0])), Effort()

    def increment(self, problem, state, t, dt):
        u, v, guess = state

        def side_by_side(first, second):
            return jnp.stack([first, second], axis=-1).ravel()

        first, second = _GAUSS_TIMES.tolist()
        times = t + first * dt, t + second * dt
        stages, rhs = _twice(problem, times, u), 0.0
        if problem.load is not None:
            rhs = side_by_side(*map(problem.load, times))
        u_stages, v_stages = side_by_side(u + first * dt * v, u + second * dt * v), side_by_side(v, v)
        c_u, c_v = (
            product(power, _stage_matrix(weights, problem, u.size), 2 * u.size)
            for power, weights in ((dt**2, _GAUSS @ _GAUSS), (dt, _GAUSS))
        )
        a, effort = balance(stages, rhs, u_stages, v_stages, c_u, c_v, side_by_side(*guess), symmetric=False)
        first, second = a = a.reshape(*u.shape, 2).T
        before, after = ((1 - _GAUSS_TIMES) / 2).tolist()
        return Stages(dt * v + dt**2 * (before * first + after * second), dt / 2 * (first + second), a), effort


rk4 = RungeKutta4()
nystrom4 = Nystrom4()
gauss4 = Gauss4()
