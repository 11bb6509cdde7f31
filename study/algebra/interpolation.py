"""Interpolation between the ends of a step."""

from typing import Any


def quintic(start: tuple, end: tuple, dt: Any, of_v: bool = False) -> tuple:
    """Coefficients in 0 ≤ s ≤ 1, lowest first, of the quintic through u, u̇ and ü at both ends of a step.

    With ``of_v``, those of its derivative to s. Numbers and arrays of NumPy or JAX, which broadcast.
    """
    (u0, v0, a0), (u1, v1, a1) = start, end
    v0, v1, a0, a1 = dt * v0, dt * v1, dt**2 * a0, dt**2 * a1
    rise = u1 - u0 - v0 - a0 / 2
    slope, curvature = v1 - v0 - a0, a1 - a0
    coefficients = (
        u0,
        v0,
        a0 / 2,
        10 * rise - 4 * slope + curvature / 2,
        -15 * rise + 7 * slope - curvature,
        6 * rise - 3 * slope + curvature / 2,
    )
    return tuple(k * c for k, c in enumerate(coefficients))[1:] if of_v else coefficients


def value(coefficients: tuple, s: Any) -> Any:
    """Value of a polynomial, by Horner's rule."""
    *lower, result = coefficients
    for coefficient in reversed(lower):
        result = result * s + coefficient
    return result
