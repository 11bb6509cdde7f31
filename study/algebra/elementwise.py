"""Formulas for each component of a vector: compensated sums, and interpolation between the ends of a step."""

from typing import Any

from study.algebra.arrays import Vector


def compensated_sum(total: Vector, increment: Vector, lost: Vector) -> tuple[Vector, Vector]:
    r"""Kahan's sum of a total and an increment, and the round-off of this addition.

    .. math::

        y = \Delta - \text{lost}, \quad s_1 = s_0 + y, \quad \text{lost} = (s_1 - s_0) - y

    The argument ``lost`` is the round-off of the previous addition, zero at first. The second value returned is the new
    ``lost``.

    References
    ----------
    W. Kahan, Further remarks on reducing truncation errors, Commun. ACM 8(1), 1965, 40.
    """
    corrected = increment - lost
    new = total + corrected
    return new, (new - total) - corrected


def quintic(start: tuple, end: tuple, dt: Any, derivative: bool = False) -> tuple:
    """Coefficients of the quintic polynomial with given u, u̇ and ü at both ends of a step; the constant term is first.

    The variable of the polynomial is s = (t − t₀)/Δt, which rises from 0 to 1. With ``derivative``, the function
    returns the coefficients of the derivative with respect to s. ``start`` and ``end`` hold u, u̇ and ü at the two ends
    of the step: numbers, or arrays of NumPy or JAX that broadcast.
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
    return tuple(k * c for k, c in enumerate(coefficients))[1:] if derivative else coefficients


def value(coefficients: tuple, s: Any) -> Any:
    """Value of a polynomial at ``s`` by Horner's rule; the coefficients begin with the lowest power."""
    *lower, result = coefficients
    for coefficient in reversed(lower):
        result = result * s + coefficient
    return result
