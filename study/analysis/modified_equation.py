"""The equation of motion that a scheme of second order solves up to terms of Δt⁴, for one unknown."""

import math
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Float

from study.algebra.jit import jit
from study.mechanics.definition import Problem
from study.scheme.base import Scheme
from study.scheme.conserving import ImplicitMidpoint
from study.scheme.newmark import Newmark

#: Values along the first period.
_Along = Float[np.ndarray, "steps"]
#: Least number of steps of the reference in a period, and in a period of the highest frequency.
STEPS, STEPS_OF_HIGHEST = 1024, 64


class ModifiedEnergy(NamedTuple):
    r"""Coefficients of the energy that a scheme conserves up to terms of Δt⁴.

    .. math::

        E + \Delta t^2 g, \quad g = a\, \dot u^T p' \dot u + b\, \ddot u^T M \ddot u

    The period is that of the energy :math:`E + \Delta t^2 g(0)` minus :math:`c \Delta t^2` times the derivative of
    :math:`S = \oint \ddot u^T M \ddot u\, dt` with respect to E.
    """

    velocity_coefficient: float
    acceleration_coefficient: float
    period_coefficient: float

    @property
    def convex(self) -> float:
        """Largest error of the energy, over its height above rest and (ωΔt)², of any motion with 0 ≤ p′ ≤ ω² M."""
        ends = self.velocity_coefficient * 2, self.acceleration_coefficient * 2
        return max(*ends, 0.0) - min(*ends, 0.0)


class ModifiedEquation(NamedTuple):
    r"""Coefficients of the modified equation of a scheme.

    .. math::

        \dot u = v - \Delta t^2 a M^{-1} p' v, \quad
        M \dot v = -p + \Delta t^2 (b\, p' M^{-1} p + c\, p'' v^2), \quad
        v(0) = \dot u_0 + \Delta t^2 d M^{-1} p'(u_0)\, \dot u_0

    Attributes
    ----------
    rate, restoring, curving, start
        The coefficients a, b, c and d.
    next_term
        Coefficient of (ωΔt)⁴ in the relative error of the frequency of a linear oscillator.
    energy
        The energy that is constant along the solutions.
    """

    rate: float
    restoring: float
    curving: float
    start: float
    next_term: float
    energy: ModifiedEnergy


def modified_equation(scheme: Scheme) -> ModifiedEquation:
    """The modified equation of a scheme.

    Raises
    ------
    ValueError
        If no modified equation of the scheme is known here, as for schemes that dissipate.

    References
    ----------
    R. D. Skeel, G. Zhang, T. Schlick, A family of symplectic integrators: stability, accuracy, and molecular dynamics
    applications, SIAM J. Sci. Comput. 18(1), 1997, 203-222.
    C. Kane, J. E. Marsden, M. Ortiz, M. West, Variational integrators and the Newmark algorithm for conservative and
    dissipative mechanical systems, Int. J. Numer. Methods Eng. 49(10), 2000, 1295-1325.
    """
    match scheme:
        case Newmark(beta=beta, gamma=0.5):
            energy = ModifiedEnergy(1 / 12, beta / 2 - 1 / 24, 1 / 24 - beta / 2)
            next_term = 3 / 8 * beta**2 - beta / 16 + 3 / 640
            return ModifiedEquation(0.0, beta - 1 / 12, 1 / 12 - beta, 1 / 6 - beta, next_term, energy)
        case ImplicitMidpoint():
            return ModifiedEquation(1 / 12, 1 / 12, 1 / 24, 0.0, 1 / 80, ModifiedEnergy(-1 / 24, -1 / 24, -1 / 12))
    raise ValueError(
        f"the error of '{scheme.title}' is not known without a run: it is for Newmark's methods with gamma = 0.5, "
        "such as central_difference, and for implicit_midpoint. A scheme that dissipates conserves no "
        "modified energy, and the modified energies of other schemes are not computed here."
    )


@partial(jit, compiler=eqx.filter_jit)
def _first_period(problem: Problem, equation: ModifiedEquation, mass, period, steps):
    """Velocity of a motion, and the coefficient of Δt² in the error of u, along the first period."""
    force = problem.static_force
    tangent, curvature = jax.grad(force), jax.grad(jax.grad(force))

    def rate(y):
        u, v, error, error_of_v = y
        p, slope = force(u), tangent(u)
        return jnp.stack(
            [
                v,
                -p / mass,
                error_of_v - equation.rate * slope * v / mass,
                (equation.restoring * slope * p / mass + equation.curving * curvature(u) * v**2 - slope * error) / mass,
            ]
        )

    def step(y, _):
        k1 = rate(y)
        k2 = rate(y + dt / 2 * k1)
        k3 = rate(y + dt / 2 * k2)
        y += dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + dt * k3))
        return y, (y[1], y[2])

    dt, u, v = period / len(steps), jnp.asarray(problem.u0, float), jnp.asarray(problem.v0, float)
    start = jnp.stack([u, v, jnp.zeros(()), equation.start * tangent(u) * v / mass])
    return lax.scan(step, start, steps)[1]


def displacement_error(
    problem: Problem, equation: ModifiedEquation, mass: float, period: float, frequency: float
) -> tuple[_Along, _Along]:
    """Velocity of a free oscillation, and the coefficient of Δt² in the error of u, along its first period.

    Parameters
    ----------
    frequency
        Highest circular frequency of the tangent along the motion.
    """
    number = max(STEPS, STEPS_OF_HIGHEST * frequency * period / (2 * math.pi))
    steps = np.arange(2 ** math.ceil(math.log2(number)))  # few lengths, so that few programs are compiled
    velocity, error = _first_period(problem, equation, np.float64(mass), np.float64(period), steps)
    return np.asarray(velocity), np.asarray(error)
