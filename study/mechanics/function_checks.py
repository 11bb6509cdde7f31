"""Checks of a problem's functions, made once when the problem is made.

Each check calls the functions as a run does, and raises an error for an invalid result. Its message names the function,
and the expected and received results.
"""

import inspect
import linecache
import re
import traceback
from collections.abc import Callable
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental import checkify

from study.algebra.reads import reading, reads_of
from study.mechanics.internal_force import TIME
from study.mechanics.terms import StrainEnergy

#: Names of a force's arguments that must not have a default.
NEVER_OPTIONAL = ("v", "velocity", "history", *TIME)

#: Parameter names that can only mean the motion, which a load does not take.
MOTION = ("u", "v", "displacement", "velocity")

#: Relative tolerance between the force and the slope of its potential, for the error of a central difference.
GRADIENT_AGREEMENT = 1e-5


#: Value that stands for a traced number that JAX does not know; powers by it are undefined for negative numbers.
UNKNOWN = 1.5

#: Exceptions that a function raises if JAX cannot trace it.
NOT_TRACEABLE = (
    jax.errors.ConcretizationTypeError,
    jax.errors.TracerArrayConversionError,
    jax.errors.TracerIntegerConversionError,
    jax.errors.NonConcreteBooleanIndexError,
)

#: What to write in a function that JAX cannot trace, by the exception. Subclasses come first.
_INSTEAD = {
    jax.errors.TracerBoolConversionError: (
        "jnp.where in place of if, & in place of and, jnp.minimum in place of min, or jnp.maximum in place of max"
    ),
    jax.errors.TracerArrayConversionError: "jnp.sin, jnp.interp or jnp.array in place of functions of NumPy and SciPy",
    jax.errors.TracerIntegerConversionError: "an array of jnp in place of a list with this index",
    jax.errors.NonConcreteBooleanIndexError: "jnp.where in place of this index",
    jax.errors.ConcretizationTypeError: "jnp.sin or jnp.floor in place of float, int and functions of math",
}
#: As ``_INSTEAD``, by words in the message of any other exception.
_INSTEAD_OF = {
    "are immutable": "p.at[i].set(x) in place of p[i] = x",
    "setting an array element with a sequence": "jnp.array([x, y]) in place of p[i] = x",
    "masked arrays are not supported": "an array without masked entries",
}


def failure(error: Exception, otherwise: str) -> str:
    """The end of a sentence on a function that raised an exception: what to write instead, in place of JAX' own words.

    If the exception has another cause, the sentence says ``otherwise`` and cites the exception.
    """
    text = (str(error).splitlines() or [""])[0].rstrip(". ")
    remedy = next((words for kind, words in _INSTEAD.items() if isinstance(error, kind)), None)
    remedy = remedy or next((words for part, words in _INSTEAD_OF.items() if part in text), None)
    if remedy:
        place = _place(error)
        if isinstance(error, jax.errors.TracerBoolConversionError) and (call := re.search(r"\b(min|max)\(", place)):
            remedy = f"jnp.{call[1]}imum in place of {call[1]}"
        return f"must be written with jax.numpy: use {remedy}{place}."
    return f"{otherwise}: {type(error).__name__}: {text}."


def _place(error: Exception) -> str:
    """The expression of the user's code that raised an exception, in words; empty if its text is not known."""
    package = Path(__file__).parents[1]
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if "site-packages" not in frame.filename and package not in Path(frame.filename).parents:
            line = linecache.getline(frame.filename, frame.lineno or 0).encode()
            end = frame.end_colno if frame.end_lineno == frame.lineno else None
            expression = line[frame.colno : end].decode().strip()
            return f", in `{expression}`" if expression else ""
    return ""


class AsArrays(eqx.Module):
    """A function whose returned numbers and lists are converted to arrays."""

    function: Callable

    def __call__(self, *arguments):
        """The value as an array."""
        return jnp.asarray(self.function(*arguments), float)

    @property
    def kinks(self):
        """Times at which the slope of a load jumps; empty if the load does not state them."""
        return getattr(self.function, "kinks", ())


