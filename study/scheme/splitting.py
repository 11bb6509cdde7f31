"""Splitting methods, with kicks and drifts: symplectic Euler, McLachlan's method, compositions of velocity Verlet."""

from collections.abc import Sequence
from itertools import accumulate
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp

from study.algebra.arrays import VectorLike
from study.algebra.scalars import is_whole
from study.mechanics.balance import acceleration_within
from study.mechanics.state import Effort, Motion, Phase
from study.scheme.base import OneStep, as_tuple, check_numbers


def check_weights(scheme: str, name: str, weights: Sequence[float]) -> None:
    """Refuse weights that are not numbers, or do not add up to one."""
    check_numbers(scheme, name, weights)
    if abs(sum(weights) - 1) > 1e-12:
        raise ValueError(f"{scheme}({name}={weights}): {name} must be numbers that add up to one.")


def check_order(scheme: str, order: int) -> None:
    """Refuse an order that is not a whole number of at least one."""
    if not is_whole(order, 1):
        raise ValueError(
            f"{scheme}(order_without_damping={order!r}): order_without_damping must be a whole number of at least 1."
        )


class Alternating(OneStep):
    """Kicks and drifts in turn. The weights of each add up to one. With damping, the order is at most two."""

    kicks: eqx.AbstractVar[tuple[float, ...]]
    drifts: eqx.AbstractVar[tuple[float, ...]]
    order_without_damping: eqx.AbstractVar[int]

    family: ClassVar[str] = "Splitting"
    explicit = True
    keeps_energy = True

    def __check_init__(self):
        name = type(self).__name__
        check_weights(name, "drifts", self.drifts)
        check_weights(name, "kicks", self.kicks)
        check_order(name, self.order_without_damping)

    @property
    def order(self) -> int:
        return self.order_without_damping

    @property
    def order_with_damping(self) -> int:
        return min(self.order_without_damping, 2)


class Splitting(Alternating):
    r"""Drifts d₀, ..., d_s and kicks k₁, ..., k_s in turn.

    .. math::

        u &\leftarrow u + d_0 \Delta t\,\dot u, \quad\text{then for } i = 1, \dots, s \\
        M a + C (\dot u + \tfrac12 k_i \Delta t\,a) + p(u) &= f(t_i) \\
        \dot u &\leftarrow \dot u + k_i \Delta t\,a, \quad u \leftarrow u + d_i \Delta t\,\dot u

    at the time t_i = t₀ + (d₀ + ... + d_{i−1}) Δt. Symplectic without damping. d = (0, 1), k = (1) is the symplectic
    Euler method, of first order and stable for ωΔt ≤ 2. McLachlan's method of order four has five kicks and is stable
    for ωΔt ≤ 2.922. It is derived for ü that does not depend on u̇, and is of second order with damping. Carries u and
    u̇; s forces per step. The history of a force is committed at u₁; the forces of all kicks in a step start from the
    history at u₀.

    Parameters
    ----------
    drifts, kicks
        d and k; each sums to one, and d has one more number than k.
    order_without_damping
        Order of accuracy without damping.
    stability_limit
        Largest ωΔt at which the method is stable without damping, if known.

    Raises
    ------
    ValueError
        If the drifts or the kicks do not add up to one, if there is not one drift more than kicks, or if the order is
        invalid.

    References
    ----------
    R. I. McLachlan, On the numerical integration of ordinary differential equations by symmetric composition methods,
    SIAM J. Sci. Comput. 16(1), 1995, 151-168.
    E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, section VI.3.
    R. de Vogelaere, Methods of integration which preserve the contact transformation property of the Hamiltonian
    equations, Report 4, Department of Mathematics, University of Notre Dame, 1956.
    A. Cromer, Stable solutions using the Euler approximation, Am. J. Phys. 49(5), 1981, 455-459.
    """

    drifts: tuple[float, ...] = eqx.field(static=True, converter=as_tuple)
    kicks: tuple[float, ...] = eqx.field(static=True, converter=as_tuple)
    order_without_damping: int = eqx.field(static=True)
    stability_limit: float | None = eqx.field(default=None, static=True)
    title: str = eqx.field(default="Splitting", static=True)
    source: str = eqx.field(default="Hairer et al. (2006)", static=True)
    doi: str = eqx.field(default="10.1007/3-540-30666-8", static=True)

    def __check_init__(self):
        if len(self.drifts) != len(self.kicks) + 1:
            raise ValueError(
                f"Splitting needs one drift more than kicks, not {len(self.drifts)} for {len(self.kicks)}."
            )

    def start(self, problem, u0, v0, dt):
        return Phase(u0, v0), Effort()

    def increment(self, problem, state, t, dt):
        u, v = state
        first, *rest = self.drifts
        du: VectorLike = first * dt * v
        dv: VectorLike = 0.0
        effort = Effort()
        for part, kick, drift in zip(accumulate(self.drifts), self.kicks, rest, strict=False):
            h = kick * dt
            a, kicked = acceleration_within(problem, t + part * dt, u + du, v + dv, h / 2, guess=jnp.zeros_like(v))
            dv, effort = dv + h * a, effort.then(kicked)
            du = du + drift * dt * (v + dv)
        return Phase(du, dv), effort


