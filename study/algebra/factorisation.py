"""Factorisations of sparse matrices by LAPACK, CHOLMOD and SuperLU, kept while the matrix stays the same.

In the reverse Cuthill-McKee order of the unknowns, the matrix of a beam, a frame or a slender mesh has a narrow band,
for which LAPACK's banded Cholesky factorisation is the fastest. CHOLMOD factorises the matrix of a wide mesh. It orders
the unknowns for little fill-in, and a factor that is overwritten keeps its order. SuperLU factorises a matrix that is
not symmetric, or not positive definite, as at a snap-through. SuperLU also replaces CHOLMOD if CHOLMOD is not
installed.

References
----------
E. Cuthill, J. McKee, Reducing the bandwidth of sparse symmetric matrices, Proc. 24th ACM National Conf., 1969, 157-172.
Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse Cholesky factorization and
update/downdate, ACM Trans. Math. Softw. 35(3), 2008, 22:1-22:14.
"""

import abc
from functools import lru_cache
from importlib.util import find_spec
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import scipy

from study.algebra.arrays import ScipySparse
from study.algebra.sparse import Pattern

#: Largest half bandwidth at which LAPACK is faster than CHOLMOD, whatever the number of unknowns.
WIDEST_BAND = 100

#: Number of factorisations that are kept: two for a step with two sub-steps, and one for the mass matrix.
KEPT = 3


class NotPositiveDefiniteError(Exception):
    """A matrix has no Cholesky factorisation."""


def is_positive_definite(matrix: ScipySparse) -> bool:
    """Whether a symmetric matrix is positive definite, by the signs of its pivots."""
    try:
        factor = scipy.sparse.linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:  # exactly singular
        return False
    return bool((factor.perm_r == factor.perm_c).all() and (factor.U.diagonal() > 0).all())


class Method(abc.ABC):
    """A way to factorise matrices of one pattern."""

    @abc.abstractmethod
    def factor(self, values: np.ndarray, spare: Any) -> Any:
        """Factor of the matrix with these values (entries,). ``spare``, an old factor or None, may be overwritten."""

    @abc.abstractmethod
    def solution(self, factor: Any, rhs: np.ndarray) -> np.ndarray:
        """The solution (n,) for a right side (n,)."""


class BandCholesky(Method):
    """LAPACK's Cholesky factorisation of a band matrix, with the unknowns in the order ``order``."""

    def __init__(self, pattern: Pattern, order: np.ndarray, half_bandwidth: int):
        self.order, self.place = order, np.argsort(order)
        rows, columns = self.place[pattern.rows], self.place[pattern.columns]
        low, high = np.minimum(rows, columns), np.maximum(rows, columns)
        self.shape = pattern.size, half_bandwidth + 1
        # flat index of the entry (high, low) in LAPACK's band storage of the lower triangle
        self.entry = low * (half_bandwidth + 1) + (high - low)

    def factor(self, values, spare):
        band = np.empty(self.shape) if spare is None else spare.T
        band.fill(0.0)
        band.reshape(-1)[self.entry] = values
        factor, failed = scipy.linalg.lapack.dpbtrf(band.T, lower=1, overwrite_ab=1)
        if failed:
            raise NotPositiveDefiniteError
        return factor

    def solution(self, factor, rhs):
        return scipy.linalg.lapack.dpbtrs(factor, rhs[self.order], lower=1, overwrite_b=1)[0][self.place]


class Cholmod(Method):
    """CHOLMOD's sparse Cholesky factorisation; with a spare factor, the symbolic analysis is not repeated."""

    def __init__(self, pattern: Pattern):
        from cvxopt import cholmod, matrix, spmatrix  # cvxopt is installed with an extra of the package

        self.cholmod, self.matrix = cholmod, matrix
        self.entries = spmatrix(1.0, pattern.rows.tolist(), pattern.columns.tolist(), (pattern.size,) * 2)

    def factor(self, values, spare):
        if not np.isfinite(values).all():
            raise NotPositiveDefiniteError
        self.entries.V = self.matrix(values)
        factor = self.cholmod.symbolic(self.entries) if spare is None else spare
        try:
            self.cholmod.numeric(self.entries, factor)
        except ArithmeticError as error:
            raise NotPositiveDefiniteError from error
        return factor

    def solution(self, factor, rhs):
        x = self.matrix(rhs)
        self.cholmod.solve(factor, x)
        return np.array(x).ravel()


