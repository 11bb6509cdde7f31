"""Errors of runs in a user's quantities."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jax import lax
from jaxtyping import Float

from study.algebra.elementwise import quintic, value
from study.algebra.jit import jit
from study.assessment.solution import DenseSolution, Times
from study.mechanics.definition import Problem
from study.observer.base import Observer, Reduction
from study.observer.motion import Quantity

#: Number of parts into which an interval of the reference is divided to evaluate a quantity.
FINER = 8

#: Refinement of a peak: number of samples between the neighbours of the largest sample, and number of refinements.
CLOSER, REFINEMENTS = 65, 2

#: Number of points in time at which one call evaluates a quantity.
AT_ONCE = 4096

#: Values of a quantity at some times, with an axis for its components.
Values = Float[np.ndarray, "t components"]

#: Prefix of the names of quantities in a run, so that they do not clash with other variables.
PREFIX = "quantity "

#: Default quantities.
DEFAULT = {
    "displacement": Quantity(lambda u: u, long_name="displacement along time", units="1"),
    "velocity": Quantity(lambda v: v, long_name="velocity along time", units="s-1"),
    "acceleration": Quantity(lambda a: a, long_name="acceleration along time", units="s-2"),
}


def named(quantities: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """The quantities with new names: the key is the long name, and ``PREFIX`` followed by the key is the name.

    Raises
    ------
    TypeError
        If they are not a mapping from names to quantities, or the mapping is empty.
    """
    if not isinstance(quantities, Mapping) or not quantities:
        raise TypeError(f"quantities must be a mapping from names to study.Quantity, not {quantities!r}.")
    for name, quantity in quantities.items():
        if not isinstance(quantity, Quantity):
            raise TypeError(f"quantities['{name}'] must be a study.Quantity, not {quantity!r}.")
    return {name: replace(q, name=f"{PREFIX}{name}", long_name=name) for name, q in quantities.items()}


@partial(jit, compiler=eqx.filter_jit)
def _evaluated(quantity, problem, t, u, v):
    return jax.vmap(lambda *arguments: jnp.atleast_1d(quantity.value(problem, *arguments)).astype(float))(t, u, v)


def values_along(quantity: Quantity, problem: Problem, solution: DenseSolution, times: Times) -> Values:
    """Values of a quantity at some times of a solution."""
    # in parts of one size, so that the compiled program does not depend on the number of times
    padded = np.append(times, np.full(-len(times) % AT_ONCE, times[-1]))
    u, v = solution.at(padded)
    unlabelled = problem.untitled()
    parts = [
        np.asarray(_evaluated(quantity, unlabelled, *(x[i : i + AT_ONCE] for x in (padded, u, v))))
        for i in range(0, len(padded), AT_ONCE)
    ]
    return np.concatenate(parts)[: len(times)]


def _peak(quantity: Quantity, problem: Problem, solution: DenseSolution, times: Times, values: Values) -> np.ndarray:
    """Largest absolute value of each component, among its samples and finer samples around the largest sample.

    The solution is smooth only between its points, so interpolation of the samples would miss the height of a peak.
    """
    peak = np.abs(values).max(axis=0)
    chunk = AT_ONCE // CLOSER
    for first in range(0, len(peak), chunk):
        component = np.arange(first, min(first + chunk, len(peak)))
        top = np.abs(values[:, component]).argmax(axis=0)
        near, place = np.broadcast_to(times[:, None], (len(times), len(component))), np.arange(len(component))
        for _ in range(REFINEMENTS):
            near = np.linspace(
                near[np.maximum(top - 1, 0), place], near[np.minimum(top + 1, len(near) - 1), place], CLOSER
            )
            all_values = values_along(quantity, problem, solution, near.ravel())
            sizes = np.abs(all_values.reshape(*near.shape, -1)[:, place, component])
            top = sizes.argmax(axis=0)
        peak[component] = np.maximum(peak[component], sizes.max(axis=0))
    return peak


def _check_finite(values: Values, times: Times, quantity: Quantity, problem: Problem) -> None:
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        t = times[np.argmin(finite)]
        name = quantity.long_name
        raise ValueError(f"the quantity '{name}' of '{problem.title}' is not finite at t = {t:g} of the reference.")


@dataclass(frozen=True)
class Target:
    """Reference of a quantity, and the scale of its errors.

    Attributes
    ----------
    quantity, problem, solution
        The quantity, the problem and its reference.
    times, values
        Times of the reference and times in between, and the quantity at these times, of shape (t, components).
    scale
        Scale of the error of each component, of shape (components,): :meth:`study.Quantity.scales`.
    """

    quantity: Quantity
    problem: Problem
    solution: DenseSolution
    times: Times
    values: Values
    scale: np.ndarray

    @property
    def sizes(self) -> np.ndarray:
        """Largest absolute value of each component along time, of shape (components,)."""
        return np.abs(self.values).max(axis=0)

    @cached_property
    def value(self) -> np.ndarray:
        """Reduced value of each component, or its largest absolute value along time, of shape (components,)."""
        return self.until(self.times[-1:])[0]

    @property
    def reached(self) -> np.ndarray:
        """Time at which each component has its value, of shape (components,); NaN for a root mean square."""
        if self.quantity.reduce == "rms":
            return np.full(self.value.shape, np.nan)
        last = self.quantity.reduce == "final"
        return np.where(last, self.times[-1], self.times[np.abs(self.values).argmax(axis=0)])

    def until(self, ends: Times) -> Values:
        """The reduced quantity of the reference from t = 0 to each of the ``ends``, of shape (ends, components)."""
        end_values = values_along(self.quantity, self.problem, self.solution, ends)
        if self.quantity.reduce == "final":
            return end_values
        before = np.searchsorted(self.times, ends, side="right") - 1
        if self.quantity.reduce == "rms":
            squares = self.values**2
            steps = np.diff(self.times)[:, None] * (squares[:-1] + squares[1:]) / 2
            total = np.cumsum(np.append(np.zeros_like(squares[:1]), steps, axis=0), axis=0)[before]
            remainder = (ends - self.times[before])[:, None] * (squares[before] + end_values**2) / 2
            return np.sqrt((total + remainder) / ends[:, None])
        sizes = np.abs(self.values)
        so_far = np.maximum(np.maximum.accumulate(sizes)[before], np.abs(end_values))
        return np.where(self.times[sizes.argmax(axis=0)] <= ends[:, None], self._peak, so_far)

    @cached_property
    def _peak(self) -> np.ndarray:
        return _peak(self.quantity, self.problem, self.solution, self.times, self.values)


def target(quantity: Quantity, problem: Problem, solution: DenseSolution, finer: int = FINER) -> Target:
    """The reference of a quantity, evaluated at ``finer`` times in each of its intervals, and the scale of its errors.

    Raises
    ------
    ValueError
        If the quantity is not finite along the reference, or zero at all times, or has another number of scales.
    """
    parts = np.arange(finer) / finer
    times = np.append((solution.t[:-1, None] + np.diff(solution.t)[:, None] * parts).ravel(), solution.t[-1])
    values = values_along(quantity, problem, solution, times)
    _check_finite(values, times, quantity, problem)
    if not values.any():
        raise ValueError(
            f"the quantity '{quantity.long_name}' of '{problem.title}' is zero at all times, so that an error relative "
            "to it has no meaning."
        )
    result = Target(quantity, problem, solution, times, values, np.abs(values).max(axis=0))
    reduced = result.value if quantity.reduce else result.sizes
    return replace(result, scale=quantity.scales(reduced, result.sizes))


class ErrorsAlong(Reduction):
    """Largest difference of each quantity from its reference over all steps, relative to the quantity's scale.

    A run is compared with the reference that begins where the run begins.

    Attributes
    ----------
    quantities, scales
        Quantities along time, and the scales of the errors of their components, each of shape (references, components).
    first
        Number of the first interval of each reference, of shape (references,).
    begin, length, coefficients
        Begin and length of the intervals of all references, of shape (intervals,), and coefficients of the quintics in
        them, of shape (intervals, 6, ...).
    """

    quantities: tuple[Quantity, ...]
    scales: tuple[jax.Array, ...]
    first: jax.Array
    begin: jax.Array
    length: jax.Array
    coefficients: jax.Array

    @classmethod
    def of(cls, *references: Sequence[Target]) -> "ErrorsAlong":
        """The observer for the targets of each reference solution, which have the same quantities."""
        tables = [_table(targets[0].solution) for targets in references]
        begin, length, coefficients = (np.concatenate(parts) for parts in zip(*tables, strict=True))
        # padded to a power of two, so that few programs are compiled; no step reaches the padding, which begins at ∞
        padding = 2 ** math.ceil(math.log2(len(length) + 1)) - len(length)
        numbers = (
            np.cumsum([0, *(len(table[0]) for table in tables[:-1])]),
            np.append(begin, np.full(padding, np.inf)),
            np.append(length, np.ones(padding)),
            np.append(coefficients, np.zeros((padding, *coefficients.shape[1:])), axis=0),
        )
        by_quantity = list(zip(*references, strict=True))
        scales = tuple(jnp.asarray(np.stack([target.scale for target in targets])) for targets in by_quantity)
        return cls(tuple(targets[0].quantity for targets in by_quantity), scales, *map(jnp.asarray, numbers))

    @property
    def variables(self) -> dict[str, dict[str, str]]:  # type: ignore[override]
        return {name: values for quantity in self.quantities for name, values in quantity.variables.items()}

    def start(self, problem, state):
        u, v = self.coefficients[self.first, 0], self.coefficients[self.first, 1]
        v = v / self.length[self.first].reshape(-1, *(1,) * (v.ndim - 1))
        distances = jnp.abs(u - state.u[None]) + jnp.abs(v - state.v[None])
        reference = jnp.argmin(distances.reshape(len(self.first), -1).sum(axis=1))
        scales = tuple(scale[reference] for scale in self.scales)
        return self.first[reference], scales, (jnp.zeros(()),) * len(self.quantities)

    def update(self, carried, problem, state, t, effort):
        place, scales, largest = carried
        # few steps cross two ends of intervals, so the loop seldom takes a turn
        place += (self.begin[place + 1] <= t).astype(place.dtype)
        place = lax.while_loop(lambda i: self.begin[i + 1] <= t, lambda i: i + 1, place)
        s = (t - self.begin[place]) / self.length[place]
        polynomial = tuple(self.coefficients[place])
        slope = tuple(k * coefficient for k, coefficient in enumerate(polynomial))[1:]
        exact = value(polynomial, s), value(slope, s) / self.length[place]
        errors = [
            jnp.max(jnp.abs(quantity.value(problem, t, state.u, state.v) - quantity.value(problem, t, *exact)) / scale)
            for quantity, scale in zip(self.quantities, scales, strict=True)
        ]
        # one array of all quantities would be computed entry by entry, twice as long for ensembles
        return place, scales, tuple(map(jnp.maximum, largest, errors))

    def result(self, carried, problem, state):
        return dict(zip(self.variables, carried[2], strict=True))


def _table(solution: DenseSolution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Begin, length and quintic of each interval of a solution, and a last interval that begins at ∞."""
    length = np.diff(solution.t)
    starts, ends = (tuple(x[part] for x in solution[1:]) for part in (slice(-1), slice(1, None)))
    table = np.stack(quintic(starts, ends, length.reshape(-1, *(1,) * (solution.u.ndim - 1))), axis=1)
    return (
        np.append(solution.t[:-1], np.inf),
        np.append(length, 1.0),
        np.append(table, np.zeros_like(table[:1]), axis=0),
    )


