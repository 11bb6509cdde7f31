"""Potentials of internal forces."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp

from study.algebra.arrays import Scalar, Vector


class StrainEnergy(eqx.Module):
    """A potential V(u) = Σ w(ε(u)) of strains ε.

    A conserving scheme needs the strains: a rigid motion leaves them unchanged.

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
