"""Oscillators whose force has kinks or memory: yielding, hysteresis, contact, dry friction, and loads with kinks.

The named oscillators have a unit mass and a period of about one second.
"""

import numpy as np

from study.materials import bouc_wen, elastoplastic, friction, gap
from study.mechanics.definition import Problem
from study.mechanics.ground import GroundMotion
from study.mechanics.loads import HalfSine
from study.problem.naming import Known, named

#: Period in s of a unit mass on the elastic spring of the named oscillators, except the bouncing mass.
PERIOD = 1.0
#: Stiffness of this spring.
_STIFFNESS = (2 * np.pi / PERIOD) ** 2
#: Displacement at yield, and initial speed: four times the speed with which the undamped mass just reaches yield.
_YIELD, _SPEED = 0.1, 4 * 0.1 * 2 * np.pi / PERIOD
#: Damping coefficient c, two percent of the critical damping.
_DAMPING = 0.02 * 2 * 2 * np.pi / PERIOD

#: Acceleration of gravity, height of the fall of the bouncing mass, and stiffness of its stop.
_GRAVITY, _HEIGHT, _STOP = 9.81, 0.5, 25 * _STIFFNESS
#: Circular frequency of the contact, and time between two turns of the bouncing mass at the
#: top: the fall and the rise, and the contact, which is a part of a harmonic oscillation about the static displacement.
_CONTACT = np.sqrt(_STOP)
BOUNCE = float(
    2 * np.sqrt(2 * _HEIGHT / _GRAVITY)
    + 2 * (np.pi - np.arctan(np.sqrt(2 * _GRAVITY * _HEIGHT) * _CONTACT / _GRAVITY)) / _CONTACT
)
#: Time in s by which steps of the named oscillators are counted.
SCALES = dict.fromkeys(("yielding", "hysteretic", "belt", "shaken", "pulse"), PERIOD) | {"bouncing": BOUNCE}

#: Time in s between two samples of the ground motions.
SPACING = 0.02


@named()
def yielding() -> Problem:
    """A mass thrown onto an elastoplastic spring: k = 4π², u_y = 0.1, b = 0.05, u̇₀ = 2.51, damping ratio 0.02."""
    spring = elastoplastic(stiffness=_STIFFNESS, yield_force=_STIFFNESS * _YIELD, hardening=0.05)
    return Problem(spring, 0.0, _SPEED, potential=spring.potential, damping=_DAMPING, title="yielding oscillator")


@named()
def hysteretic() -> Problem:
    """The mass of ``yielding`` thrown onto a spring with the smooth hysteresis of Bouc and Wen, n = 1."""
    spring = bouc_wen(stiffness=_STIFFNESS, yield_force=_STIFFNESS * _YIELD, hardening=0.05)
    return Problem(spring, 0.0, _SPEED, damping=_DAMPING, title="hysteretic oscillator")


@named()
def bouncing() -> Problem:
    """A mass that falls under gravity from half a metre onto a stop of stiffness 100 π², and bounces without loss."""
    stop = gap(stiffness=_STOP)
    weight = GroundMotion(np.array([-_GRAVITY, -_GRAVITY]), 1e6, title="gravity")
    return Problem(stop, -_HEIGHT, 0.0, potential=stop.potential, ground=weight, title="bouncing mass")


#: Speed of the belt, and time at which the mass first turns back after it has stuck to the belt.
BELT, TURN = _YIELD * np.pi, (2 * np.pi / 3 + np.sqrt(3)) / (2 * np.pi)


