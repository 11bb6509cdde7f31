"""Formulas for each component of a vector: compensated sums, and interpolation between the ends of a step."""

from typing import Any

from study.algebra.arrays import Vector


def compensated_sum(total: Vector, increment: Vector, lost: Vector) -> tuple[Vector, Vector]:
    r"""Kahan's sum of a total and an increment, and the round-off of this addition.

    .. math::

        y = \Delta - \text{lost}, \quad s_1 = s_0 + y, \quad \text{lost} = (s_1 - s_0) - y

    ``lost`` is the round-off of the previous addition, zero at first.

    References
    ----------
    W. Kahan, Further remarks on reducing truncation errors, Commun. ACM 8(1), 1965, 40.
    """
    corrected = increment - lost
    new = total + corrected
    return new, (new - total) - corrected


def quintic(start: tuple, end: tuple, dt: Any, of_v: bool = False) -> tuple:
    """Coefficients, lowest first, of the quintic through u, u̇ and ü at both ends of a step.

    Its variable s = (t − t₀)/Δt rises from 0 to 1. With ``of_v``, the coefficients are those of its derivative with
    respect to s. Numbers and arrays of NumPy or JAX broadcast.
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
