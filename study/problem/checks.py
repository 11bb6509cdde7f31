"""Checks of a problem's arguments, made once when the problem is made.

Each check refuses what a run could not use, with a sentence that names the argument, what was received and what is
expected. Values that JAX is tracing have a shape but no numbers: only their shape is checked.
"""

import inspect
import reprlib
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import scipy

from study.algebra.arrays import Matrix, ScipySparse
from study.algebra.factorisation import is_positive_definite
from study.algebra.matrices import Banded, MatrixFree
from study.algebra.sparse import SYMMETRY, Sparse, as_sparse, is_sparse, is_sparse_of_jax, of_jax
from study.problem.damping import Rayleigh
from study.problem.ground import GroundMotion
from study.problem.potential import StrainEnergy

#: Arguments of a problem that are matrices.
MATRICES = ("stiffness", "mass", "damping")

#: Names of arguments that a force takes from the motion.
NEVER_OPTIONAL = ("v", "velocity", "history")

#: A potential and its force may differ by this part of the force: the error of a central difference.
GRADIENT_AGREEMENT = 1e-5


def real_numbers(name: str, value):
    """The value as a float64 array; None, matrices in a form of their own and what JAX is tracing stay as they are."""
    if value is None or isinstance(value, jax.core.Tracer | Rayleigh | Banded | Sparse | MatrixFree):
        return value
    if is_sparse_of_jax(value):
        if isinstance(value.indices, jax.core.Tracer):
            raise ValueError(f"{name}: JAX may trace the entries of a sparse matrix, not their places.")
        return of_jax(value)
    if is_sparse(value):
        if value.ndim != 2:
            raise ValueError(f"{name} must be a matrix; the sparse array has the shape {value.shape}.")
        if value.dtype.kind not in "fiu":
            raise ValueError(f"{name} must be a sparse matrix of real numbers, not of {value.dtype}.")
        return as_sparse(value)
    try:
        numbers = np.asarray(value)
    except ValueError:  # rows of different lengths
        numbers = np.asarray(None)
    if numbers.dtype.kind not in "fiu":
        raise ValueError(f"{name} must be a real number or an array of real numbers, not {reprlib.repr(value)}.")
    return numbers.astype(np.float64)


def check_shapes(problem) -> None:
    """Refuse numbers whose shapes do not fit that of u₀."""
    shape = np.shape(problem.u0)
    if problem.u0 is None or len(shape) > 1 or shape == (0,):
        got = "nothing" if problem.u0 is None else f"an array of shape {shape}"
        raise ValueError(f"u0 must be a number or a vector (n,), not {got}.")
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
        raise ValueError("influence needs Problem(ground=...), the motion whose influence it is.")
    if problem.influence is not None and np.shape(problem.influence) != shape:
        raise ValueError(f"influence must have the shape of u0, {shape}, not {np.shape(problem.influence)}.")
    if problem.positions is not None and (
        np.ndim(problem.positions) != 2
        or np.shape(problem.positions)[1] > 3
        or np.size(problem.positions) != np.size(problem.u0)
    ):
        raise ValueError(
            f"positions must be of shape (points, directions), at most three directions, with one number for each "
            f"of u0's {np.size(problem.u0)}, not {np.shape(problem.positions)}."
        )


def check_finite(name: str, value) -> None:
    """Refuse numbers that are not finite."""
    if isinstance(value, np.ndarray) and not np.isfinite(value).all():
        raise ValueError(f"{name} must be finite, not {value}.")
    if is_sparse(value) and not np.isfinite(value.data).all():
        places = scipy.sparse.coo_array(value)
        row, column = (int(place[np.argmin(np.isfinite(places.data))]) for place in places.coords)
        raise ValueError(f"{name} must be finite, and its entry ({row}, {column}) is {value[row, column]}.")


#: What a function raises that JAX cannot trace.
NOT_TRACEABLE = (
    jax.errors.ConcretizationTypeError,
    jax.errors.TracerArrayConversionError,
    jax.errors.TracerIntegerConversionError,
)


def _calls(problem) -> dict[str, tuple[str, tuple, tuple[int, ...]]]:
    """For each function of a problem: what it is given, in words and as arrays, and the shape of what it returns."""
    shape = np.shape(problem.u0)
    u, v, history = ("the displacement", problem.u0), ("the velocity", problem.v0), ("the history", problem.history)
    memory = () if problem.history is None else (history,)
    given = {
        "force": (shape, u, *((v,) if problem.arguments > 1 else ()), *memory),
        "load": (shape, ("the time", 0.0)),
        "potential": ((), u, *memory),
    }
    return {
        name: (
            ", ".join(what for what, _ in of) + (" alone" if len(of) == 1 else ""),
            tuple(x for _, x in of),
            expected,
        )
        for name, (expected, *of) in given.items()
    }


