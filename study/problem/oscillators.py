"""Oscillators with one unknown beyond those of Xie (1996)."""

from functools import partial

import jax.numpy as jnp
import numpy as np

from study.mechanics.definition import Problem
from study.mechanics.loads import HarmonicLoad
from study.problem.naming import Known, named


@named(time_scale=33.7210)
def pendulum() -> Problem:
    """The plane pendulum ü + sin u = 0 that almost reaches its upper equilibrium: u₀ = 0, u̇₀ = 1.999999238456499.

    Its period 4K(u̇₀/2) = 33.7210 is 5.4 times the period of small oscillations.

    References
    ----------
    K. J. Bathe, Conserving energy and momentum in nonlinear dynamics: a simple implicit time integration scheme,
    Comput. Struct. 85(7-8), 2007, 437-445.
    """
    return Problem(
        jnp.sin, 0.0, 1.999999238456499, potential=lambda u: 2 * jnp.sin(u / 2) ** 2, title="pendulum near its top"
    )


def duffing(amplitude: float, title: str) -> Problem:
    """Duffing's oscillator with two wells, damped and forced: ü + 0.3 u̇ − u + u³ = γ cos 1.2t, u₀ = 1, u̇₀ = 0.

    With the amplitude γ = 0.2 the motion settles to the period of the load; with γ = 0.5 it is chaotic.

    References
    ----------
    D. W. Jordan, P. Smith, Nonlinear ordinary differential equations, 4th ed., Oxford University Press, 2007, chapter
    13.
    """
    return Problem(
        force=lambda u: u * u * u - u,
        u0=1.0,
        potential=lambda u: u * u * (u * u / 4 - 1 / 2),
        damping=0.3,
        load=HarmonicLoad(amplitude, frequency=1.2, phase=0.0),
        title=title,
    )


#: Period of the load of Duffing's oscillator.
_LOAD_PERIOD = 2 * np.pi / 1.2
duffing_periodic = named(time_scale=_LOAD_PERIOD)(partial(duffing, 0.2, "Duffing, periodic"))
duffing_chaotic = named(time_scale=_LOAD_PERIOD)(partial(duffing, 0.5, "Duffing, chaotic"))


#: Largest Lyapunov exponent of Ueda's oscillator, as Sprott (2003) prints it.
UEDA_EXPONENT = 0.1034


@named(time_scale=2 * np.pi)  # period of the load
def ueda(damping: float = 0.05, amplitude: float = 7.5) -> Problem:
    """Ueda's oscillator ü + k u̇ + u³ = B cos t with k = 0.05 and B = 7.5, whose motion is chaotic: u₀ = 2.5, u̇₀ = 0.

    Its largest Lyapunov exponent is 0.1034 per unit of time (Sprott, 2003). For k = 0.1 and B = 10, 11, 12 and 13 Ueda
    (1979) gives 0.102, 0.114, 0.149 and 0.182. Exponents computed with small steps differ from these by up to 10 %.

    References
    ----------
    Y. Ueda, Randomly transitional phenomena in the system governed by Duffing's equation, J. Stat. Phys. 20(2), 1979,
    181-196.
    J. C. Sprott, Chaos and time-series analysis, Oxford University Press, 2003.
    """
    return Problem(
        force=lambda u: u * u * u,
        u0=2.5,
        potential=lambda u: u**4 / 4,
        damping=damping,
        load=HarmonicLoad(amplitude, frequency=1.0, phase=0.0),
        title="Ueda's oscillator",
    )


@named(time_scale=np.sqrt(2) * np.pi)  # period of u with ε = 0
def mathieu(delta: float = 2.0, epsilon: float = 0.5) -> Problem:
    """Mathieu's oscillator ü + (δ + 2ε cos 2t) u = 0 with δ = 2 and ε = 0.5, from u₀ = 1 at rest.

    Near δ = 1, 4, 9, ... the motion grows without bound if ε is not zero. With δ = 2 and ε = 0.5 it stays bounded. On a
    boundary of stability it has the period π or 2π and is a Mathieu function.

    References
    ----------
    D. W. Jordan, P. Smith, Nonlinear ordinary differential equations, 4th ed., Oxford University Press, 2007, chapter
    9.
    """
    return Problem(lambda u, t: (delta + 2 * epsilon * jnp.cos(2 * t)) * u, 1.0, title="Mathieu's oscillator")


@named(time_scale=1.0, known=Known(2.0, "Mazzia and Magherini (2008), van der Pol", np.array(1.706167732170483)))
def van_der_pol() -> Problem:
    """Van der Pol's oscillator ε ü + (u² − 1) u̇ + u = 0 with ε = 1e-6: u₀ = 2, u̇₀ = 0.

    The motion creeps along u̇ = u/(1 − u²) down to u = 1, at t = 0.81, where it jumps to u = −2 within a time of the
    order ε.

    References
    ----------
    E. Hairer, G. Wanner, Solving ordinary differential equations II, 2nd ed., Springer, 1996, section IV.10.
    F. Mazzia, C. Magherini, Test set for initial value problem solvers, Release 2.4, Department of Mathematics,
    University of Bari, 2008.
    """
    return Problem(lambda u, v: (u * u - 1) * v + u, 2.0, 0.0, mass=1e-6, title="van der Pol, stiff")


#: Load P of the shallow arch.
ARCH_LOAD = 0.3


def _arch_turn() -> tuple[float, float]:
    """Time from rest to the farthest deflection of the shallow arch, and that deflection.

    From u³/4 − u² + u − P = (u − b)|u − c|²/4, with the real root b and a complex root c, follows
    u̇² = u (b − u) |u − c|²/2. With u = b sin²φ the time is the integral of 2√2/|u − c| over φ. The integrand is
    periodic, so that the trapezoidal rule converges geometrically.
    """
    roots = np.roots([1 / 4, -1.0, 1.0, -ARCH_LOAD])
    farthest, pair = roots[np.abs(roots.imag).argmin()].real, roots[np.abs(roots.imag).argmax()]
    u = farthest * np.sin(np.linspace(0, np.pi / 2, 1025)) ** 2
    values = 2 * np.sqrt(2) / np.abs(u - pair)
    return float(np.trapezoid(values, dx=np.pi / 2 / 1024)), float(farthest)


_TURN, _FARTHEST = _arch_turn()


@named(time_scale=np.sqrt(2) * np.pi, known=Known(5 * _TURN, "integral of energy", np.array(_FARTHEST)))
def shallow_arch() -> Problem:
    r"""Two shallow bars in an arch that snaps through under a load which appears at t = 0.

    .. math::

        \ddot u + 2u - 3u^2 + u^3 = P, \quad P = 0.3

    from u₀ = 0 at rest, where u is the deflection of the crown relative to the height of the arch. A static load snaps
    it through at :math:`2/(3\sqrt3) = 0.385`. A sudden load does so at 8/27 = 0.296, where its work up to u = 2/3
    equals the energy of the unstable equilibrium there. The time scale is the period of small motions about u = 0.

    References
    ----------
    G. J. Simitses, Dynamic stability of suddenly loaded structures, Springer, 1990.
    """
    return Problem(
        lambda u: u * (2 - u * (3 - u)),
        0.0,
        potential=lambda u: u * u * (1 - u * (1 - u / 4)),
        load=lambda t: jnp.full((), ARCH_LOAD),
        title="shallow arch",
    )
