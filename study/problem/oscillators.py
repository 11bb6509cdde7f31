"""Oscillators with one unknown beyond those of Xie (1996)."""

from functools import partial

import jax.numpy as jnp
import numpy as np

from study.mechanics.definition import Problem
from study.mechanics.loads import HarmonicLoad
from study.problem.naming import named


@named(time_scale=33.7210)
def pendulum() -> Problem:
    """The plane pendulum ü + sin u = 0 that almost reaches its upper equilibrium: u₀ = 0, u̇₀ = 1.999999238456499.

    Its period 4K(u̇₀/2) = 33.7210 is five times the period of small oscillations.

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

    With the amplitude γ = 0.2 the motion settles to the period of the load, with γ = 0.5 it is chaotic.

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


#: Period of the load.
_LOAD_PERIOD = 2 * np.pi / 1.2
duffing_periodic = named(time_scale=_LOAD_PERIOD)(partial(duffing, 0.2, "Duffing, periodic"))
duffing_chaotic = named(time_scale=_LOAD_PERIOD)(partial(duffing, 0.5, "Duffing, chaotic"))