def check_defaults(force: Callable, title: str) -> None:
    """Refuse a default for the velocity or the history, with which the force would never receive them."""
    try:
        parameters = inspect.signature(force).parameters.values()
    except (TypeError, ValueError):  # no function, or a built-in one, which tells nothing
        return
    for parameter in parameters:
        if parameter.default is not parameter.empty and parameter.name in NEVER_OPTIONAL:
            raise ValueError(
                f"force of '{title}' gives '{parameter.name}' a default, so that it would never receive it: "
                f"drop the default."
            )


def check_functions(problem) -> None:
    """Refuse functions that JAX cannot trace, or whose values have the wrong shape or type.

    Each function is called as a run calls it, with an array that JAX traces.
    """
    for name, (given, arguments, expected) in _calls(problem).items():
        function = getattr(problem, name)
        needed = name == "force" and problem.stiffness is None
        if not callable(function) and (function is not None or needed):
            raise TypeError(f"{name} must be a function, not {function!r}.")
        if function is None:
            continue
        try:
            # arrays in the function are traced too, as in a run
            received = eqx.filter_eval_shape(lambda f, *x: f(*x), function, *jax.tree.map(jnp.asarray, arguments))
        except Exception as error:  # a user's function may raise anything
            reason = f"{type(error).__name__}: {(str(error).splitlines() or [''])[0]}"
            if isinstance(error, NOT_TRACEABLE):
                raise ValueError(f"{name} of '{problem.title}' must be written with jax.numpy: {reason}") from error
            raise ValueError(f"{name} of '{problem.title}' fails for {given}: {reason}") from error
        if name == "force" and problem.history is not None:
            received = _without_history(received, problem.history, problem.title)
        if not hasattr(received, "shape") or received.shape != expected:
            got = getattr(received, "shape", type(received).__name__)
            raise ValueError(f"{name} must return the shape {expected}, not {got}.")
        if received.dtype != float:
            raise ValueError(f"{name} must return float64, not {received.dtype}.")
    if isinstance(problem.potential, StrainEnergy):
        _check_strain_energy(problem.potential, problem.u0)


def _without_history(returned, history, title: str):
    """The force out of what a force with a history returned, after a check of the new history."""
    if not (isinstance(returned, tuple) and len(returned) == 2):
        raise ValueError(f"force of '{title}' must return the force and its new history, a tuple of two.")
    start, new = (
        (str(jax.tree.structure(one)), [(jnp.shape(x), jnp.result_type(x)) for x in jax.tree.leaves(one)])
        for one in (history, returned[1])
    )
    if start != new:
        raise ValueError(
            f"force of '{title}' must return a history with the containers, shapes and types of its start, "
            f"{jax.tree.map(_kind, history)}, not {jax.tree.map(_kind, returned[1])}."
        )
    return returned[0]


def _check_strain_energy(potential: StrainEnergy, u0) -> None:
    strains = jax.eval_shape(potential.strains, u0).shape
    energies = jax.eval_shape(lambda u: potential.density(potential.strains(u)), u0).shape
    if len(strains) != 1 or energies != strains:
        raise ValueError(
            f"a StrainEnergy needs strains of shape (m,) and a density of the same shape, not {strains} and {energies}."
        )


def check_ground(ground, load, title: str) -> None:
    """Refuse a ground that is no motion, and a load that is no function."""
    if not isinstance(ground, GroundMotion):
        raise TypeError(f"ground of '{title}' must be a study.GroundMotion, not {ground!r}.")
    if load is not None and not callable(load):
        raise TypeError(f"load must be a function, not {load!r}.")


def check_gradient(force: Callable, potential: Callable, u0, title: str) -> None:
    """Refuse a force that is not the gradient of the potential, along one direction near u₀."""
    u, direction, h = _near(u0)
    _compare(force, potential, u, direction, h, title)


def _kind(array) -> str:
    """Type and shape of an array in short."""
    return f"{jnp.result_type(array)}{list(jnp.shape(array))}"


