"""Circular frequencies of small motions about a state of a problem."""

from collections.abc import Sequence
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import VectorLike
from study.algebra.jit import jit
from study.algebra.matrices import MatrixFree, dense
from study.algebra.sparse import SYMMETRY
from study.mechanics.definition import Problem
from study.mechanics.tangent import FINDABLE

#: Number of displacements along a motion at which frequencies are computed to find the highest one.
STIFFEST = 16
#: Imaginary part of a root, relative to the largest root, up to which it is round-off.
ROUND_OFF = 1e-9


@partial(jit, compiler=eqx.filter_jit)
def _stiffness(force, u):
    return jax.jacfwd(lambda u: force(u, jnp.zeros_like(u)))(u)


def frequencies(problem: Problem, u: VectorLike | None = None) -> np.ndarray | None:
    r"""Circular frequencies ω in ascending order, with K the tangent ∂p/∂u at ``u``, by default u₀.

    .. math::

        \det(\lambda^2 M + \lambda C + K) = 0, \quad \omega = |\lambda| \text{ where } \operatorname{Im} \lambda > 0

    Here C is the damping plus ∂p/∂u̇ at u̇ = 0. If C is symmetric and no mode flutters, the frequencies are the undamped
    ones, from det(K − ω² M) = 0: they equal |λ| for modal damping, and exist for overdamped modes too. Otherwise a mode
    that does not oscillate has the frequency zero. A mode without mass has an infinite
    frequency. A mode that grows instead of oscillating, with ω² < 0, has the frequency zero, or infinity if the mass is
    singular; gyroscopic forces are left out then.

    Returns
    -------
    numpy.ndarray or None
        Of shape (n,), and (1,) for one unknown; None for more than ``FINDABLE`` unknowns, since the matrices would be
        too large, or if the tangent is not finite.
    """
    n = np.size(problem.u0)
    if n > FINDABLE:
        return None
    problem, displacement = problem.at_time(0.0), np.asarray(problem.u0 if u is None else u, float)
    stiffness = np.asarray(_stiffness(problem.untitled().internal_force, displacement)).reshape(n, n)
    mass = np.eye(n) if problem.mass is None else np.asarray(dense(problem.mass, n))
    damping = _velocity_tangent(problem, displacement)
    if not (np.isfinite(stiffness).all() and np.isfinite(damping).all()):
        return None
    # a singular mass has no inverse; the eigenvalues of K⁻¹ M are 1/ω², zero for an infinite frequency
    if problem.massless:
        flexibility = np.linalg.lstsq(stiffness, mass, rcond=None)[0]
        periods_squared = np.clip(np.linalg.eigvals(flexibility).real, 0, None)
        with np.errstate(divide="ignore"):
            return np.sort(1 / np.sqrt(periods_squared))
    if np.abs(damping - damping.T).max() <= SYMMETRY * np.abs(damping).max():
        squares = _squares(mass, stiffness)
        if np.abs(squares.imag).max() <= ROUND_OFF * np.abs(squares).max():
            return np.sqrt(np.clip(squares.real, 0, None))
    lower = -np.linalg.solve(mass, np.concatenate([stiffness, damping], axis=1))
    roots = np.linalg.eigvals(np.concatenate([np.eye(n, 2 * n, n), lower]))
    # of a conjugate pair only one root counts; a root whose imaginary part is round-off does not oscillate
    oscillating = np.abs(roots[roots.imag > ROUND_OFF * np.abs(roots).max()])
    return np.sort(np.concatenate([np.zeros(n), oscillating]))[-n:]


def _squares(mass: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """ω² in ascending order from det(K − ω² M) = 0, complex for flutter; symmetric matrices take half of the time."""
    if np.abs(stiffness - stiffness.T).max() <= SYMMETRY * np.abs(stiffness).max():
        half = np.linalg.inv(np.linalg.cholesky(mass))
        return np.linalg.eigvalsh(half @ stiffness @ half.T)
    return np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)))


def _velocity_tangent(problem: Problem, u: np.ndarray) -> np.ndarray:
    """The damping plus ∂p/∂u̇ at displacement u and u̇ = 0, of shape (n, n)."""
    n = u.size
    viscosity = np.zeros((n, n))
    if problem.takes_velocity:
        tangent = jax.jacfwd(lambda v: problem.varying_force(jnp.asarray(u), v))(jnp.zeros(u.shape))
        viscosity = np.asarray(tangent).reshape(n, n)
    # a matrix-free damping is symmetric, as its solver needs
    if problem.damping is None or isinstance(problem.damping, MatrixFree):
        return viscosity
    return viscosity + np.asarray(dense(problem.damping, n))


@partial(jit, compiler=eqx.filter_jit)
def _row_sums(force, mass, displacements):
    """The largest row sum of ``|K|``, over the diagonal of the mass, at each displacement."""

    def largest(u):
        stiffness = jax.jacfwd(lambda u: force(u, jnp.zeros_like(u)))(u)
        return jnp.max(jnp.abs(stiffness.reshape(u.size, u.size)).sum(axis=1) / mass)

    return jax.lax.map(largest, displacements)


def highest_frequency(problem: Problem, displacements: Sequence[VectorLike]) -> float:
    """The highest circular frequency of small motions about the given displacements.

    It is computed at the ``STIFFEST`` displacements with the largest row sums of the tangent over the mass. It is NaN
    if the tangent is finite at none of them, or if the problem has more than ``FINDABLE`` unknowns.
    """
    n = np.size(problem.u0)
    if n > FINDABLE:
        return np.nan
    states, still = np.asarray(displacements, float), problem.at_time(0.0).untitled()
    mass = np.ones(n) if problem.mass is None else np.diag(np.asarray(dense(problem.mass, n)))
    row_sums = np.asarray(_row_sums(still.internal_force, np.where(mass == 0, np.inf, mass), states))
    stiffest = np.argsort(np.nan_to_num(row_sums))[-STIFFEST:]
    spectra = (frequencies(problem, states[place]) for place in stiffest)
    return max((float(spectrum[-1]) for spectrum in spectra if spectrum is not None), default=np.nan)
