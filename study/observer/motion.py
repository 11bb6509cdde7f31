"""The motion along time, and quantities that follow from it."""

import inspect
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import ScalarLike, Vector
from study.algebra.hashing import hashable
from study.algebra.scalars import check_unmasked
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.mechanics.function_checks import failure, index_beyond
from study.observer.base import Observer, Record, Reduction
from study.words import number, relative_to

#: Arguments that the function of a quantity may have, each with its meaning.
ARGUMENTS = {
    "t": "time",
    "u": "displacement",
    "v": "velocity",
    "a": "acceleration",
    "ground": "acceleration of the ground",
}

#: Reductions of a quantity to one value per run; None records it along time.
REDUCTIONS = (None, "peak", "final", "rms")

#: Scales of the errors of a quantity that have a name.
SCALES = ("own", "each", "peak")

#: Smallest scale of a component that has its own, as a fraction of the largest. A smaller component may be round-off.
SMALLEST_SCALE = 1e-6


class Trajectory(Record):
    """Displacement and velocity along time."""

    variables = {
        "u": {"long_name": "displacement", "units": "1"},
        "v": {"long_name": "velocity", "units": "s-1"},
    }

    def sample(self, problem, initial, state, t):
        return {"u": state.u, "v": state.v}


class InternalForce(Record):
    """The internal force K u + p along time; against the displacement it shows the loops of hysteresis."""

    variables = {"internal_force": {"long_name": "internal force", "units": "1"}}

    def sample(self, problem, initial, state, t):
        return {"internal_force": problem.internal_force(state.u, state.v)}


class AbsoluteAcceleration(Record):
    """ü + ι a(t) along time: the acceleration of structures on moving ground in a frame at rest.

    ü follows from the equation of motion, and ι a(t) is the acceleration of the ground at each unknown.
    """

    variables = {"absolute_acceleration": {"long_name": "acceleration in a frame at rest", "units": "m s-2"}}
    needs_ground = True

    def sample(self, problem, initial, state, t):
        relative = acceleration(problem, t, state.u, state.v)
        return {"absolute_acceleration": relative + problem.influence * problem.ground(t)}


class AbsoluteMotion(Record):
    """u + ι u_g(t) and u̇ + ι u̇_g(t) along time: displacement and velocity in a frame at rest.

    The ground starts at rest, and its motion is the exact integral of its acceleration. A drift of the record's
    baseline therefore shows in the motion.
    """

    variables = {
        "absolute_displacement": {"long_name": "displacement in a frame at rest", "units": "m"},
        "absolute_velocity": {"long_name": "velocity in a frame at rest", "units": "m s-1"},
    }
    needs_ground = True

    def sample(self, problem, initial, state, t):
        return {
            "absolute_displacement": state.u + problem.influence * problem.ground.displacement(t),
            "absolute_velocity": state.v + problem.influence * problem.ground.velocity(t),
        }


def _arguments_of(function: Callable) -> tuple[str, ...]:
    """Names of the arguments of a quantity's function."""
    names = tuple(inspect.signature(function).parameters)
    if not names or any(name not in ARGUMENTS for name in names):
        raise ValueError(
            f"the function of a quantity takes some of {', '.join(ARGUMENTS)} ({', '.join(ARGUMENTS.values())}) by "
            f"these names, not {', '.join(names) or 'nothing'}."
        )
    return names


def _hashable(scale: Any) -> str | tuple[float, ...]:
    """A scale as a name or a tuple of numbers; other objects stay as they are, and are refused."""
    check_unmasked("scale", scale)
    with suppress(TypeError, ValueError):
        return scale if isinstance(scale, str) else tuple(np.atleast_1d(np.asarray(scale, float)).tolist())
    return scale


