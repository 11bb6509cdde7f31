r"""Controllers of the step size.

A controller takes :math:`r = \eta/\text{tolerance}`, the estimated error of a step relative to the tolerance, and the
power k of Δt with which the estimate falls. It accepts or rejects the step, and chooses the size of the next step.
"""

import abc
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import Scalar, ScalarLike, VectorLike, as_float64
from study.keywords import KeywordsOnly
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.scheme.base import check_ranges

#: Smallest and largest ratio of successive step sizes, where a controller limits it, and the safety factor. This factor
#: multiplies the step size that the estimate allows.
SMALLEST, LARGEST, SAFETY = 0.2, 5.0, 0.9

#: Smallest ratio r with which a controller computes, so that the next step stays finite if the estimate is zero.
TINY = 1e-10


class Decision(NamedTuple):
    """Whether a step is accepted, the size ``dt`` of the next step, and the next state of the controller."""

    accepted: jax.Array | bool
    dt: Scalar
    carried: Any


class Controller(eqx.Module):
    """A controller of the step size; its methods are pure functions that JAX compiles into the march."""

    title: ClassVar[str]
    source: ClassVar[str]
    doi: ClassVar[str]
    #: Whether a run needs a tolerance.
    needs_tolerance: ClassVar[bool] = True
    #: Whether the sizes are given. A step is then shortened only to end at a stated time.
    sizes_are_given: ClassVar[bool] = False

    def start(self, problem: Problem, state: Any, tolerance: ScalarLike) -> Any:
        """State of the controller at t = 0."""
        return ()

    def first(self, carried: Any, dt: Scalar, tolerance: ScalarLike) -> Scalar:
        """Size of the first step. The default is ``dt``: the given size, or else a small part of the duration."""
        return dt

    @abc.abstractmethod
    def decide(self, carried, r, k: int, dt, problem: Problem, state, t, tolerance) -> Decision:
        """The decision on a step of size ``dt`` that ended in ``state`` at time ``t``."""


def _limited(factor):
    return jnp.clip(factor, SMALLEST, LARGEST)


class Integral(Controller):
    r"""The elementary controller, :math:`\Delta t' = 0.9\,\Delta t\,r^{-1/k}`.

    A step is accepted if r ≤ 1. The step size grows or shrinks by at most a factor of five.

    References
    ----------
    E. Hairer, S. P. Nørsett, G. Wanner, Solving ordinary differential equations I, 2nd ed., Springer, 1993, section
    II.4.
    """

    title = "Integral"
    source = "Hairer et al. (1993)"
    doi = "10.1007/978-3-540-78862-1"

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        return Decision(r <= 1, dt * _limited(SAFETY * jnp.maximum(r, TINY) ** (-1 / k)), ())


class ProportionalIntegral(Controller):
    r"""The PI controller, :math:`\Delta t' = 0.9\,\Delta t\,r^{-0.7/k} r_0^{0.4/k}` with r₀ of the last accepted step.

    A step with r > 1 is repeated with :math:`\Delta t' = 0.9\,\Delta t\,r^{-1/k}`. The step size grows or shrinks by at
    most a factor of five.

    References
    ----------
    K. Gustafsson, Control theoretic techniques for stepsize selection in explicit Runge-Kutta methods, ACM Trans.
    Math. Softw. 17(4), 1991, 533-554.
    """

    title = "PI"
    source = "Gustafsson (1991)"
    doi = "10.1145/210232.210242"

    def start(self, problem, state, tolerance):
        return jnp.ones(())

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        r = jnp.maximum(r, TINY)
        smooth = SAFETY * r ** (-0.7 / k) * carried ** (0.4 / k)
        again = SAFETY * r ** (-1 / k)
        return Decision(r <= 1, dt * _limited(jnp.where(r <= 1, smooth, again)), jnp.where(r <= 1, r, carried))


class Filtered(Controller):
    r"""The digital filter H211b with b = 4, whose step sizes vary smoothly.

    .. math::

        c = r^{-1/(4k)}\,r_0^{-1/(4k)}\,(\Delta t/\Delta t_0)^{-1/4}, \quad
        \Delta t' = \Delta t\,[1 + \arctan(c - 1)]

    with r₀ and Δt₀ of the last accepted step. A step is accepted if :math:`r^{-1/k} \ge 0.9`; otherwise it is repeated
    with :math:`c = 0.9\,r^{-1/k}`.

    References
    ----------
    G. Söderlind, Digital filters in adaptive time-stepping, ACM Trans. Math. Softw. 29(1), 2003, 1-26.
    G. Söderlind, L. Wang, Adaptive time-stepping and computational stability, J. Comput. Appl. Math. 185(2), 2006,
    225-243.
    """

    title = "H211b"
    source = "Söderlind (2003)"
    doi = "10.1145/641876.641877"

    def start(self, problem, state, tolerance):
        return jnp.ones(()), jnp.zeros(())

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        r0, dt0 = carried
        r = jnp.maximum(r, TINY)
        ratio = jnp.where(dt0 > 0, dt / jnp.where(dt0 > 0, dt0, 1.0), 1.0)
        accepted = r ** (-1 / k) >= SAFETY
        c = jnp.where(accepted, (r * r0) ** (-1 / (4 * k)) * ratio ** (-1 / 4), SAFETY * r ** (-1 / k))
        keep = (jnp.where(accepted, r, r0), jnp.where(accepted, dt, dt0))
        return Decision(accepted, dt * (1 + jnp.arctan(c - 1)), keep)


