"""Exact motion of a mass on a linear spring with the rigid friction of Coulomb, half swing by half swing.

    m ü + k u + F sgn u̇ = 0,    at rest where |k u| ≤ F

Each half swing is harmonic about the displacement ∓F/k and takes π/ω, so that the amplitude falls by 2 F/k in it, until
the spring can no longer overcome the friction.

Source: J. P. Den Hartog, Mechanical Vibrations, 4th edition, McGraw-Hill, 1956, section 7.5.
"""

import numpy as np

from reference.solution import History, Times


def released(mass: float, stiffness: float, slip_force: float, u0: float, t: Times) -> tuple[History, History]:
    """Displacement and velocity at the times ``t`` of a mass released from rest in ``u0``.

    Raises
    ------
    ValueError
        If mass or stiffness is not greater than zero, or the slip force is negative.
    """
    if not (mass > 0 and stiffness > 0 and slip_force >= 0):
        raise ValueError(
            f"mass and stiffness must be greater than zero and the slip force at least zero, not {mass}, {stiffness}, "
            f"{slip_force}."
        )
    frequency, offset = np.sqrt(stiffness / mass), slip_force / stiffness
    stuck = max(np.ceil((abs(u0) / offset - 1) / 2), 0.0) if offset else np.inf
    swing = np.minimum(np.floor(frequency * np.asarray(t) / np.pi), stuck)
    side = np.sign(u0) * (-1) ** swing
    rest, phase = abs(u0) - 2 * swing * offset, frequency * np.asarray(t) - np.pi * swing
    moves = swing < stuck
    u = side * np.where(moves, offset + (rest - offset) * np.cos(phase), rest)
    v = side * np.where(moves, -frequency * (rest - offset) * np.sin(phase), 0.0)
    return u, v
