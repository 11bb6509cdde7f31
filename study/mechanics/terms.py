"""Special forms of terms of the equation of motion: strain energy and Rayleigh damping."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp

from study.algebra.arrays import Matrix, Scalar, Vector, as_float64
from study.algebra.matrices import add, product
from study.keywords import KeywordsOnly


class StrainEnergy(eqx.Module):
    """A potential V(u) = Σ w(ε(u)) of strains ε.

    The strains should not change in a rigid motion. The energy-momentum method then conserves momentum too.

    Parameters
    ----------
    strains
        ε(u), of shape (m,): polynomials in u of degree two or less, such as the elongations of springs in a row or the
        squared lengths of bars.
    density
        w(ε), the energy of each strain, of shape (m,).
    """

    strains: Callable
    density: Callable

    def __call__(self, u: Vector) -> Scalar:
        """V(u)."""
        return jnp.sum(self.density(self.strains(u)))


def gradient(potential: Callable, u: Vector) -> Vector:
    """∂V/∂u by automatic differentiation."""
    return jax.grad(potential)(u)


class Rayleigh(KeywordsOnly, eqx.Module):
    r"""Damping C = a M + b K with the stiffness K of the undeformed structure.

    K is the tangent of the whole internal force at u = 0. A mode of circular frequency ω has the damping ratio
    :math:`\xi = (a/\omega + b\omega)/2`. Both coefficients are given by name.
    """

    a: float
    b: float


def rayleigh_matrix(damping: Rayleigh, mass: Matrix, stiffness: Matrix, n: int) -> Matrix:
    """C = a M + b K for n unknowns."""
    return add(product(as_float64(damping.a), mass, n), product(as_float64(damping.b), stiffness, n), n=n)
