"""The stability limit of a scheme, compared with the step of a run for small motions about its start.

Small motions about the start obey M ü + C u̇ + K u = 0, where C and K are ∂p/∂u̇ and ∂p/∂u at t = 0, u₀ and u̇₀ plus the
constant matrices of the problem. If u = 0 is an equilibrium, a motion with one unknown or from rest passes near it, and
small motions about u = 0 count too: a spring that yields or softens is stiffest there.

A mode φ, with (λ² M + λ C + K) φ = 0, is an oscillator ü + c u̇ + k u = 0 with k = φ*Kφ/φ*Mφ and c = φ*Cφ/φ*Mφ. The
imaginary part of c is gyroscopic. A step is beyond the limit if the amplification matrix of the scheme on one of these
oscillators has an eigenvalue above one in size. This is exact if C is modal or gyroscopic with equal stiffness in all
directions, and an estimate otherwise. Negative stiffness and negative damping count as zero, because the motion itself
grows then.

Up to ``FEW`` unknowns all modes are computed. For more unknowns, Lanczos' method finds the direction of largest k and
the direction of largest c, which need symmetric matrices; gyroscopic terms are not considered. The largest k and c of
symmetric matrices are never overestimated, and usually underestimated by less than a percent. A force that JAX cannot
differentiate, such as one that calls back to Python, is not checked.
"""

import math
from functools import cache, partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.flatten_util import ravel_pytree

from study.algebra.elimination import solve
from study.algebra.jit import jit
from study.algebra.matrices import Banded, MatrixFree, dense, times
from study.marching.program import unlabelled
from study.mechanics.definition import Problem
from study.mechanics.state import Phase
from study.observer.base import Reduction
from study.scheme.base import Scheme
from study.scheme.contract import started, stepped
from study.words import step_size

#: Largest number of unknowns for which all modes are computed.
FEW = 8

#: Number of products with K, and with C, for more unknowns.
PRODUCTS = 24

#: Relative excess of a step over the limit, and relative size of gyroscopic terms, that count as round-off.
ROUND_OFF = 1e-5

#: Largest log ρ that counts as round-off, for a spectral radius ρ.
GROWTH = 1e-6

#: Factor by which a scheme that is unstable at every step must amplify a motion during a run to be reported.
AMPLIFIED = 2.0

#: Fraction of the undamped limit up to which (ω + c) Δt is stable for every scheme with a limit.
SAFE = 0.2

#: Largest force at u = 0, relative to the force at u₀, with which u = 0 is an equilibrium.
EQUILIBRIUM = 1e-8

#: Ratio of c² to k from which the limit is one of cΔt/m, because the faster root of the mode is then c to one percent.
HEAVY = 100.0

#: Number of squarings of an amplification matrix, from whose size its spectral radius follows.
SQUARINGS = 30

#: Numbers of halvings of an interval of eigenvalues, and of inverse iterations of the vector. The vector is refined to
#: round-off: its error shrinks by the distance of the shift, over that of the next eigenvalue, in each iteration.
BISECTIONS, INVERSE_ITERATIONS = 50, 4

#: Numbers of oscillators in one call of the compiled function, for few and for many.
TILES = (64, 2048)

#: Parts of the step among which its stable part is sought, number of refinements, and number of parts in a refinement.
PARTS, REFINEMENTS, REFINED = np.geomspace(1e-6, 1.0, 1024), 2, 1024