class Quantity(Record):
    r"""Your own quantity, a function of t, u, u̇ and ü: along time, or reduced to one value per run.

    Parameters
    ----------
    function
        Function of some of the arguments ``t``, ``u``, ``v``, ``a`` and ``ground``, which must have these names: the
        time, and displacement, velocity, acceleration and acceleration of the ground, each of shape () or (n,). It
        returns a number or a vector and must be written with ``jax.numpy``. The acceleration follows from the equation
        of motion, :math:`M^{-1} (f - C \dot u - p(u))`, whatever the scheme carries. On moving ground it is relative to
        the ground, and ``ground`` is ι a(t), the acceleration of the ground at each unknown. The absolute acceleration
        is ``lambda a, ground: a + ground``.
    name, long_name, units
        Name and attributes of the variable in the dataset.
    reduce
        ``"peak"`` for the largest absolute value over all steps, ``"final"`` for the last value, ``"rms"`` for the root
        mean square over time by the trapezoidal rule, each for every component; None for the record along time. Peak
        and root mean square see the ends of steps only, so that their errors are of second order in the step, whatever
        the scheme, and no tolerance controls them.
    scale
        Value to which :func:`study.assess` relates the errors of the quantity. ``"own"`` is the value itself: the peak,
        final value or root mean square, or without ``reduce`` the largest value along time. All components share one
        scale, the largest of them, because a mass that hardly moves need not be accurate to its own size; a remark
        states components that are more than a hundred times smaller. ``"each"`` gives each component its own value as
        scale, but at least a millionth of the largest, as components of different units need. ``"peak"`` is the largest
        value along time, also of a final value or a root mean square. A number, or an array with one number for each
        component, is a scale in the unit of the quantity.

    Raises
    ------
    TypeError
        If ``function`` is not a function.
    ValueError
        If the function has other arguments or none, or there is no such reduction or scale, or if the scale is masked.
    """

    function: Callable = eqx.field(converter=hashable)
    name: str = eqx.field(default="quantity", static=True)
    long_name: str = eqx.field(default="", static=True)
    units: str = eqx.field(default="1", static=True)
    reduce: str | None = eqx.field(default=None, static=True)
    scale: str | float | Sequence[float] = eqx.field(default="own", static=True, converter=_hashable)

    def __check_init__(self):
        if not callable(self.function):
            raise TypeError(f"a quantity needs a function, not {self.function!r}.")
        _arguments_of(self.function)
        numbers = isinstance(self.scale, tuple) and self.scale and all(0 < size < np.inf for size in self.scale)
        if self.scale not in SCALES and not numbers:
            raise ValueError(
                f"scale must be {', '.join(map(repr, SCALES))}, or numbers greater than zero, not {self.scale!r}."
            )
        if self.reduce not in REDUCTIONS:
            raise ValueError(f"reduce must be one of {', '.join(map(repr, REDUCTIONS))}, not {self.reduce!r}.")

    @property
    def variables(self) -> dict[str, dict[str, str]]:  # type: ignore[override]
        return {self.name: {"long_name": self.long_name or self.name, "units": self.units}}

    @property
    def needs_acceleration(self) -> bool:
        """Whether the function takes the acceleration."""
        return "a" in _arguments_of(self.function)

    def scales(self, values: np.ndarray, peaks: np.ndarray) -> np.ndarray:
        """Scale of the error of each component, of shape (m,).

        Parameters
        ----------
        values
            Reduced value of each component, or its largest absolute value along time, of shape (m,).
        peaks
            Largest absolute value of each component along time, of shape (m,).

        Raises
        ------
        ValueError
            If the quantity has neither one scale nor one for each component.
        """
        if isinstance(self.scale, tuple):
            if len(self.scale) not in (1, len(values)):
                raise ValueError(
                    f"scale of '{self.long_name or self.name}' must be one number or one for each of its "
                    f"{len(values)} components, not {len(self.scale)} numbers."
                )
            return np.broadcast_to(np.array(self.scale), np.shape(values))
        sizes = np.abs(peaks if self.scale == "peak" else values)
        largest = np.full(sizes.shape, sizes.max())
        return np.maximum(sizes, SMALLEST_SCALE * largest) if self.scale == "each" else largest

    def relative_to(self, components: int) -> str:
        """The value to which errors of the quantity are relative, in words."""
        if isinstance(self.scale, tuple):
            return f"relative to {', '.join(map(number, self.scale))}{f' {self.units}' * (self.units != '1')}"
        return relative_to("" if self.scale == "peak" else self.reduce or "", components, self.scale == "each")

    def marched(self) -> Observer:
        return self if self.reduce is None else _Reduced(self)

    def refusal(self, problem):
        if problem.ground is None and "ground" in _arguments_of(self.function):
            return f"the quantity '{self.name}' needs Problem(ground=...), which '{problem.title}' was made without."
        if problem.massless and self.needs_acceleration:
            return f"the quantity '{self.name}' needs ü, which is undetermined where '{problem.title}' has no mass."
        try:
            value = eqx.filter_eval_shape(self.value, problem, 0.0, problem.u0, problem.v0)
        except Exception as error:  # a user's function may raise anything
            otherwise = f"cannot be computed for '{problem.title}'"
            return f"the quantity '{self.name}' {failure(error, otherwise)}"
        if wrong := index_beyond(self._at_start, problem.u0, problem.v0):
            return f"the quantity '{self.name}' takes an entry that '{problem.title}' does not have: {wrong}."
        fits = isinstance(value, jax.ShapeDtypeStruct) and value.ndim <= 1 and value.size
        if not fits or jnp.issubdtype(value.dtype, jnp.complexfloating):
            return f"the quantity '{self.name}' must return a real number or a vector of them, not {value}."
        return None

    def _at_start(self, u, v):
        """The quantity at t = 0, with NumPy arrays as arguments and zeros in place of the accelerations."""
        arguments = {"t": 0.0, "u": u, "v": v, "a": np.zeros_like(u), "ground": np.zeros_like(u)}
        return self.function(**{name: arguments[name] for name in _arguments_of(self.function)})

    def value(self, problem: Problem, t: ScalarLike, u: Vector, v: Vector) -> jax.Array:
        """The quantity at one time: a number, or a vector (m,)."""
        t, u, v = jnp.asarray(t, float), jnp.asarray(u), jnp.asarray(v)
        names = _arguments_of(self.function)
        arguments = {"t": t, "u": u, "v": v}
        if "a" in names:
            arguments["a"] = acceleration(problem, t, u, v)
        if "ground" in names:
            # a problem without ground motion is refused
            arguments["ground"] = problem.influence * problem.ground(t)  # type: ignore[misc]
        return jnp.asarray(self.function(**{name: arguments[name] for name in names}))

    def sample(self, problem, initial, state, t):
        return {self.name: self.value(problem, t, state.u, state.v)}


class _Reduced(Reduction):
    """A quantity reduced to one value per run."""

    quantity: Quantity

    @property
    def variables(self) -> dict[str, dict[str, str]]:  # type: ignore[override]
        return self.quantity.variables

    def start(self, problem, state):
        value = self.quantity.value(problem, 0.0, state.u, state.v).astype(float)
        if self.quantity.reduce == "peak":
            return jnp.abs(value)
        return (value, jnp.zeros(()), jnp.zeros_like(value)) if self.quantity.reduce == "rms" else value

    def update(self, carried, problem, state, t, effort):
        value = self.quantity.value(problem, t, state.u, state.v).astype(float)
        if self.quantity.reduce == "peak":
            return jnp.maximum(carried, jnp.abs(value))
        if self.quantity.reduce == "final":
            return value
        before, start, squares = carried
        return value, t, squares + (t - start) * (before**2 + value**2) / 2

    def result(self, carried, problem, state):
        if self.quantity.reduce == "rms":
            _, end, squares = carried
            carried = jnp.sqrt(squares / end)
        return {self.quantity.name: carried}
