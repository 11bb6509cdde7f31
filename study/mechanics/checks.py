"""Checks of the numbers of a problem, made once when the problem is made.

Each check raises an error for invalid values. Its message names the argument, and the expected and received values.
Values that JAX is tracing have a shape but no numbers: only their shape is checked.
"""

import equinox as eqx
import jax
import numpy as np
import scipy

from study.algebra.arrays import Matrix, ScipySparse, real_numbers
from study.algebra.factorisation import is_positive_definite
from study.algebra.matrices import Banded, MatrixFree
from study.algebra.sparse import SYMMETRY, Sparse, as_sparse, from_jax, is_sparse, is_sparse_of_jax
from study.mechanics.ground import GroundMotion
from study.mechanics.terms import Rayleigh

#: Arguments of a problem that may be matrices.
MATRICES = ("stiffness", "mass", "damping")


def numbers_or_matrix(name: str, value):
    """The value as a float64 array, or as a sparse matrix if it is sparse.

    None, :class:`study.Rayleigh`, traced values and matrices that are already in a form of this package are returned
    unchanged.
    """
    if value is None or isinstance(value, jax.core.Tracer | Rayleigh | Banded | Sparse | MatrixFree):
        return value
    if is_sparse_of_jax(value):
        if isinstance(value.indices, jax.core.Tracer):
            raise ValueError(f"{name}: JAX may trace the entries of a sparse matrix, but not their positions.")
        return from_jax(value)
    if is_sparse(value):
        if value.ndim != 2:
            raise ValueError(f"{name} must be a matrix; the sparse array has the shape {value.shape}.")
        if value.dtype.kind not in "fiu":
            raise ValueError(f"{name} must be a sparse matrix of real numbers, not of {value.dtype}.")
        return as_sparse(value)
    return real_numbers(name, value)


def check_shapes(problem) -> None:
    """Refuse numbers whose shapes do not fit the shape of u₀."""
    shape = np.shape(problem.u0)
    if problem.u0 is None or len(shape) > 1 or shape == (0,):
        fault = "it is missing" if problem.u0 is None else f"not an array of shape {shape}"
        raise ValueError(f"u0 must be a number or a vector (n,), {fault}.")
    if np.shape(problem.v0) != shape:
        raise ValueError(f"v0 must have the shape of u0, {shape}, not {np.shape(problem.v0)}.")
    for name in MATRICES:
        value = getattr(problem, name)
        has = (value.pattern.size,) * 2 if isinstance(value, Sparse) else getattr(value, "shape", None)
        if (is_sparse(value) or isinstance(value, Sparse)) and has != shape * 2:
            raise ValueError(f"{name} must have the shape {shape * 2} for u0 of shape {shape}; got {has}.")
        if isinstance(value, np.ndarray | jax.Array) and value.shape not in {(), shape, shape * 2}:
            raise ValueError(
                f"{name} must be a number, a diagonal or a matrix for u0 of shape {shape}; got {value.shape}."
            )
    if problem.influence is not None and problem.ground is None:
        raise ValueError("influence needs Problem(ground=...), the motion of the ground.")
    if problem.influence is not None and np.shape(problem.influence) != shape:
        raise ValueError(f"influence must have the shape of u0, {shape}, not {np.shape(problem.influence)}.")
    if problem.positions is not None and (
        np.ndim(problem.positions) != 2
        or np.shape(problem.positions)[1] > 3
        or np.size(problem.positions) != np.size(problem.u0)
    ):
        raise ValueError(
            f"positions must have the shape (points, directions), with at most three directions and as many numbers as "
            f"u0, which has {np.size(problem.u0)}; their shape is {np.shape(problem.positions)}."
        )