class SmallMotion(NamedTuple):
    """Matrices of small motions about the start and, unless the problem is linear, about u = 0.

    Their shape is (*lanes, places, n, n). ``damping`` is None without forces of the velocity.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray | None = None

    def matrices_of_lane(self, lane: int) -> "SmallMotion":
        """The matrices of one lane, or of the single run."""
        return SmallMotion(*(x.reshape(-1, *x.shape[-3:])[lane] for x in self if x is not None))


class AtStart(Reduction):
    """The matrices of :class:`SmallMotion`, computed by the program of the run at its start."""

    variables = {f"{name}_at_start": {} for name in SmallMotion._fields}

    def start(self, problem, state):
        return _linearised(problem, jnp.asarray(state.u), jnp.asarray(state.v))

    def update(self, carried, problem, state, t, effort):
        return carried

    def result(self, carried, problem, state):
        return {name: value for name, value in zip(self.variables, carried, strict=True) if value is not None}


def has_limit(scheme: Scheme, problem: Problem) -> bool:
    """Whether a step of the scheme may be beyond a limit.

    An unknown without mass has no finite frequency to check. If the scheme is exact for the stiffness of a problem, the
    limit of the remaining force is not known.
    """
    if problem.massless or (scheme.is_exact_for_stiffness and problem.stiffness is not None):
        return False
    limit = scheme.stability_limit
    return limit is None or limit < math.inf


def taken_from(values: dict[str, np.ndarray]) -> SmallMotion:
    """The matrices of :class:`AtStart`, removed from the values of a run."""
    return SmallMotion(*(values.pop(name, None) for name in AtStart.variables))  # type: ignore[arg-type]


def at_start(problem: Problem) -> SmallMotion:
    """Small motions about the start of a problem."""
    start = Phase(jnp.asarray(problem.u0), jnp.asarray(problem.v0))
    here = problem.at_time(0.0).committed(*start)
    mass, stiffness, damping = jax.tree.map(np.asarray, _linearised(here, *start))
    return SmallMotion(mass, stiffness, damping)


def _linearised(problem: Problem, u, v) -> tuple:
    """The matrices of :class:`SmallMotion`; a stiffness of zero if JAX cannot differentiate the force."""
    try:
        return _about_places(problem, u, v)
    except (TypeError, ValueError):  # a force that calls back to Python, or has a derivative in reverse mode only
        return jnp.ones((1, 1, 1)), jnp.zeros((1, 1, 1)), None


def _about_places(problem: Problem, u, v) -> tuple:
    """The matrices, where K and C about u = 0 are zero if that is no equilibrium or need not be passed."""
    places: tuple = (u, v, problem.history), (jnp.zeros_like(u), jnp.zeros_like(v), problem.at_rest().history)
    stacked = jax.tree.map(lambda *matrices: jnp.stack(matrices), *(places[:1] if problem.linear else places))
    mass, *tangents = lax.map(lambda place: _matrices(problem.remembering(place[2]), *place[:2]), stacked)
    if not problem.linear:
        pull, at_zero = (jnp.abs(problem.at_rest().static_force(x)).max() for x in (u, jnp.zeros_like(u)))
        passed = (at_zero <= EQUILIBRIUM * pull) & ((u.size == 1) | ~v.any())
        tangents = [None if x is None else x.at[1].set(jnp.where(passed, x[1], 0.0)) for x in tangents]
    return mass, *tangents


def _matrices(problem: Problem, u, v) -> tuple:
    n = u.size
    force_of_u = None if problem.linear else lambda u: problem.varying_force(u, v)
    force_of_v = (lambda v: problem.varying_force(u, v)) if problem.takes_velocity else None
    if n <= FEW:
        matrices = [dense(1.0 if problem.mass is None else problem.mass, n), _full(force_of_u, u, problem.stiffness)]
        return *matrices, _full(force_of_v, v, problem.damping) if problem.damped else None
    products = [partial(_times, force_of_u, u, problem.stiffness)]
    if problem.damped:
        products.append(partial(_times, force_of_v, v, problem.damping))
    vectors = [_highest(problem, product, n) for product in products]
    sizes = [jnp.diag(jnp.stack([x @ product(x) for x in vectors])) for product in products]
    return jnp.eye(len(vectors)), sizes[0], sizes[1] if problem.damped else None


def _full(force, at, matrix):
    """∂(force)/∂x plus a matrix, as a full matrix."""
    n = at.size
    whole = jnp.zeros((n, n)) if force is None else jax.jacfwd(force)(at).reshape(n, n)
    if matrix is None:
        return whole
    return whole + (jax.vmap(matrix.product)(jnp.eye(n)).T if isinstance(matrix, MatrixFree) else dense(matrix, n))


def _times(force, at, matrix, x):
    """Product of a vector with ∂(force)/∂x plus a matrix."""
    along = 0.0 if force is None else jax.jvp(force, (at,), (x,))[1]
    return along if matrix is None else along + times(matrix, x)


def _highest(problem: Problem, product, n: int):
    """The vector of unit mass in the Krylov space of a product that maximises it, by Lanczos' method."""
    mass = 1.0 if problem.mass is None else problem.mass

    def unit(x):
        size = jnp.sqrt(x @ times(mass, x))
        return x / jnp.where(size > 0, size, 1.0), size

    def iteration(carry, _):
        before, q, b = carry
        w = product(q)
        a = q @ w
        following, b_next = unit(solve(mass, w) - a * q - b * before)
        return (q, following, b_next), (q, a, b_next)

    start = jnp.asarray(np.random.default_rng(0).normal(size=n))
    _, (basis, a, b) = lax.scan(
        iteration, (jnp.zeros_like(start), unit(start)[0], jnp.zeros(())), length=min(n, PRODUCTS)
    )
    return unit(_highest_of_tridiagonal(a, b[:-1]) @ basis)[0]