def index_beyond(function: Callable, *arguments) -> str | None:
    """Message on an index beyond the end of an array in the function; None if no such index is found.

    JAX would silently read the last entry instead, or drop a value that is added to an entry that does not exist. With
    arrays of NumPy, reading such an entry raises an error. Only a function that cannot take arrays of NumPy, such as
    one with ``u.at[i]``, is compiled with checks.
    """
    try:
        # within `eval_shape` JAX computes nothing
        with np.errstate(all="ignore"):
            jax.eval_shape(lambda: jax.tree.map(jnp.asarray, function(*jax.tree.map(np.asarray, arguments))))
    except IndexError as error:
        return str(error)
    except Exception:  # a user's function may raise anything on arrays for which it is not written
        return _index_beyond_of_jax(function, arguments)
    return None


def _index_beyond_of_jax(function: Callable, arguments: tuple) -> str | None:
    """As :func:`index_beyond`, for a function that takes arrays of JAX only.

    None is also returned if JAX traces the values, or if the checks do not support the function.
    """
    checked = jax.jit(checkify.checkify(function, errors=checkify.index_checks))
    try:
        with jax.ensure_compile_time_eval():
            wrong = checked(*jax.tree.map(jnp.asarray, arguments))[0].get()
    except (*NOT_TRACEABLE, NotImplementedError):  # JAX traces a value, or the checks do not support the function
        return None
    return wrong and wrong.rstrip(". ")


def _calls(problem) -> dict[str, tuple[str, tuple, tuple[int, ...]]]:
    """For each function of a problem: its arguments in words, its arguments as arrays, and the shape of its result."""
    shape = np.shape(problem.u0)
    u, v, history = ("the displacement", problem.u0), ("the velocity", problem.v0), ("the history", problem.history)
    memory = () if problem.history is None else (history,)
    # the potential before a force that may be its gradient, so that the message on its fault names it
    calls = {
        "potential": ((), u, *memory),
        "force": (shape, u, *((v,) if problem.arguments > 1 else ()), *memory),
        "load": (shape, ("the time", 0.0)),
    }
    if problem.takes_time:
        shape, *arguments = calls["force"]
        arguments.insert(problem.place_of_time, ("the time", 0.0))
        calls["force"] = (shape, *arguments)
    return {
        name: (
            ", ".join(words for words, _ in arguments) + (" alone" if len(arguments) == 1 else ""),
            tuple(x for _, x in arguments),
            expected,
        )
        for name, (expected, *arguments) in calls.items()
    }


def _parameters(function: Callable | None) -> list[inspect.Parameter]:
    try:
        return [] if function is None else list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):  # not a function, or a built-in function without a signature
        return []


def check_arguments(force: Callable, potential: Callable | None, load: Callable | None, title: str) -> None:
    """Refuse a potential of a force that takes the time, and arguments or kinks of a load that it cannot have.

    Defaults for the motion are refused too.
    """
    for parameter in _parameters(force):
        if parameter.default is not parameter.empty and parameter.name in NEVER_OPTIONAL:
            raise ValueError(
                f"force of '{title}' gives '{parameter.name}' a default, and would never be called with another value: "
                f"drop the default."
            )
    names = {parameter.name for function in (force, potential) for parameter in _parameters(function)}
    if potential is not None and names & set(TIME):
        raise ValueError(
            f"a potential of '{title}' that depends on the time is not supported: give force(u, t) without a potential."
        )
    for parameter in _parameters(load):
        if parameter.name in MOTION and parameter.default is parameter.empty:
            raise ValueError(
                f"load of '{title}' takes '{parameter.name}', and is called as load(t): what depends on the motion "
                "goes into force=, a function of u, or of u and v, and of t if it takes the time."
            )
    if not isinstance(load, eqx.Module):  # a ground motion has times of its own
        declared = getattr(load, "kinks", ())
        try:
            are_times = np.isfinite(np.asarray(declared, float)).all()
        except (TypeError, ValueError):
            are_times = False
        if not are_times:
            raise ValueError(f"load.kinks of '{title}' must hold times in s, not {declared!r}.")


