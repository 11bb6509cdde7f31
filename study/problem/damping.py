"""Rayleigh damping."""

from typing import NamedTuple

from study.algebra.arrays import Matrix, as_float64
from study.algebra.matrices import add, product


class Rayleigh(NamedTuple):
    """Damping C = a M + b K with the stiffness K = ∂p/∂u of the undeformed structure.

    A mode of circular frequency ω has the damping ratio ξ = (a/ω + b ω)/2.
    """

    a: float
    b: float


def rayleigh_matrix(damping: Rayleigh, mass: Matrix, stiffness: Matrix, n: int) -> Matrix:
    """C = a M + b K for n unknowns."""
    a, b = damping
    return add(product(as_float64(a), mass, n), product(as_float64(b), stiffness, n), n=n)