class DeadBand(KeywordsOnly, Controller):
    r"""The controller of Zienkiewicz and Xie: the step size stays the same while r stays within bounds.

    A step with r > ``high`` is repeated with :math:`\Delta t' = 0.9\,\Delta t\,r^{-1/k}`, and at most 0.9 Δt. After
    ``patience`` consecutive steps with r < ``low``, the step size is multiplied by the same factor
    :math:`0.9\,r^{-1/k}`, at most five. The number 0.9 is our addition: without it, a step just above the bound is
    repeated without end.

    Parameters
    ----------
    low, high
        0 ≤ low ≤ high: bounds of r.
    patience
        Number of consecutive steps with r < ``low`` before the step size changes.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    O. C. Zienkiewicz, Y. M. Xie, A simple error estimator and adaptive time stepping procedure for dynamic analysis,
    Earthquake Eng. Struct. Dyn. 20(9), 1991, 871-887.
    """

    low: float = 0.1
    high: float = 1.0
    patience: int = eqx.field(default=1, static=True)

    title = "Dead band"
    source = "Zienkiewicz and Xie (1991)"
    doi = "10.1002/eqe.4290200907"

    def __check_init__(self):
        check_ranges(self, low=(0.0, float(self.high)), high=(0.0, float("inf")), patience=(1, float("inf")))

    def start(self, problem, state, tolerance):
        return jnp.zeros((), int)

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        accepted = r <= self.high
        small = jnp.where(r < self.low, carried + 1, 0)
        changes = ~accepted | (small >= self.patience)
        factor = jnp.where(changes, _limited(SAFETY * jnp.maximum(r, TINY) ** (-1 / k)), 1.0)
        factor = jnp.where(accepted, factor, jnp.minimum(factor, SAFETY))
        return Decision(accepted, dt * factor, jnp.where(changes, 0, small))


class Reversible(Controller):
    r"""Reversible control of Hairer and Söderlind: the step size follows a density ρ of steps, not an error.

    .. math::

        \rho_{1/2} = \rho(y_0) + \tfrac12 \varepsilon G(y_0), \quad
        \rho_{n+1/2} = \rho_{n-1/2} + \varepsilon G(y_n), \quad \Delta t_n = \varepsilon/\rho_{n+1/2},
        \quad G = \frac{1}{\rho} \frac{d\rho}{dt}

    with the derivative dρ/dt along the motion, and the tolerance ε. Symmetric schemes on reversible problems then show
    no drift of energy. The controller evaluates one additional force per step.

    Parameters
    ----------
    density
        ρ(u, u̇), a positive number in 1/s, the same for u̇ and −u̇, written with ``jax.numpy``.

    References
    ----------
    E. Hairer, G. Söderlind, Explicit, time reversible, adaptive step size control, SIAM J. Sci. Comput. 26(6), 2005,
    1838-1851.
    """

    density: Callable[[VectorLike, VectorLike], Scalar]

    title = "Reversible"
    source = "Hairer and Söderlind (2005)"
    doi = "10.1137/040606995"

    def _growth(self, problem, state, t):
        a = acceleration(problem, t, state.u, state.v)
        return jax.jvp(lambda u, v: jnp.log(self.density(u, v)), (state.u, state.v), (state.v, a))[1]

    def start(self, problem, state, tolerance):
        return self.density(state.u, state.v) + tolerance / 2 * self._growth(problem, state, 0.0)

    def first(self, carried, dt, tolerance):
        return tolerance / carried

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        density = carried + tolerance * self._growth(problem, state, t)
        return Decision(True, tolerance / density, density)


class Prescribed(Controller):
    """Steps of given sizes in turn, whatever the error; after the last size the first one follows again.

    A step is shortened only to end at a time at which a step must end.

    Parameters
    ----------
    sizes
        Step sizes in s.
    """

    #: Step sizes, as an array, so that arrays of one length share the compiled program.
    sizes: np.ndarray = eqx.field(converter=as_float64)

    title = "Prescribed"
    source = ""
    doi = ""
    needs_tolerance = False
    sizes_are_given = True

    def __check_init__(self):
        if self.sizes.ndim != 1 or not self.sizes.size or not np.all((self.sizes > 0) & np.isfinite(self.sizes)):
            raise ValueError(f"Prescribed needs step sizes greater than zero, not {self.sizes}.")

    def start(self, problem, state, tolerance):
        return jnp.zeros((), int)

    def first(self, carried, dt, tolerance):
        return jnp.asarray(self.sizes[0])

    def decide(self, carried, r, k, dt, problem, state, t, tolerance):
        number = (carried + 1) % len(self.sizes)
        return Decision(True, jnp.asarray(self.sizes)[number], number)
