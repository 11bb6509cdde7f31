"""Circular frequencies of small motions about a state of a problem."""

from collections.abc import Iterable
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import VectorLike
from study.algebra.jit import jit
from study.algebra.matrices import dense
from study.mechanics.definition import Problem
from study.mechanics.tangent import FINDABLE


@partial(jit, compiler=eqx.filter_jit)
def _stiffness(force, u):
    return jax.jacfwd(lambda u: force(u, jnp.zeros_like(u)))(u)


def frequencies(problem: Problem, u: VectorLike | None = None) -> np.ndarray | None:
    """Circular frequencies ω in ascending order, from det(K − ω² M) = 0 with K the tangent at ``u``, by default u₀.

    A mode without mass has an infinite frequency. A mode that grows instead of oscillating, with ω² < 0, has the
    frequency zero, or infinity if the mass is singular.

    Returns
    -------
    numpy.ndarray or None
        Of shape (n,), and (1,) for one unknown; None for more than ``FINDABLE`` unknowns, since the matrices would be
        too large, or if the tangent is not finite.
    """
    n = np.size(problem.u0)
    if n > FINDABLE:
        return None
    at = np.asarray(problem.u0 if u is None else u, float)
    stiffness = np.asarray(_stiffness(problem.untitled().at_time(0.0).internal_force, at)).reshape(n, n)
    mass = np.eye(n) if problem.mass is None else np.asarray(dense(problem.mass, n))
    if not np.isfinite(stiffness).all():
        return None
    # a singular mass has no inverse; the eigenvalues of K⁻¹ M are 1/ω², zero for an infinite frequency
    if problem.massless:
        flexibility = np.linalg.lstsq(stiffness, mass, rcond=None)[0]
        periods_squared = np.clip(np.linalg.eigvals(flexibility).real, 0, None)
        with np.errstate(divide="ignore"):
            return np.sort(1 / np.sqrt(periods_squared))
    return np.sqrt(np.clip(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real), 0, None))


def highest_frequency(problem: Problem, displacements: Iterable[VectorLike]) -> float:
    """The highest circular frequency of small motions about the given displacements.

    It is NaN if the tangent is finite at none of them, or if the problem has more than ``FINDABLE`` unknowns.
    """
    found = (frequencies(problem, u) for u in displacements)
    return max((float(one[-1]) for one in found if one is not None), default=np.nan)