class SuperLU(Method):
    """SciPy's sparse LU factorisation with pivoting.

    For a matrix that is singular or not finite, the factor is None and the solution NaN.
    """

    def __init__(self, pattern: Pattern):
        self.pattern = pattern

    def factor(self, values, spare):
        pattern = self.pattern
        matrix = scipy.sparse.csc_array((values, pattern.rows, pattern.starts), (pattern.size,) * 2)
        if pattern.symmetric:
            matrix = scipy.sparse.csc_array(matrix + scipy.sparse.tril(matrix, -1).T)
        if not np.isfinite(values).all():
            return None
        try:
            return scipy.sparse.linalg.splu(matrix, permc_spec="MMD_AT_PLUS_A")
        except RuntimeError:  # exactly singular
            return None

    def solution(self, factor, rhs):
        return np.full_like(rhs, np.nan) if factor is None else factor.solve(rhs)


def _best(pattern: Pattern) -> Method:
    """The fastest method for matrices of a pattern; symmetric matrices are assumed positive definite."""
    if not pattern.symmetric:
        return SuperLU(pattern)
    graph = scipy.sparse.csr_array((np.ones(len(pattern.rows)), (pattern.rows, pattern.columns)), (pattern.size,) * 2)
    order = scipy.sparse.csgraph.reverse_cuthill_mckee(scipy.sparse.csr_array(graph + graph.T), symmetric_mode=True)
    place = np.argsort(order)
    half_bandwidth = int(np.abs(place[pattern.rows] - place[pattern.columns]).max())
    if half_bandwidth <= WIDEST_BAND:
        return BandCholesky(pattern, order, half_bandwidth)
    return Cholmod(pattern) if find_spec("cvxopt") else SuperLU(pattern)


class Kept(NamedTuple):
    """A factorisation that is kept: sum and values of the entries of the matrix, the method, and the factor."""

    total: float
    values: np.ndarray
    method: Method
    factor: Any


class Factorisations:
    """Solver of systems with matrices of one pattern; it keeps the factors used last, for matrices that occur again."""

    def __init__(self, pattern: Pattern):
        self._methods = _best(pattern), SuperLU(pattern)
        self._kept: list[Kept] = []
        self._alone = Lock()
        #: Number of factorisations so far.
        self.count = 0

    def solved(self, values: np.ndarray, rhs: np.ndarray) -> np.ndarray:
        """The solution (n,) with the matrix of these values (entries,); NaN if the matrix is singular or not finite."""
        with self._alone:  # runs in other threads use the same factors
            kept = self._kept_for(values.astype(np.float64, copy=False))
            x = kept.method.solution(kept.factor, rhs.astype(np.float64))
        return x.astype(rhs.dtype, copy=False)

    def _kept_for(self, values: np.ndarray) -> Kept:
        total = float(values.sum())
        numbers = (
            k for k, kept in enumerate(self._kept) if kept.total == total and np.array_equal(kept.values, values)
        )
        number = next(numbers, None)
        if number is not None:
            kept = self._kept.pop(number)
        else:
            kept = self._factorised(values, total, self._kept.pop() if len(self._kept) == KEPT else None)
        self._kept.insert(0, kept)
        return kept

    def _factorised(self, values: np.ndarray, total: float, oldest: Kept | None) -> Kept:
        self.count += 1
        best, general = self._methods
        values = values.copy()
        spare = oldest.factor if oldest is not None and oldest.method is best else None
        try:
            return Kept(total, values, best, best.factor(values, spare))
        except NotPositiveDefiniteError:
            return Kept(total, values, general, general.factor(values, None))


@lru_cache(maxsize=8)
def factorisations(pattern: Pattern) -> Factorisations:
    """The solver for matrices of a pattern; the solvers of the eight patterns used last are kept."""
    return Factorisations(pattern)