def check_finite(name: str, value) -> None:
    """Refuse numbers that are not finite."""
    if isinstance(value, np.ndarray) and not np.isfinite(value).all():
        raise ValueError(f"{name} must be finite, not {value}.")
    if is_sparse(value) and not np.isfinite(value.data).all():
        places = scipy.sparse.coo_array(value)
        row, column = (int(place[np.argmin(np.isfinite(places.data))]) for place in places.coords)
        raise ValueError(f"{name} must be finite, and its entry ({row}, {column}) is {value[row, column]}.")


def check_ground(ground, load, title: str) -> None:
    """Refuse a ground that is not a GroundMotion, and a load that is not a function."""
    if not isinstance(ground, GroundMotion):
        raise TypeError(f"ground of '{title}' must be a study.GroundMotion, not {ground!r}.")
    if load is not None and not callable(load):
        raise TypeError(f"load must be a function, not {load!r}.")


def check_symmetry(name: str, matrix) -> None:
    """Refuse a matrix (n, n) that is not symmetric."""
    if is_sparse(matrix) or (isinstance(matrix, np.ndarray) and matrix.ndim == 2):
        difference = np.abs(matrix - matrix.T).max()
        if difference > SYMMETRY * np.abs(matrix).max():
            matrix_of_jax = "jax.experimental.sparse.BCOO.from_scipy_sparse(K)" if is_sparse(matrix) else "K"
            remedy = {
                "stiffness": f": give it as a force, force=lambda u: {matrix_of_jax} @ u",
                "mass": ": leave it out, and give force, damping and load multiplied by its inverse",
            }.get(name, "")
            raise ValueError(f"{name} must be symmetric; it differs from its transpose by {difference:g}{remedy}.")


def is_singular(mass) -> bool:
    """Whether the mass is singular.

    A mass that is zero everywhere is refused. So is a number or a diagonal with a negative value, and a matrix with a
    negative eigenvalue. A sparse mass must be positive definite among the unknowns that have mass.
    """
    if is_sparse(mass):
        return _is_singular(mass)
    if not isinstance(mass, np.ndarray):
        return False
    diagonal = np.diagonal(mass) if mass.ndim == 2 else mass
    full = mass.ndim == 2 and np.count_nonzero(mass) > np.count_nonzero(diagonal)
    values = np.linalg.eigvalsh(mass) if full else diagonal
    # eigenvalues of a full matrix have round-off
    smallest, zero = values.min(), np.abs(values).max() * (1e-14 * len(values) if full else 0.0)
    if smallest < -zero:
        raise ValueError(f"mass must not be negative; its smallest value is {smallest:g}.")
    if np.abs(values).max() == 0:
        raise ValueError("mass must not be zero everywhere: the problem would have no dynamics.")
    return bool(smallest <= zero)


def _is_singular(mass: ScipySparse) -> bool:
    has = abs(mass).sum(axis=0) > 0
    singular = is_singular(has.astype(float))
    if not is_positive_definite(mass[has][:, has]):
        raise ValueError("mass must be positive definite among the unknowns that have mass; it is not.")
    return singular


def check_rayleigh(damping: Rayleigh, title: str) -> None:
    """Refuse coefficients of Rayleigh damping that are negative or not finite numbers."""
    coefficients = damping.a, damping.b
    if any(isinstance(c, jax.core.Tracer) for c in coefficients):
        return
    if not all(np.ndim(c) == 0 and np.asarray(c).dtype.kind in "fiu" and 0 <= c < np.inf for c in coefficients):
        raise ValueError(f"{damping} of '{title}': a and b must be finite numbers that are not negative.")


def finite_damping(damping: Matrix, title: str) -> Matrix:
    """The given matrix of Rayleigh damping, after a check that the stiffness on which it is based is finite."""
    parts = jax.tree.leaves(eqx.filter(damping, eqx.is_array))
    if not all(isinstance(part, jax.core.Tracer) or np.isfinite(part).all() for part in parts):
        raise ValueError(f"the stiffness of '{title}' at u = 0, on which its Rayleigh damping is based, is not finite.")
    return damping
