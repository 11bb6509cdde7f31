"""Embedded Runge-Kutta-Nyström methods: Dormand and Prince's pair of order six and four."""

from typing import ClassVar, NamedTuple

import equinox as eqx
import numpy as np

from study.algebra.arrays import ScalarLike
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.mechanics.state import Effort, Motion, Phase
from study.scheme.base import OneStep


class Tableau(NamedTuple):
    """Weights of an explicit Runge-Kutta-Nyström pair whose last stage is the first stage of the next step.

    ``c`` (s,) holds the times of the stages. Row i of ``a`` holds the weights of the stages before stage i. The last
    row of ``a``, ``b`` (s − 1,), holds the weights of the displacement, and ``b_velocity`` (s,) the weights of the
    velocity. ``b_hat`` (s,) and ``b_hat_velocity`` (s,) are the weights of the embedded method.
    """

    c: tuple[float, ...]
    a: tuple[tuple[float, ...], ...]
    b_velocity: tuple[float, ...]
    b_hat: tuple[float, ...]
    b_hat_velocity: tuple[float, ...]

    @property
    def b(self) -> tuple[float, ...]:
        """Weights of the displacement."""
        return self.a[-1]

    @property
    def a_velocity(self) -> np.ndarray:
        """Weights (s, s) of the velocities of the stages; they integrate the polynomial through all earlier stages."""
        weights = np.zeros((len(self.c), len(self.c)))
        for i, end in enumerate(self.c):
            powers = np.arange(i)
            vandermonde = np.vander(self.c[:i], increasing=True).T
            weights[i, :i] = np.linalg.solve(vandermonde, end ** (powers + 1) / (powers + 1))
        return weights


class EmbeddedNystrom(OneStep):
    r"""An explicit Runge-Kutta-Nyström method with an embedded method of lower order from the same forces.

    For the stages i = 1, ..., s, where k of the first stage is known from the step before,

    .. math::

        u_i &= u_0 + c_i \Delta t\,\dot u_0 + \Delta t^2 \sum_{j<i} a_{ij} k_j, \quad
            v_i = \dot u_0 + \Delta t \sum_{j<i} \bar a_{ij} k_j \\
        M k_i + C v_i + p(u_i) &= f(t_0 + c_i \Delta t) \\
        u_1 &= u_0 + \Delta t\,\dot u_0 + \Delta t^2 \sum_j b_j k_j, \quad
            \dot u_1 = \dot u_0 + \Delta t \sum_j b'_j k_j

    The weights :math:`\hat b` and :math:`\hat b'` of ``tableau`` in place of b and b′ give the embedded method. The
    difference between the two methods estimates the error of a step. The pair of Dormand and Prince has the orders six
    and four. Without damping it is unstable at every step size, but the relative growth of the motion is only
    :math:`4 \cdot 10^{-6} (\omega\Delta t)^8` per step. The published pair is for ü that does not depend on u̇, and has
    no v_i. Here the weights ā integrate the polynomial through the previous k, and the order is three with damping.
    Carries u, u̇ and ü; s − 1 forces per step, five for this pair. The history of a force is committed at u₁; all stages
    start from the history at u₀.

    Parameters
    ----------
    tableau
        c, a, b′, b̂ and b̂′; the last row of a is b.
    order_without_damping
        Order of accuracy without damping.
    with_damping
        Order of accuracy with damping.
    embedded_order
        Order of accuracy of the embedded method, without damping.
    stability_limit
        Largest ωΔt at which the method is stable without damping, if known.

    References
    ----------
    J. R. Dormand, P. J. Prince, Runge-Kutta-Nyström triples, Comput. Math. Appl. 13(12), 1987, 937-949.
    """

    tableau: Tableau = eqx.field(static=True)
    order_without_damping: int = eqx.field(static=True)
    with_damping: int = eqx.field(static=True)
    embedded_order: int = eqx.field(static=True)
    stability_limit: float | None = eqx.field(default=None, static=True)
    title: str = eqx.field(default="Embedded Nyström", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Dormand and Prince (1987)"
    doi: ClassVar[str] = "10.1016/0898-1221(87)90066-8"
    explicit = True
    acceleration_offset = 0.0
    force_at_end = True

    @property
    def order(self) -> int:
        return self.order_without_damping

    @property
    def order_with_damping(self) -> int:
        return self.with_damping

    def increment(self, problem, state, t, dt):
        return self.pair(problem, state, t, dt)[0], Effort()

    def pair(self, problem: Problem, state: Motion, t: ScalarLike, dt: ScalarLike) -> tuple[Motion, Phase]:
        """State at t + Δt with increments in place of u and u̇, and the differences between both methods' increments."""
        u, v, a = state
        stages = [a]
        tableau = self.tableau
        for c, row, velocity_row in zip(tableau.c[1:], tableau.a[1:], tableau.a_velocity[1:].tolist(), strict=True):
            velocity = v + dt * _weighted(velocity_row, stages) if problem.damped else v
            stages.append(acceleration(problem, t + c * dt, u + c * dt * v + dt**2 * _weighted(row, stages), velocity))
        du, dv = dt**2 * _weighted(tableau.b, stages), dt * _weighted(tableau.b_velocity, stages)
        du_hat, dv_hat = dt**2 * _weighted(tableau.b_hat, stages), dt * _weighted(tableau.b_hat_velocity, stages)
        return Motion(dt * v + du, dv, stages[-1]), Phase(du - du_hat, dv - dv_hat)


def _weighted(weights, stages):
    """Weighted sum of the stages, without stages of weight zero."""
    return sum(w * k for w, k in zip(weights, stages, strict=False) if w)


_root = 8581**0.5
_b = (
    329 / 4212,
    0.0,
    (84119543 + 366727 * _root) / 409622616,
    (84119543 - 366727 * _root) / 409622616,
    200 / 17901,
)
_PAIR = Tableau(
    c=(0.0, (209 - _root) / 900, (209 - _root) / 450, (209 + _root) / 450, 9 / 10, 1.0),
    a=(
        (),
        ((26131 - 209 * _root) / 810000,),
        ((26131 - 209 * _root) / 607500, (26131 - 209 * _root) / 303750),
        (
            (980403512254 + 7781688431 * _root) / 11694469921875,
            -(1262884486208 + 15385481287 * _root) / 11694469921875,
            (7166233891441 + 78694563299 * _root) / 46777879687500,
        ),
        (
            -9 * (329260 + 3181 * _root) / 27040000,
            27 * (35129 + 3331 * _root) / 13520000,
            -27 * (554358343 + 31040327 * _root) / 464060480000,
            153 * (8555257 - 67973 * _root) / 2745920000,
        ),
        _b,
    ),
    b_velocity=(
        329 / 4212,
        0.0,
        (389225579 + 96856 * _root) / 1024056540,
        (389225579 - 96856 * _root) / 1024056540,
        2000 / 17901,
        1 / 20,
    ),
    b_hat=((2701 + 23 * _root) / 4563, -(9829 + 131 * _root) / 9126, 5 * (1798 + 17 * _root) / 9126, 0.0, 0.0, 0.0),
    b_hat_velocity=(
        115 / 2106,
        0.0,
        (84119543 + 366727 * _root) / 256014135,
        (84119543 - 366727 * _root) / 256014135,
        6950 / 17901,
        -1 / 10,
    ),
)
dormand_prince6 = EmbeddedNystrom(
    tableau=_PAIR,
    order_without_damping=6,
    with_damping=3,
    embedded_order=4,
    stability_limit=0.0,
    title="Dormand-Prince, order 6",
)
