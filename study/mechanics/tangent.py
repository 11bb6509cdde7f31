"""The tangent ∂p/∂u by automatic differentiation, in the declared or detected form."""

from collections.abc import Callable
from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import Matrix, Vector
from study.algebra.counting import count, counting
from study.algebra.matrices import Banded, MatrixFree, times
from study.algebra.scalars import is_whole
from study.mechanics.sparse_tangent import SparseTangent

#: Declarable forms of a tangent. A whole number is a half bandwidth.
FORMS: dict[str, int | str] = {"diagonal": 0, "tridiagonal": 1, "dense": "dense", "matrix_free": "matrix_free"}

#: Largest number of unknowns for which the form is found from the full tangent. The form of a larger tangent, if it is
#: not declared, is diagonal, tridiagonal or sparse.
FINDABLE = 1000

#: Number of vectors that estimate the diagonal of a matrix-free tangent.
PROBES = 8

#: Largest number of products with the tangent that are written out one by one.
WRITTEN_OUT = 3

#: Candidate distances from u₀ at which the tangent is examined, relative to the larger of max |u₀| and one. The first
#: distance with a finite tangent is used.
PROBED = (0.05, 1e-3, 1e-6, 1e-9)

#: Distance from u₀, relative to the larger of max |u₀| and one, within which springs have not yet yielded.
ELASTIC = 1e-6

#: Distances from u₀, relative to the larger of max |u₀| and one, at which contacts have closed. The first one with a
#: finite tangent is used.
FAR = (1e3, 30.0, 1.0)

#: Relative tolerance between the true tangent and the tangent in the declared form, for round-off.
AGREEMENT = 1e-8


def _directions(count: int, n: int):
    """Vectors (count, n) of zeros and ones: vector k has ones at k, k + count, k + 2 count, ..."""
    return (jnp.arange(n, dtype=jnp.int32)[None] % count == jnp.arange(count, dtype=jnp.int32)[:, None]).astype(float)


def _bands(slope: Callable, half_bandwidth: int, n: int) -> Banded:
    """All bands from 2k + 1 products: columns 2k + 1 apart share no row (Curtis, Powell and Reid, 1974)."""
    count = 2 * half_bandwidth + 1
    directions = _directions(count, n)
    # few products are written out one by one, because XLA then merges their loops
    place, offset = jnp.arange(n, dtype=jnp.int32), range(-half_bandwidth, half_bandwidth + 1)
    if count <= WRITTEN_OUT:
        products = [slope(d) for d in directions]
        return Banded(tuple(jax.lax.select_n((place + d) % count, *products) for d in offset))
    column = (place[None] + jnp.asarray(offset, dtype=jnp.int32)[:, None]) % count
    return Banded(jnp.take_along_axis(jax.vmap(slope)(directions), column, axis=0))


#: Form of a tangent: a half bandwidth, ``"dense"``, ``"matrix_free"`` or sparse; None for one unknown.
FormOfTangent: TypeAlias = int | str | SparseTangent | None


def force_and_tangent(force: Callable, u: Vector, form: FormOfTangent) -> tuple[Vector, Matrix]:
    """p(u) and ∂p/∂u: a number for one unknown, otherwise a matrix in the given form.

    Parameters
    ----------
    force
        p as a function of u.
    u
        Displacement, () or (n,).
    form
        Half bandwidth, ``"dense"``, ``"matrix_free"`` or sparse; None for one unknown.
    """
    with counting() as counts:
        value, tangent = _force_and_tangent(force, u, form)
    count(forces=counts.forces, tangents=counts.forces)
    return value, tangent


def _force_and_tangent(force: Callable, u: Vector, form: FormOfTangent) -> tuple[Vector, Matrix]:
    if jnp.ndim(u) == 0:
        return jax.jvp(force, (u,), (jnp.ones_like(u),))
    if isinstance(form, SparseTangent):
        return form.force_and_tangent(force, u)
    if form == "dense":
        tangent, value = jax.jacfwd(lambda x: (force(x),) * 2, has_aux=True)(u)
        return value, tangent
    value, slope = jax.linearize(force, u)
    n = len(u)
    if form == "matrix_free":
        directions = _directions(PROBES, n)
        return value, MatrixFree(slope, jnp.sum(directions * jax.vmap(slope)(directions), axis=0))
    if form == 0:
        return value, slope(jnp.ones_like(u))
    return value, _bands(slope, form, n)  # type: ignore[arg-type]