def check_history(force: Callable, u0, v0, history, title: str) -> None:
    """Refuse a force whose new history does not give the same force again and return itself."""
    u, _, _ = _near(u0)

    @jax.jit
    def twice(u, v, history):
        p, new = force(u, v, history)
        return (p, new), force(u, v, new)

    with jax.ensure_compile_time_eval():
        once, again = (jax.tree.leaves(one) for one in twice(u, v0, history))
    changes = [
        np.abs(np.asarray(x) - y).max() > GRADIENT_AGREEMENT * np.abs(x).max() for x, y in zip(once, again, strict=True)
    ]
    if any(changes):
        what = "another force" if changes[0] else "another history"
        raise ValueError(
            f"force of '{title}' gives {what} when it is called again with the same displacement and the history that "
            "it returned; a committed history must give the same force and return itself."
        )


def check_stored_energy(force: Callable, potential: Callable, u0, history, title: str) -> None:
    """Refuse a stored energy whose slope is not the force where a motion leaves the history as it is.

    That is so after a reversal in springs that yield. Where the history changes on both ways, nothing is compared.
    """
    u, direction, h = _near(u0)

    @jax.jit
    def after(u, history):
        return force(u, jnp.zeros_like(u), history)[1]

    with jax.ensure_compile_time_eval():
        committed = after(u, history)
        for way in (-1, 1):
            place = u + way * 2 * h * direction
            changes = jax.tree.map(lambda old, new: jnp.abs(new - old).max(), committed, after(place, committed))
            if max(map(float, jax.tree.leaves(changes))) < 1e-4 * h:
                _compare(
                    lambda u: force(u, jnp.zeros_like(u), committed)[0],
                    lambda u: potential(u, committed),
                    place,
                    direction,
                    h,
                    title,
                )
                return


def _near(u0):
    """A place near u₀, a direction, and a small distance."""
    scale = max(np.abs(u0).max(), 1.0)
    direction, offset = np.random.default_rng(0).uniform(0.5, 1.5, (2, *np.shape(u0)))
    return u0 + 0.05 * scale * offset, direction, 1e-5 * scale


def _compare(force: Callable, potential: Callable, u, direction, h, title: str) -> None:
    @jax.jit
    def values(ahead, behind, u):
        return potential(ahead), potential(behind), jnp.vdot(direction, force(u))

    with jax.ensure_compile_time_eval():  # a problem may be made while JAX traces
        ahead, behind, expected = map(float, values(u + h * direction, u - h * direction, u))
    slope = (ahead - behind) / (2 * h)
    round_off = 1e-14 * max(abs(ahead), abs(behind)) / h
    # a value that is not finite passes here; the run reports it
    if abs(slope - expected) > GRADIENT_AGREEMENT * max(abs(slope), abs(expected)) + round_off:
        raise ValueError(
            f"the force of '{title}' is not the gradient of its potential: along a direction near u0 it is "
            f"{expected:g}, and the slope of the potential {slope:g}."
        )


def check_symmetry(name: str, matrix) -> None:
    """Refuse a matrix (n, n) that is not symmetric."""
    if is_sparse(matrix) or (isinstance(matrix, np.ndarray) and matrix.ndim == 2):
        difference = np.abs(matrix - matrix.T).max()
        if difference > SYMMETRY * np.abs(matrix).max():
            raise ValueError(f"{name} must be symmetric; it differs from its transpose by {difference:g}.")


def is_singular(mass) -> bool:
    """Whether the mass is singular; a negative or zero one is refused.

    A sparse mass may be singular only because unknowns have none.
    """
    if is_sparse(mass):
        return _is_singular(mass)
    if not isinstance(mass, np.ndarray):
        return False
    diagonal = np.diagonal(mass) if mass.ndim == 2 else mass
    full = mass.ndim == 2 and np.count_nonzero(mass) > np.count_nonzero(diagonal)
    values = np.linalg.eigvalsh(mass) if full else diagonal
    # eigenvalues of a full matrix are known to round-off only
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
        raise ValueError("mass must be positive definite, but for unknowns without any mass; it is not.")
    return singular


def check_rayleigh(damping: Rayleigh, title: str) -> None:
    """Refuse coefficients of Rayleigh damping that are not finite numbers."""
    if any(isinstance(c, jax.core.Tracer) for c in damping):
        return
    if not all(np.ndim(c) == 0 and np.asarray(c).dtype.kind in "fiu" and np.isfinite(c) for c in damping):
        raise ValueError(f"{damping} of '{title}': a and b must be finite numbers.")


def finite_damping(damping: Matrix, title: str) -> Matrix:
    """Rayleigh damping, after a check that the stiffness on which it is based is finite."""
    parts = jax.tree.leaves(eqx.filter(damping, eqx.is_array))
    if not all(isinstance(part, jax.core.Tracer) or np.isfinite(part).all() for part in parts):
        raise ValueError(f"the stiffness of '{title}' at u = 0, on which its Rayleigh damping is based, is not finite.")
    return damping