def check_functions(problem) -> None:
    """Refuse functions that JAX cannot trace, or whose values have the wrong shape or type.

    Each function is called as a run calls it, with arrays that JAX traces. If the problem has no history, and its force
    or load returns a number or a list, the problem gets a function that returns an array instead.
    """
    for name, (words, arguments, expected) in _calls(problem).items():
        function = getattr(problem, name)
        is_required = name == "force" and problem.stiffness is None
        if not callable(function) and (function is not None or is_required):
            if np.ndim(function):
                raise TypeError(f"{name} must be a function, not an array: use jnp.interp for samples.")
            raise TypeError(f"{name} must be a function, not {function!r}.")
        if function is None:
            continue
        try:
            # arrays in the function are traced too, as in a run
            result = eqx.filter_eval_shape(lambda f, *x: f(*x), function, *jax.tree.map(jnp.asarray, arguments))
        except Exception as error:  # a user's function may raise anything
            raise ValueError(f"{name} of '{problem.title}' {failure(error, f'fails for {words}')}") from error
        if name == "force" and problem.history is not None:
            result = _without_history(result, problem.history, problem.title)
        if name != "potential" and problem.history is None and isinstance(result, int | float | list):
            object.__setattr__(problem, name, AsArrays(function))
            result = eqx.filter_eval_shape(getattr(problem, name), *jax.tree.map(jnp.asarray, arguments))
        if not hasattr(result, "shape") or result.shape != expected:
            shape = getattr(result, "shape", type(result).__name__)
            raise ValueError(f"{name} must return the shape {expected}, not {shape}.")
        if result.dtype != float:
            raise ValueError(f"{name} must return float64, not {result.dtype}.")
        if wrong := index_beyond(function, *arguments):
            raise ValueError(f"{name} of '{problem.title}' takes an entry that does not exist: {wrong}.")
    if isinstance(problem.potential, StrainEnergy):
        _check_strain_energy(problem.potential, problem.u0)


def _without_history(result, history, title: str):
    """The force in the result (force, new history), after a check that the new history has the form of the old one."""
    if not (isinstance(result, tuple) and len(result) == 2):
        raise ValueError(f"force of '{title}' must return the force and its new history, a tuple of two.")
    start, new = (
        (str(jax.tree.structure(value)), [(jnp.shape(x), jnp.result_type(x)) for x in jax.tree.leaves(value)])
        for value in (history, result[1])
    )
    if start != new:
        raise ValueError(
            f"force of '{title}' must return a history with the containers, shapes and types of its start, "
            f"{jax.tree.map(_kind, history)}, not {jax.tree.map(_kind, result[1])}."
        )
    return result[0]


def _check_strain_energy(potential: StrainEnergy, u0) -> None:
    strains = jax.eval_shape(potential.strains, u0).shape
    energies = jax.eval_shape(lambda u: potential.density(potential.strains(u)), u0).shape
    if len(strains) != 1 or energies != strains:
        raise ValueError(
            f"a StrainEnergy needs strains of shape (m,) and a density of the same shape, not {strains} and {energies}."
        )


def check_gradient(force: Callable, potential: Callable, u0, title: str) -> None:
    """Refuse a force that is not the gradient of the potential, along one direction near u₀."""
    u, direction, h = _near(u0)
    _compare(force, potential, u, direction, h, title)


def known(value):
    """The number behind a tracer where JAX knows it; otherwise a number that is not whole, of the same shape."""
    if not isinstance(value, jax.core.Tracer):
        return value
    known = value.to_concrete_value()
    return jnp.full(value.shape, UNKNOWN).astype(value.dtype) if known is None else known


def _displacements(u0) -> np.ndarray:
    """Displacements around u₀ and zero, at distances far below and far above the size of u₀, of shape (points, ...)."""
    u0 = np.asarray(known(u0))
    ways = np.random.default_rng(0).uniform(0.5, 1.5, (2, *u0.shape))
    sizes = max(np.abs(u0).max(), 1.0) * np.array([1e-3, 0.05, 1.0, 30.0])
    away = [sign * size * way for size in sizes for sign in (-1, 1) for way in ways]
    return np.stack([u0, -u0, *(around + offset for around in (u0, 0 * u0) for offset in away)])


