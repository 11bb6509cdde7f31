"""The tangent ∂p/∂u by automatic differentiation, in the structure that a problem declares or that is found."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.matrices import SMALL, Banded, MatrixFree, times

#: What a problem may call the structure of its tangent; a whole number stands for a half bandwidth.
STRUCTURES: dict[str, int | str] = {"diagonal": 0, "tridiagonal": 1, "dense": "dense", "matrix_free": "matrix_free"}

#: Unknowns up to which a structure is found by looking at the whole tangent.
FINDABLE = 1000

#: Seeds by which the diagonal of a matrix-free tangent is probed.
PROBES = 8

#: Products with the tangent that are written out one by one.
WRITTEN_OUT = 3

#: Distances from the initial displacement at which a tangent is looked at, the first that does.
PROBED = (0.05, 1e-3, 1e-6, 1e-9)

#: Entries of the true tangent may differ from those of the structure by this part, for round-off.
AGREEMENT = 1e-8


def _directions(count: int, n: int):
    """Vectors (count, n) of zeros, and of ones at every place that leaves the vector's number over ``count``."""
    return (jnp.arange(n, dtype=jnp.int32)[None] % count == jnp.arange(count, dtype=jnp.int32)[:, None]).astype(float)


def _bands(slope: Callable, half_bandwidth: int, n: int) -> Banded:
    """All bands from 2k + 1 products: columns that far apart do not meet in any row (Curtis, Powell and Reid, 1974)."""
    count = 2 * half_bandwidth + 1
    directions = _directions(count, n)
    # a few are written out, so that the compiler merges their loops
    place, offset = jnp.arange(n, dtype=jnp.int32), range(-half_bandwidth, half_bandwidth + 1)
    if count <= WRITTEN_OUT:
        products = [slope(d) for d in directions]
        return Banded(tuple(jax.lax.select_n((place + d) % count, *products) for d in offset))
    column = (place[None] + jnp.asarray(offset, dtype=jnp.int32)[:, None]) % count
    return Banded(jnp.take_along_axis(jax.vmap(slope)(directions), column, axis=0))


def force_and_tangent(force: Callable, u, structure: int | str | None):
    """p(u) and ∂p/∂u: a number for one unknown, else in the form of the structure."""
    if jnp.ndim(u) == 0:
        return jax.jvp(force, (u,), (jnp.ones_like(u),))
    if structure == "dense":
        tangent, value = jax.jacfwd(lambda x: (force(x),) * 2, has_aux=True)(u)
        return value, tangent
    value, slope = jax.linearize(force, u)
    n = len(u)
    if structure == "matrix_free":
        directions = _directions(PROBES, n)
        return value, MatrixFree(slope, jnp.sum(directions * jax.vmap(slope)(directions), axis=0))
    if structure == 0:
        return value, slope(jnp.ones_like(u))
    return value, _bands(slope, structure, n)  # type: ignore[arg-type]


def _two_states(force: Callable, u0: np.ndarray, title: str) -> list[np.ndarray]:
    """Displacements near the initial ones at which the force has a derivative, and no entry of it is zero by chance."""
    scatter = np.random.default_rng(0).uniform(0.5, 1.5, (2, len(u0)))
    slope = jax.jit(lambda u: jax.jvp(force, (u,), (jnp.ones_like(u),))[1])
    # the least that is tried is far below any displacement, whatever its units
    for size in np.array(PROBED) * max(np.abs(u0).max(), 1.0):
        states = [u0 + size * scatter[0], u0 - size / 2 * scatter[1]]
        if all(np.isfinite(slope(u)).all() for u in states):
            return states
    raise ValueError(f"the derivative of the force of '{title}' is not finite near u0.")


def found(force: Callable, u0: np.ndarray, massless: bool, title: str) -> int | str:
    """The structure that the tangent has at two displacements about u₀: a half bandwidth, or dense.

    Dense, too, where an unknown has neither mass nor stiffness of its own: bands are eliminated without pivoting.
    """
    n = len(u0)
    if n <= SMALL:
        return "dense"
    if n > FINDABLE:
        raise ValueError(
            f"'{title}' has {n} unknowns, too many to find the structure of its tangent: declare it with "
            f"Problem(tangent=...), one of {', '.join(STRUCTURES)} or a half bandwidth."
        )
    jacobian = jax.jit(jax.jacfwd(force))
    entries = sum(np.abs(np.asarray(jacobian(u))) for u in _two_states(force, u0, title))
    rows, columns = np.nonzero(entries)
    half_bandwidth = int(np.abs(rows - columns).max(initial=0))
    if massless and not np.diagonal(entries).all():
        return "dense"
    # an elimination of blocks takes about as long as LAPACK's of the whole at a quarter
    return half_bandwidth if 4 * half_bandwidth <= n else "dense"


def checked(force: Callable, u0: np.ndarray, structure: int | str, title: str) -> int | str:
    """The declared structure, once its tangent is seen to be that of the force.

    Raises
    ------
    ValueError
        If there is no such structure, or the true derivative along a random direction is another.
    """
    structure = int(structure) if isinstance(structure, np.integer) else structure
    known = STRUCTURES.get(structure, structure) if isinstance(structure, str) else structure
    if isinstance(structure, str) and isinstance(known, int):
        known = min(known, len(u0) - 1)
    is_width = isinstance(known, int) and not isinstance(known, bool) and 0 <= known < len(u0)
    if not is_width and known not in ("dense", "matrix_free"):
        raise ValueError(
            f"tangent={structure!r} of '{title}': give one of {', '.join(STRUCTURES)}, or the half bandwidth as a "
            f"whole number below {len(u0)}."
        )
    if known == "dense":
        return known
    one, other = np.random.default_rng(1).normal(size=(2, len(u0)))
    if known == "matrix_free":
        reason = "it is not symmetric, as conjugate gradients need"
    else:
        reason = "the derivative of the force has entries beyond it"

    @jax.jit
    def misfit(u):
        _, slope = jax.linearize(force, u)
        along = slope(one)
        if known == "matrix_free":
            return jnp.abs(other @ along - one @ slope(other)), jnp.linalg.norm(other) * jnp.linalg.norm(along)
        _, tangent = force_and_tangent(force, u, known)
        return jnp.abs(times(tangent, one) - along).max(), jnp.abs(along).max()

    for u in _two_states(force, u0, title):
        wrong, scale = misfit(u)
        if not wrong <= AGREEMENT * scale:
            raise ValueError(f"tangent={structure!r} does not fit the force of '{title}': {reason}.")
    return known
