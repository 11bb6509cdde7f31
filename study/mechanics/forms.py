"""The forms in which a problem stores the tangent and the matrices that are added to it."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import scipy

from study.algebra.arrays import Matrix, ScipySparse
from study.algebra.matrices import SMALL, Banded, banded, banded_sparse, times
from study.algebra.sparse import SYMMETRY, Sparse, is_sparse, union
from study.mechanics import tangent
from study.mechanics.function_checks import NOT_TRACEABLE
from study.mechanics.sparse_tangent import SparseTangent, coupling_of
from study.mechanics.tangent import FormOfTangent


def form_of_tangent(
    force: Callable | None, u0: np.ndarray, declared: Any, massless: bool, others: list[ScipySparse], title: str
) -> FormOfTangent:
    """The form of the tangent, as declared or as found at a few displacements.

    It is None for one unknown. It is 0, a diagonal, if the problem has neither a force nor a sparse matrix.

    Parameters
    ----------
    force
        A function of u whose derivative has an entry wherever the tangent has one; None without a force.
    declared
        Form that the problem declares, or None.
    massless
        Whether the mass is singular.
    others
        The sparse matrices among stiffness, mass and damping.

    Raises
    ------
    ValueError
        If the declared form does not exist, does not fit the tangent, or is declared for one unknown; if the derivative
        is not finite near u₀; or if the form must be found while JAX traces numbers of the force.
    """
    if np.ndim(u0) == 0:
        if declared is not None:
            raise ValueError(
                f"tangent={declared!r} of '{title}': the tangent of one unknown is a number; leave it out."
            )
        return None
    next_to_sparse = bool(others) or is_sparse(declared)
    if force is None and not next_to_sparse:
        return 0
    known = None if declared is None or next_to_sparse else tangent.form_named(declared, len(u0), title)
    coupling = _declared_coupling(declared, len(u0), title) if next_to_sparse and declared is not None else None
    if known == "dense" or (known is None and not next_to_sparse and len(u0) <= SMALL):
        return "dense"
    try:
        with jax.ensure_compile_time_eval():  # JAX may be tracing while the problem is made
            if next_to_sparse or (declared is None and len(u0) > tangent.FINDABLE):
                return _next_to_sparse(force, u0, coupling, others, title)
            if declared is None:
                return tangent.detected_form(force, u0, massless, title)  # type: ignore[arg-type]
            tangent.check_declared_form(force, u0, declared, title)  # type: ignore[arg-type]
    except NOT_TRACEABLE:  # JAX traces numbers of the force, so that the values of the tangent are unknown
        if declared is None:
            forms = (
                "diagonal, tridiagonal, a half bandwidth, or a sparse matrix with an entry wherever it has one"
                if next_to_sparse
                else f"one of {', '.join(tangent.FORMS)} or a half bandwidth"
            )
            raise ValueError(
                f"'{title}' is made while JAX traces numbers in its force: declare the form of its tangent "
                f"with Problem(tangent=...), {forms}."
            ) from None
        if coupling is not None:
            return SparseTangent(coupling, others, symmetric=False)
    return known


def entries_of(matrix: Matrix, name: str) -> ScipySparse | None:
    """A sparse matrix with the pattern of ``matrix``; None if ``matrix`` is not sparse.

    If JAX traces the values, the positions of the entries are still known, and the values are replaced. The new values
    are symmetric for a stiffness or a mass, and unsymmetric for a damping, which need not be symmetric.
    """
    if is_sparse(matrix):
        return matrix
    if not isinstance(matrix, Sparse):
        return None
    pattern = matrix.pattern
    numbers = np.where(pattern.rows > pattern.columns, 2.0 if name == "damping" else 1.0, 1.0)
    return scipy.sparse.csc_array((numbers, (pattern.rows, pattern.columns)), (pattern.size,) * 2)


def stored(matrix: Matrix, form: FormOfTangent) -> Matrix:
    """Stiffness, mass or damping in the smallest form in which it can be added to a tangent of the given form."""
    if isinstance(matrix, Sparse):
        if isinstance(form, SparseTangent):
            return matrix.within(form.pattern)
        return matrix.band(0) if form == 0 else Banded(jnp.stack([matrix.band(offset) for offset in (-1, 0, 1)]))
    if is_sparse(matrix):
        if matrix.nnz == np.count_nonzero(matrix.diagonal()):
            return matrix.diagonal()
        if isinstance(form, SparseTangent):
            return Sparse(form.pattern.values(matrix), form.pattern)  # type: ignore[arg-type]
        return banded_sparse(matrix, 1)
    is_matrix = isinstance(matrix, np.ndarray) and matrix.ndim == 2
    return banded(matrix, form) if is_matrix and isinstance(form, int) else matrix


def _declared_coupling(declared: Any, n: int, title: str) -> ScipySparse:
    """A matrix (n, n) with an entry at each position of the declared form, a sparse matrix or a half bandwidth."""
    if is_sparse(declared):
        if declared.shape != (n, n):
            raise ValueError(f"tangent of '{title}' must be a matrix of shape {(n, n)}, not {declared.shape}.")
        return union([declared])
    width = tangent.form_named(declared, n, title)
    if isinstance(width, str):
        raise ValueError(
            f"tangent={declared!r} of '{title}', whose stiffness, mass or damping is sparse: give diagonal, "
            "tridiagonal, a half bandwidth, or a sparse matrix with an entry wherever the derivative of the force has "
            "one; or leave it out."
        )
    bands = range(-width, width + 1)
    return scipy.sparse.diags_array([1.0] * len(bands), offsets=bands, shape=(n, n))


def _next_to_sparse(
    force: Callable | None, u0: np.ndarray, coupling: ScipySparse | None, others: list[ScipySparse], title: str
) -> SparseTangent | int:
    """Form of a tangent with sparse matrices or many unknowns: a half bandwidth of 0 or 1 if possible, or sparse."""
    n = len(u0)
    states = [] if force is None else tangent.probed_states(force, u0, title)
    declared = coupling is not None
    if coupling is None:
        coupling = scipy.sparse.csc_array((n, n)) if force is None else coupling_of(force, states)
    rows, columns = scipy.sparse.coo_array(union([coupling, *others])).coords
    width = int(np.abs(rows - columns).max(initial=0))
    if width <= 1:
        return width
    symmetric = all(abs(matrix - matrix.T).max() <= SYMMETRY * abs(matrix).max() for matrix in others)
    if force is not None:
        form = SparseTangent(coupling, others, symmetric=False)
        symmetric &= _is_symmetric(force, states, form, f"the declared tangent of '{title}'" if declared else "")
    return SparseTangent(coupling, others, symmetric)


def _is_symmetric(force: Callable, states: list[np.ndarray], form: SparseTangent, declared: str) -> bool:
    """Whether the tangent is symmetric, after a check that it has no entries outside a declared form."""
    first, second = np.random.default_rng(1).normal(size=(2, form.pattern.size))

    @jax.jit
    def compared(u):
        _, slope = jax.linearize(force, u)
        along, across = slope(first), slope(second)
        outside = along - times(form.force_and_tangent(force, u)[1], first)
        largest, size = jnp.abs(along).max(), jnp.linalg.norm(second) * jnp.linalg.norm(along)
        return jnp.abs(outside).max(), largest, jnp.abs(second @ along - first @ across), size

    symmetric = True
    for outside, largest, skew, size in map(compared, states):
        if declared and not outside <= tangent.AGREEMENT * largest:
            raise ValueError(f"{declared} does not fit its force: the derivative of the force has entries outside it.")
        symmetric &= bool(skew <= tangent.AGREEMENT * size)
    return symmetric