#: Advice for a function whose value is finite and whose derivative is not.
DOUBLE_WHERE = (
    "keep the branch that jnp.where does not select finite by a double where, such as "
    "jnp.where(u > 0, jnp.where(u > 0, u, 1.0) ** 1.5, 0.0)"
)


def check_derived_force(problem) -> None:
    """Refuse a potential whose gradient, which is the force, is NaN where the potential and its change are finite.

    A branch that ``jnp.where`` does not select causes this: its infinite or undefined slope is multiplied by zero.
    """
    memory = () if problem.history is None else (problem.history,)
    program = eqx.filter_make_jaxpr(lambda u: problem.potential(u, *memory))(jnp.asarray(problem.u0))[0]

    def is_lost(u):
        def potential(u):
            return jax.core.eval_jaxpr(program.jaxpr, numbers, u)[0]

        value, slope = jax.value_and_grad(potential)(u)
        _, along = jax.jvp(potential, (u,), (jnp.ones_like(u),))
        return jnp.isnan(slope).any() & jnp.isfinite(value) & jnp.isfinite(along)

    with jax.ensure_compile_time_eval():
        numbers = [known(value) for value in program.consts]
        lost = "select_n" in str(program.jaxpr) and jax.vmap(is_lost)(jnp.asarray(_displacements(problem.u0))).any()
    if lost:
        raise ValueError(
            f"the force of '{problem.title}', the gradient of its potential, is NaN where the potential is finite: "
            f"{DOUBLE_WHERE}."
        )


def _kind(array) -> str:
    """Type and shape of an array in short."""
    return f"{jnp.result_type(array)}{list(jnp.shape(array))}"


@eqx.filter_jit
def _twice(force: Callable, u, v, history) -> tuple:
    """Force and history after a motion, and those after the same motion from this history."""
    p, new = force(u, v, history)
    return (p, new), force(u, v, new)


def check_history(force: Callable, u0, v0, history, title: str) -> None:
    """Refuse a force function that returns another force or history when it is called again with its new history."""
    u, _, _ = _near(u0)
    # compiled by JAX directly, since a problem of a family is made within another compiled function
    with jax.ensure_compile_time_eval(), reading(reads_of(force)):
        once, again = (jax.tree.leaves(value) for value in _twice(force, u, v0, history))
    round_off = 1e-12 * max(np.abs(x).max() for x in once)
    changes = [
        np.abs(np.asarray(x) - y).max() > GRADIENT_AGREEMENT * np.abs(x).max() + round_off
        for x, y in zip(once, again, strict=True)
    ]
    if any(changes):
        change = "another force" if changes[0] else "another history"
        raise ValueError(
            f"force of '{title}' gives {change} when it is called again with the same displacement and the history "
            "that it returned; a committed history must give the same force and return itself."
        )


def check_stored_energy(force: Callable, potential: Callable, u0, history, title: str) -> None:
    """Refuse a stored energy whose slope differs from the force along a motion that does not change the history.

    Two opposite small motions are tried, since a spring that has yielded keeps its history when the motion reverses.
    If both motions change the history, nothing is compared.
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
    """A displacement near u₀, the direction of a small motion, and the small distance h of this motion."""
    scale = max(np.abs(u0).max(), 1.0)
    direction, offset = np.random.default_rng(0).uniform(0.5, 1.5, (2, *np.shape(u0)))
    return u0 + 0.05 * scale * offset, direction, 1e-5 * scale


def _compare(force: Callable, potential: Callable, u, direction, h, title: str) -> None:
    @jax.jit
    def values(ahead, behind, u):
        return potential(ahead), potential(behind), jnp.vdot(direction, force(u))

    with jax.ensure_compile_time_eval():  # JAX may be tracing while the problem is made
        ahead, behind, expected = map(float, values(u + h * direction, u - h * direction, u))
    slope = (ahead - behind) / (2 * h)
    round_off = 1e-14 * max(abs(ahead), abs(behind)) / h
    # a value that is not finite is accepted here; the run reports it
    if abs(slope - expected) > GRADIENT_AGREEMENT * max(abs(slope), abs(expected)) + round_off:
        raise ValueError(
            f"the force of '{title}' is not the gradient of its potential: along a direction near u0 it is "
            f"{expected:g}, and the slope of the potential {slope:g}."
        )
