"""Rayleigh damping."""

from typing import NamedTuple

import equinox as eqx
import jax
import numpy as np

from study.algebra.arrays import Matrix
from study.algebra.matrices import add, product


class Rayleigh(NamedTuple):
    """Damping C = a M + b K with the stiffness K = ∂p/∂u of the undeformed structure.

    A mode of circular frequency ω has the damping ratio ξ = (a/ω + b ω)/2.
    """

    a: float
    b: float


def rayleigh_matrix(damping: Rayleigh, mass: Matrix, stiffness: Matrix, n: int, title: str) -> Matrix:
    """C = a M + b K for n unknowns.

    Raises
    ------
    ValueError
        If C is not finite; the message names the problem by its title.
    """
    a, b = damping
    matrix = add(product(float(a), mass, n), product(float(b), stiffness, n), n=n)
    if not all(np.isfinite(part).all() for part in jax.tree.leaves(eqx.filter(matrix, eqx.is_array))):
        raise ValueError(f"the stiffness of '{title}' at u = 0, on which its Rayleigh damping is based, is not finite.")
    return matrix
