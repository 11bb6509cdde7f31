"""Eigenvalues of amplification matrices, and the principal eigenvalue as a function of the step size."""

import numpy as np
from jaxtyping import Complex, Float

#: A number for each step size, shape (points,).
Points = Float[np.ndarray, "points"]

#: A complex number for each step size, shape (points,).
ComplexPoints = Complex[np.ndarray, "points"]

#: Eigenvalues for each step size, shape (points, m).
Roots = Complex[np.ndarray, "points m"]

#: A matrix for each step size, shape (points, m, m).
Matrices = Float[np.ndarray, "points m m"]


def eigenvalues(matrices: Matrices) -> Roots:
    """Eigenvalues, of shape (points, m), infinite where a matrix overflows."""
    finite = np.isfinite(matrices).all(axis=(1, 2))
    roots = np.full(matrices.shape[:2], complex(np.inf))
    roots[finite] = np.linalg.eigvals(matrices[finite])
    return roots


def followed(roots: Roots, exponent: complex, omega: Points) -> ComplexPoints:
    """Logarithm of the principal root at each step size Ω, followed by continuity from Ω = 0.

    The principal root tends to exp(exponent · Ω) for Ω → 0. The logarithm is NaN from the first step size at which
    this root is real.
    """
    result = np.full(len(omega), complex(np.nan, np.nan))
    last, slope = (0.0, 0j), exponent
    for i, (candidates, step) in enumerate(zip(roots, omega, strict=True)):
        expected = last[1] + slope * (step - last[0])
        root = candidates[np.argmin(np.abs(candidates - np.exp(expected)))]
        if abs(root.imag) <= 1e-9 * abs(root):
            break
        # the nearest branch of the logarithm, since a step may be longer than half a period
        turns = np.round((expected - np.log(root)).imag / (2 * np.pi))
        result[i] = np.log(root) + 2j * np.pi * turns
        slope = (result[i] - last[1]) / (step - last[0])
        last = step, result[i]
    return result