def _highest_of_tridiagonal(a, b):
    """Eigenvector of the largest eigenvalue of the symmetric matrix with the diagonal a and b next to it.

    The eigenvalue is found by bisection, the vector by inverse iteration. LAPACK would be called for each lane, and
    many calls in several threads wait for one another.
    """
    apart = jnp.abs(jnp.append(b, 0.0)) + jnp.abs(jnp.append(0.0, b))
    high = (a + apart).max()
    scale = jnp.maximum(jnp.abs(a) + apart, 1e-300).max()

    def is_above(x):
        """Whether x is above all eigenvalues: all pivots of the matrix minus x are negative."""

        def pivot(before, row):
            diagonal, square = row
            now = diagonal - x - square / before
            return now, now < 0

        return lax.scan(pivot, jnp.full_like(x, -jnp.inf), (a, jnp.append(0.0, b) ** 2))[1].all()

    def halved(i, ends):
        low, high = ends
        middle = (low + high) / 2
        above = is_above(middle)
        return jnp.where(above, low, middle), jnp.where(above, middle, high)

    _, above = lax.fori_loop(0, BISECTIONS, halved, (a.max(), high))
    shift = above + 1e-9 * scale
    bands = Banded(jnp.stack([jnp.append(0.0, -b), shift - a, jnp.append(-b, 0.0)]))

    def inverse(i, x):
        x = solve(bands, x)
        return x / jnp.linalg.norm(x)

    return lax.fori_loop(0, INVERSE_ITERATIONS, inverse, jnp.ones_like(a))


def amplification_matrix(scheme: Scheme, problem: Problem, dt) -> jax.Array:
    """Derivative of a step on a linear problem with respect to the scheme's whole state, of shape (m, m).

    Multi-step schemes, whose state holds their history, appear in companion form.
    """
    # the map is linear, so its derivative is the same at any state; discrete gradients divide by the change of the
    # displacement in a step, so the state must move in a step of any size
    unit = jnp.ones(np.shape(problem.u0))
    flat, unflatten = ravel_pytree(started(scheme, problem, unit, unit, dt)[0])

    def step(flat):
        return ravel_pytree(stepped(scheme, problem, unflatten(flat), 0.0, dt)[0])[0]

    return jax.jacfwd(step)(flat)


def _pull(k, u):
    return k * u


def _potential(k, u):
    return 0.5 * k * jnp.vdot(u, u)


@cache
def _oscillator(gyroscopic: bool) -> Problem:
    """A mode: one unknown, or two that stand for its real and its imaginary part."""
    u0, damping = (np.ones(2), np.ones((2, 2))) if gyroscopic else (1.0, 1.0)
    return Problem(eqx.Partial(_pull, 1.0), u0, potential=eqx.Partial(_potential, 1.0), damping=damping)