class Composition(OneStep):
    r"""Velocity Verlet steps of lengths w₁Δt, w₂Δt, ..., w_sΔt; a step with w_i < 0 goes backwards.

    With h = w_iΔt for i = 1, ..., s:

    .. math::

        \dot u &\leftarrow \dot u + \tfrac12 h \ddot u, \quad u \leftarrow u + h \dot u \\
        M \ddot u + C (\dot u + \tfrac12 h \ddot u) + p(u) &= f(t) \\
        \dot u &\leftarrow \dot u + \tfrac12 h \ddot u

    w = (1) is velocity Verlet itself, which is central difference. Velocity Verlet is symmetric, so weights that cancel
    its errors of third, fifth and seventh order make methods of order 4, 6 and 8, with damping and load too: order 4
    (Yoshida, three steps, stable for ωΔt ≤ 1.573), order 6 (Yoshida, seven steps, stable for ωΔt ≤ 2.269) and order 8
    (Kahan and Li, seventeen steps, stable for ωΔt ≤ 3.096, and again from π to 5.634). Symplectic without damping.
    Carries u, u̇ and ü; s forces per step. The history of a force is committed at u₁; all Verlet steps of a step start
    from the history at u₀.

    Parameters
    ----------
    weights
        w, symmetric and with the sum one.
    order_without_damping
        Order of accuracy.
    stability_limit
        Largest ωΔt at which the method is stable without damping, if known.

    Raises
    ------
    ValueError
        If the weights do not add up to one or are not symmetric, or the order is invalid.

    References
    ----------
    H. Yoshida, Construction of higher order symplectic integrators, Phys. Lett. A 150(5-7), 1990, 262-268.
    W. Kahan, R.-C. Li, Composition constants for raising the orders of unconventional schemes for ordinary differential
    equations, Math. Comput. 66(219), 1997, 1089-1099.
    L. Verlet, Computer "experiments" on classical fluids. I. Thermodynamical properties of Lennard-Jones molecules,
    Phys. Rev. 159(1), 1967, 98-103.
    """

    weights: tuple[float, ...] = eqx.field(static=True, converter=as_tuple)
    order_without_damping: int = eqx.field(static=True)
    stability_limit: float | None = eqx.field(default=None, static=True)
    title: str = eqx.field(default="Composition", static=True)
    source: str = eqx.field(default="Yoshida (1990)", static=True)
    doi: str = eqx.field(default="10.1016/0375-9601(90)90092-3", static=True)

    family: ClassVar[str] = "Splitting"
    explicit = True
    keeps_energy = True
    force_at_end = True

    def __check_init__(self):
        check_weights("Composition", "weights", self.weights)
        check_order("Composition", self.order_without_damping)
        if self.weights != self.weights[::-1]:
            raise ValueError(f"Composition(weights={self.weights}): weights must be the same from both ends.")

    @property
    def order(self) -> int:
        return self.order_without_damping

    def increment(self, problem, state, t, dt):
        u, v, a = state
        du: VectorLike = 0.0
        dv: VectorLike = 0.0
        effort = Effort()
        for part, weight in zip(accumulate(self.weights), self.weights, strict=True):
            h = weight * dt
            dv = dv + h / 2 * a
            du = du + h * (v + dv)
            a, kicked = acceleration_within(problem, t + part * dt, u + du, v + dv, h / 2, guess=a)
            dv, effort = dv + h / 2 * a, effort.then(kicked)
        return Motion(du, dv, a), effort


def mirrored(*half: float) -> tuple[float, ...]:
    """Symmetric weights from their first half; an additional weight in the middle makes the sum one."""
    return *half, 1 - 2 * sum(half), *half[::-1]


_mclachlan = {"source": "McLachlan (1995)", "doi": "10.1137/0916010"}
_outer, _inner = 0.40518861839525227722, -0.28714404081652408900
symplectic_euler = Splitting(
    drifts=(0.0, 1.0),
    kicks=(1.0,),
    order_without_damping=1,
    stability_limit=2.0,
    title="Symplectic Euler",
    source="de Vogelaere (1956)",
    doi="",
)
mclachlan4 = Splitting(
    drifts=(_outer, _inner, *(0.5 - _outer - _inner,) * 2, _inner, _outer),
    kicks=mirrored(-3 / 73, 17 / 59),
    order_without_damping=4,
    stability_limit=2.9218392,
    title="McLachlan, order 4",
    **_mclachlan,
)


yoshida4 = Composition(
    weights=mirrored(1 / (2 - 2 ** (1 / 3))),
    order_without_damping=4,
    stability_limit=1.5734019,
    title="Yoshida, order 4",
)
yoshida6 = Composition(
    weights=mirrored(0.78451361047755726382, 0.23557321335935813368, -1.17767998417887100695),
    order_without_damping=6,
    stability_limit=2.2690580,
    title="Yoshida, order 6",
)


kahan_li8 = Composition(
    weights=mirrored(
        0.13020248308889008088,
        0.56116298177510838456,
        -0.38947496264484728641,
        0.15884190655515560090,
        -0.39590389413323757734,
        0.18453964097831570709,
        0.25837438768632204729,
        0.29501172360931029887,
    ),
    order_without_damping=8,
    stability_limit=3.0964387,
    title="Kahan-Li, order 8",
    source="Kahan and Li (1997)",
    doi="10.1090/S0025-5718-97-00873-9",
)