def probed_states(force: Callable, u0: np.ndarray, title: str) -> list[np.ndarray]:
    """Displacements at which the derivative of the force is examined, and is finite.

    Two of them lie around u₀, scattered so that no entry of the derivative is zero by chance. Springs may already
    yield or slip there. A third displacement closer to u₀, u₀ itself and zero show how springs couple unknowns before
    they yield, and displacements far from u₀ in opposite directions how they do once gaps between any two unknowns have
    closed; these are left out where the derivative is not finite.
    """
    random = np.random.default_rng(0)
    scatter, directions = random.uniform(0.5, 1.5, (2, len(u0))), random.uniform(-1.0, 1.0, (2, len(u0)))
    slope = jax.jit(lambda u: jax.jvp(force, (u,), (jnp.ones_like(u),))[1])
    scale = max(np.abs(u0).max(), 1.0)
    # the smallest distance is far below any displacement, whatever its units
    for size in np.array(PROBED) * scale:
        around = [u0 + size * scatter[0], u0 - size / 2 * scatter[1]]
        if all(np.isfinite(slope(u)).all() for u in around):
            close = [u0 + ELASTIC * scale * scatter[0], u0, np.zeros_like(u0)]
            states = around + [u for u in close if np.isfinite(slope(u)).all()]
            for direction in (*directions, *-directions):
                distant = (u0 + size * scale * direction for size in FAR)
                states += [u for u in distant if np.isfinite(slope(u)).all()][:1]
            return states
    raise ValueError(f"the derivative of the force of '{title}' is not finite near u0.")


def detected_form(force: Callable, u0: np.ndarray, massless: bool, title: str) -> int | str:
    """Form of the tangent, from a few displacements: a half bandwidth, or ``"dense"``; up to ``FINDABLE`` unknowns.

    It is ``"dense"`` if the half bandwidth exceeds a quarter of the number of unknowns. It is ``"dense"`` too if the
    mass is singular and the tangent has a zero on its diagonal, because bands are eliminated without pivoting.

    Raises
    ------
    ValueError
        If the derivative is not finite near u₀.
    """
    n = len(u0)
    jacobian = jax.jit(jax.jacfwd(force))
    entries = sum(np.abs(np.asarray(jacobian(u))) for u in probed_states(force, u0, title))
    rows, columns = np.nonzero(entries)
    half_bandwidth = int(np.abs(rows - columns).max(initial=0))
    if massless and not np.diagonal(entries).all():
        return "dense"
    # at a half bandwidth of n/4, the elimination of blocks takes about as long as LAPACK's of the full matrix
    return half_bandwidth if 4 * half_bandwidth <= n else "dense"


def form_named(declared: int | str, n: int, title: str) -> int | str:
    """The form that a problem declares for its n unknowns: a half bandwidth, ``"dense"`` or ``"matrix_free"``.

    Raises
    ------
    ValueError
        If there is no such form.
    """
    declared = int(declared) if isinstance(declared, np.integer) else declared
    known = FORMS.get(declared, declared) if isinstance(declared, str) else declared
    if isinstance(declared, str) and isinstance(known, int):
        known = min(known, n - 1)
    is_width = is_whole(known, 0) and int(known) < n
    if not is_width and known not in ("dense", "matrix_free"):
        raise ValueError(
            f"tangent={declared!r} of '{title}': give one of {', '.join(FORMS)}, or the half bandwidth as a "
            f"whole number below {n}."
        )
    return known


def check_declared_form(force: Callable, u0: np.ndarray, declared: int | str, title: str) -> None:
    """Refuse a declared form that cannot hold the derivative of the force, as ``"dense"`` always can.

    Raises
    ------
    ValueError
        If the product of the tangent with a random direction differs from the derivative along it, if a matrix-free
        tangent is not symmetric, or if the derivative is not finite near u₀.
    """
    known = form_named(declared, len(u0), title)
    first, second = np.random.default_rng(1).normal(size=(2, len(u0)))
    if known == "matrix_free":
        reason = "it is not symmetric, as conjugate gradients need"
    else:
        reason = "the derivative of the force has entries outside it"

    @jax.jit
    def misfit(u):
        _, slope = jax.linearize(force, u)
        along = slope(first)
        if known == "matrix_free":
            return jnp.abs(second @ along - first @ slope(second)), jnp.linalg.norm(second) * jnp.linalg.norm(along)
        _, tangent = force_and_tangent(force, u, known)
        return jnp.abs(times(tangent, first) - along).max(), jnp.abs(along).max()

    for u in probed_states(force, u0, title):
        wrong, scale = misfit(u)
        if not wrong <= AGREEMENT * scale:
            raise ValueError(f"tangent={declared!r} does not fit the force of '{title}': {reason}.")