@partial(jit, compiler=eqx.filter_jit)
def _compiled_growth(scheme: Scheme, gyroscopic: bool, k, c_real, c_imaginary):
    def growth(k, a, b):
        problem = eqx.tree_at(
            lambda p: (p.force.args, p.potential.args, p.damping),
            _oscillator(gyroscopic),
            ((k,), (k,), jnp.array([[a, -b], [b, a]]) if gyroscopic else a),
        )

        def squared(i, carry):
            matrix, total = carry
            size = jnp.maximum(jnp.abs(matrix).max(), 1e-300)
            matrix = matrix / size
            return matrix @ matrix, total + jnp.log(size) * 0.5**i

        return lax.fori_loop(0, SQUARINGS, squared, (amplification_matrix(scheme, problem, jnp.ones(())), 0.0))[1]

    return jax.vmap(growth)(k, c_real, c_imaginary)


@jax.enable_x64(True)
def _growth(scheme: Scheme, k: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The logarithm of the spectral radius on oscillators with the given k and c, with Δt = 1, of shape (points,)."""
    points = len(k)
    tile = TILES[points > TILES[0]]
    columns = [np.pad(x, (0, -points % tile)).reshape(-1, tile) for x in (k, c.real, c.imag)]
    gyroscopic = bool(c.imag.any())
    tiles = [_compiled_growth(unlabelled(scheme), gyroscopic, *tile) for tile in zip(*columns, strict=True)]
    return np.concatenate([np.zeros(0), *tiles])[:points]


def _modes(motion: SmallMotion) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients k and c of the modes of all places, of shape (*lanes, modes); zero if a matrix is not finite."""
    k: np.ndarray
    matrices = [np.asarray(x, float) for x in motion if x is not None]
    finite = np.logical_and.reduce([np.isfinite(x).all(axis=(-2, -1), keepdims=True) for x in matrices])
    eye = np.eye(matrices[0].shape[-1])
    mass, stiffness, *damping = (np.where(finite, x, 0.0 if place else eye) for place, x in enumerate(matrices))
    if len(eye) == 1:
        k, c = stiffness / mass, damping[0] / mass if damping else 0 * mass
        k, c = k[..., 0], c[..., 0]
    elif not damping:
        k = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
        c = 0 * k
    else:
        lower = np.concatenate([-np.linalg.solve(mass, x) for x in (stiffness, *damping)], axis=-1)
        upper = np.broadcast_to(np.eye(len(eye), 2 * len(eye), len(eye)), lower.shape)
        _, vectors = np.linalg.eig(np.concatenate([upper, lower], axis=-2))
        shapes = vectors[..., : len(eye), :]
        m, k, c = (np.einsum("...im,...ij,...jm->...m", shapes.conj(), x, shapes) for x in (mass, stiffness, *damping))
        k, c = (k / m).real, c / m
    k, c = (x.reshape(*x.shape[:-2], -1) for x in (k, c))
    k = np.maximum(k, 0.0)
    gyroscopic = np.where(np.abs(c.imag) > ROUND_OFF * (np.abs(c) + np.sqrt(k)), c.imag, 0.0)
    return k, np.maximum(c.real, 0.0) + 1j * gyroscopic


def _is_unstable(scheme: Scheme, k, c, dt, steps) -> np.ndarray:
    """Whether the scheme is unstable on each oscillator; all arguments have one shape."""
    limit, dt = scheme.stability_limit, dt * (1 - ROUND_OFF)
    omega = np.sqrt(k)
    if limit and not c.any():
        return omega * dt > limit
    unstable = (omega + np.abs(c)) * dt > SAFE * (limit or 1.0)
    growth = _growth(scheme, (k * dt**2)[unstable], (c * dt)[unstable])
    grows = growth > GROWTH
    unstable[unstable] = grows if limit else grows & (growth * steps[unstable] > math.log(AMPLIFIED))
    return unstable


def _highest_bound(motion: SmallMotion) -> np.ndarray:
    """An upper bound of ω + |c| of all modes, of the shape of the lanes; infinite or NaN if no bound is found.

    Frobenius' norms bound |φ*Kφ| and |φ*Cφ|, and Gershgorin's circles φ*Mφ. The modes take much longer to compute.
    """
    mass, *others = motion.mass, motion.stiffness, 0.0 * motion.mass if motion.damping is None else motion.damping
    diagonal = np.diagonal(mass, axis1=-2, axis2=-1)
    least = (diagonal - (np.abs(mass).sum(axis=-1) - np.abs(diagonal))).min(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        k, c = (np.where(least > 0, np.linalg.norm(x, axis=(-2, -1)) / least, np.inf) for x in others)
    return (np.sqrt(k) + c).max(axis=-1)


def excess(scheme: Scheme, motion: SmallMotion, dt, steps) -> np.ndarray:
    """Largest (ω + c) Δt of the unstable modes of each lane, of the shape of dt; zero within the stability limit."""
    shape = np.broadcast_shapes(motion.mass.shape[:-3], np.shape(dt), np.shape(steps))
    near = np.broadcast_to(~(_highest_bound(motion) * dt <= SAFE * (scheme.stability_limit or 1.0)), shape)
    largest = np.zeros(shape)
    if not near.any():
        return largest
    k, c = _modes(SmallMotion(*(np.broadcast_to(x, (*shape, *x.shape[-3:]))[near] for x in motion if x is not None)))
    dt, steps = (np.broadcast_to(np.broadcast_to(x, shape)[near][..., None], k.shape) for x in (dt, steps))
    largest[near] = np.where(_is_unstable(scheme, k, c, dt, steps), (np.sqrt(k) + np.abs(c)) * dt, 0.0).max(axis=-1)
    return largest


def stable_part(scheme: Scheme, motion: SmallMotion, dt: float) -> tuple[float, int]:
    """Largest stable part of an unstable step, zero if there is none, and the index of the mode that limits it."""
    k, c = _modes(motion)
    if scheme.stability_limit == 0:
        return 0.0, int(k.argmax())

    def unstable(parts):
        rows = np.broadcast_arrays(k, c, dt * parts[:, None], np.inf)
        return _is_unstable(scheme, *rows)

    beyond = unstable(PARTS)
    first = int(beyond.any(axis=1).argmax())
    if first == 0:
        return 0.0, int(beyond[0].argmax())
    low, high = PARTS[first - 1], PARTS[first]
    for _ in range(REFINEMENTS):
        finer = np.linspace(low, high, REFINED)
        beyond = unstable(finer)
        last = int(beyond.any(axis=1).argmax())
        low, high = finer[last - 1], finer[last]
    return float(low), int(beyond[last].argmax())


def sentence(scheme: Scheme, motion: SmallMotion, dt: float, suffix: str = "") -> str:
    """What exceeds the stability limit, the limit, and the step that would hold, without a full stop."""
    part, mode = stable_part(scheme, motion, dt)
    k, c = _modes(motion)
    where = ("at the start" if mode < len(k) / len(motion.mass) else "about u = 0") + suffix
    k, c = k[mode], c[mode]
    root = np.abs(np.roots([1.0, c, k])).max()
    overdamped = not c.imag and c.real**2 >= HEAVY * k
    name, value = ("cΔt/m", c.real * dt) if overdamped else ("ωΔt", (root if c.imag else np.sqrt(k)) * dt)
    if part and scheme.stability_limit and not c:
        part = scheme.stability_limit / value
    limit, digits = value * part, 4
    while digits < 15 and f"{value:.{digits}g}" == f"{limit:.{digits}g}":
        digits += 1
    ratio = f" with the damping ratio {c.real / 2 / np.sqrt(k):.3g}" if c.real and k and not overdamped else ""
    if not part:
        return f"'{scheme.title}' amplifies small motions at every step, here with {name} = {value:.4g} {where}{ratio}"
    return (
        f"{name} = {value:.{digits}g} {where} exceeds {limit:.{digits}g}, the stability limit of "
        f"'{scheme.title}'{ratio}, which allows steps up to {step_size(dt * part, digits=digits)}"
    )