def _relative(deviation: np.ndarray, scale: np.ndarray | float) -> np.ndarray:
    """Absolute value of a deviation over its scale; over a scale of zero it is infinite, or zero without deviation."""
    with np.errstate(divide="ignore"):
        return np.divide(np.abs(deviation), scale, out=np.zeros(np.shape(deviation)), where=deviation != 0)


def observers(targets: Sequence[Target]) -> list[Observer]:
    """The observers for the errors of all targets of one reference."""
    along = [target for target in targets if target.quantity.reduce is None]
    return [*([ErrorsAlong.of(along)] if along else []), *(t.quantity for t in targets if t.quantity.reduce)]


def error(target: Target, runs: xr.Dataset, ends: Times) -> np.ndarray:
    """Errors of runs in a quantity, relative to the scale of its target, of shape (lanes,); NaN if a run failed.

    The error of a quantity along time is the largest difference at any step. A reduced quantity is compared with the
    reduced reference up to the end of the run, which ``ends`` gives for each lane.
    """
    values = runs[target.quantity.name].values
    if target.quantity.reduce is None:
        return values
    return _relative(values.reshape(len(ends), -1) - target.until(ends), target.scale).max(axis=1)


def difference(
    quantity: Quantity, problem: Problem, first: DenseSolution, second: DenseSolution
) -> tuple[float, Times]:
    """Difference of a quantity between two solutions, relative to its scale in ``first``, at the times of ``second``.

    Returns
    -------
    tuple
        First, the difference of the reduced quantities, or the largest difference along time if the quantity is not
        reduced. Second, the largest difference up to each time, of shape (t,), relative to the largest value along time
        if the quantity is reduced.
    """
    values, second_values = (values_along(quantity, problem, s, second.t) for s in (first, second))
    _check_finite(values, second.t, quantity, problem)
    sizes = np.abs(values).max(axis=0)
    scale = quantity.scales(sizes, sizes) if quantity.reduce is None else np.maximum(sizes.max(), np.finfo(float).tiny)
    along = np.maximum.accumulate(_relative(values - second_values, scale).max(axis=1))
    if quantity.reduce is None:
        return float(along[-1]), along
    first_target, second_target = (target(quantity, problem, s) for s in (first, second))
    return float(_relative(first_target.value - second_target.value, first_target.scale).max()), along