@named(known=Known(TURN, "harmonic pieces", u=np.array(1.5 * _YIELD - BELT * TURN)))
def belt() -> Problem:
    r"""A mass on a spring that a moving belt drags by dry friction: it slips, sticks and slips again.

    .. math::

        \ddot x + k\,(x + V t) + p(x) = 0, \quad |p| \le k u_s

    x = u − Vt is the displacement relative to the belt, k = 4π², u_s = 0.1, V = 0.1π, and p the friction of a contact
    of stiffness 10⁶ k. From rest the mass slips, u = u_s (1 − cos ωt), until it has the speed of the belt at ωt = π/6.
    It sticks until its spring overcomes the friction at u = u_s and :math:`\omega t = \pi/6 + \sqrt3`. Then it swings
    about u_s with the amplitude V/ω = u_s/2, and turns back at u = 0.15 and :math:`\omega t = 2\pi/3 + \sqrt3`. The
    motion with the stiff contact differs from this motion with rigid friction by less than 1e-5 of its size.

    References
    ----------
    R. I. Leine, D. H. van Campen, A. de Kraker, L. van den Steen, Stick-slip vibrations induced by alternate friction
    models, Nonlinear Dyn. 16(1), 1998, 41-54 (the mass on a belt).
    """
    rigid = 1e6 * _STIFFNESS
    contact = friction(slip_force=_STIFFNESS * _YIELD, stiffness=rigid)

    def force(u, v, history):
        p, history = contact(u, v, history)
        return _STIFFNESS * u + p, history

    return Problem(
        force,
        0.0,
        -BELT,
        # the contact slips at the start
        history=_STIFFNESS * _YIELD / rigid,
        load=lambda t: -_STIFFNESS * BELT * t,
        title="mass on a belt",
    )


def ground_motions(number: int) -> list[GroundMotion]:
    """A list of ``number`` ground motions: El Centro, 1940, and stochastic motions with the same spacing of samples."""
    return [GroundMotion.el_centro(), *(GroundMotion.kanai_tajimi(seed, dt=SPACING) for seed in range(1, number))]


def yielding_under_record(ground, period, yield_force) -> Problem:
    """The oscillator of :func:`yielding_oscillator` on moving ground.

    Parameters
    ----------
    ground
        Motion of the ground.
    period, yield_force
        As in :func:`yielding_oscillator`.
    """
    return yielding_oscillator(period, yield_force, ground=ground, title="yielding oscillator under a record")


#: Damping ratio of small motions of oscillators under records.
DAMPING_RATIO = 0.05


def yielding_oscillator(period, yield_force, damping_ratio=DAMPING_RATIO, **more) -> Problem:
    """A unit mass at rest on an elastoplastic spring with hardening b = 0.02.

    Parameters
    ----------
    period
        Period of small motions, in s.
    yield_force
        Force at which the spring yields, in N per kg of mass.
    damping_ratio
        Damping ratio of small motions.
    more
        Further arguments of the problem.
    """
    frequency = 2 * np.pi / period
    spring = elastoplastic(stiffness=frequency**2, yield_force=yield_force, hardening=0.02)
    return Problem(spring, 0.0, damping=2 * damping_ratio * frequency, **more)


@named()
def shaken() -> Problem:
    """A linear oscillator with damping ratio 0.05 under the ground motion of El Centro, 1940."""
    return Problem(
        lambda u: _STIFFNESS * u,
        0.0,
        potential=lambda u: _STIFFNESS * u**2 / 2,
        damping=2.5 * _DAMPING,
        ground=GroundMotion.el_centro(),
        title="shaken oscillator",
    )


@named()
def pulse() -> Problem:
    r"""A linear oscillator from rest under half a sine, ü + ω² u = ω² sin(πt/t_d) up to t_d = 0.2, ω = 2π.

    .. math::

        u = \frac{\sin(\pi t/t_d) - r \sin \omega t}{1 - r^2} \quad\text{for } t \le t_d, \quad
        r = \frac{\pi}{\omega t_d}

    After t_d the motion is free.

    References
    ----------
    A. K. Chopra, Dynamics of structures: theory and applications to earthquake engineering, 4th ed., Prentice Hall,
    2012, chapter 4.
    """
    return Problem(
        lambda u: _STIFFNESS * u,
        0.0,
        potential=lambda u: _STIFFNESS * u**2 / 2,
        load=HalfSine(_STIFFNESS, duration=0.2),
        title="oscillator under a pulse",
    )
