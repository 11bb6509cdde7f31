"""Errors of runs in the quantities that a user asks for."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jaxtyping import Float

from study.algebra.jit import jit
from study.assessment.solution import DenseSolution, Times
from study.mechanics.definition import Problem
from study.observer.motion import Quantity

#: Points between two of the reference at which a quantity is evaluated.
FINER = 8

#: Samples of a closer look at a peak, between those beside it, and looks, of which each is closer.
CLOSER, LOOKS = 65, 2

#: Times at which a quantity is evaluated at once.
AT_ONCE = 4096

#: Values of a quantity at some times, with an axis for its components.
Values = Float[np.ndarray, "t components"]

#: Before the names of quantities in a run, where they must not clash with those of other variables.
PREFIX = "quantity "

#: What is measured if nothing is asked for.
DEFAULT = {
    "displacement": Quantity(lambda u: u, long_name="displacement along time", units="1"),
    "velocity": Quantity(lambda v: v, long_name="velocity along time", units="s-1"),
}


def named(quantities: Mapping[str, Quantity] | None) -> dict[str, Quantity]:
    """The quantities with the names under which they are given, or those by default.

    Raises
    ------
    TypeError
        If they are no mapping from names to quantities.
    """
    if quantities is None:
        quantities = DEFAULT
    if not isinstance(quantities, Mapping) or not quantities:
        raise TypeError(f"quantities must be a mapping from names to study.Quantity, not {quantities!r}.")
    for name, quantity in quantities.items():
        if not isinstance(quantity, Quantity):
            raise TypeError(f"quantities['{name}'] must be a study.Quantity, not {quantity!r}.")
    return {name: replace(q, name=f"{PREFIX}{name}", long_name=name) for name, q in quantities.items()}


@partial(jit, compiler=eqx.filter_jit)
def _evaluated(quantity, problem, t, u, v):
    return jax.vmap(lambda *at: jnp.atleast_1d(quantity.value(problem, *at)).astype(float))(t, u, v)


def values_along(quantity: Quantity, problem: Problem, solution: DenseSolution, times: Times) -> Values:
    """Values of a quantity at some times of a solution."""
    # in parts of one size, so that the number of times is no part of what is compiled
    padded = np.append(times, np.full(-len(times) % AT_ONCE, times[-1]))
    u, v = solution.at(padded)
    unlabelled = problem.untitled()
    parts = [
        np.asarray(_evaluated(quantity, unlabelled, *(x[i : i + AT_ONCE] for x in (padded, u, v))))
        for i in range(0, len(padded), AT_ONCE)
    ]
    return np.concatenate(parts)[: len(times)]


def _peak(quantity: Quantity, problem: Problem, solution: DenseSolution, times: Times, values: Values) -> np.ndarray:
    """Largest size of each component: that of its samples, and of closer ones about the largest.

    The solution is smooth between its points only, so no curve through samples tells the height of a peak.
    """
    peak = np.abs(values).max(axis=0)
    together = AT_ONCE // CLOSER
    for first in range(0, len(peak), together):
        component = np.arange(first, min(first + together, len(peak)))
        top = np.abs(values[:, component]).argmax(axis=0)
        near, place = np.broadcast_to(times[:, None], (len(times), len(component))), np.arange(len(component))
        for _ in range(LOOKS):
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


class Target(NamedTuple):
    """What a quantity should be, and by what its errors are divided.

    Attributes
    ----------
    quantity
        The quantity.
    value
        Its reduction by the reference, of shape (components,); None along time.
    scale
        The largest size along time, or that of the reduction.
    """

    quantity: Quantity
    value: np.ndarray | None
    scale: float


def target(quantity: Quantity, problem: Problem, solution: DenseSolution) -> Target:
    """What the reference says about a quantity.

    Raises
    ------
    ValueError
        If the quantity is not finite along the reference, or zero all the time.
    """
    parts = np.arange(FINER) / FINER
    times = np.append((solution.t[:-1, None] + np.diff(solution.t)[:, None] * parts).ravel(), solution.t[-1])
    values = values_along(quantity, problem, solution, times)
    _check_finite(values, times, quantity, problem)
    largest = np.abs(values).max()
    if largest == 0:
        raise ValueError(
            f"the quantity '{quantity.long_name}' of '{problem.title}' is zero all the time, so that an error relative "
            "to it has no meaning."
        )
    if quantity.reduce == "peak":
        value = _peak(quantity, problem, solution, times, values)
        return Target(quantity, value, float(value.max()))
    if quantity.reduce == "rms":
        value = np.sqrt(np.trapezoid(values**2, times, axis=0) / times[-1])
        return Target(quantity, value, float(value.max()))
    return Target(quantity, values[-1] if quantity.reduce == "final" else None, float(largest))


def error(target: Target, problem: Problem, solution: DenseSolution, run: xr.Dataset) -> float:
    """Error of a run in a quantity, relative to its size; NaN if the run failed.

    Along time it is the largest difference at any sample.
    """
    got = run[target.quantity.name].values
    if run.status != 0:
        return np.nan
    if target.value is not None:
        return float(np.abs(np.atleast_1d(got) - target.value).max() / target.scale)
    times = np.minimum(run.t.values, solution.t[-1])
    wanted = values_along(target.quantity, problem, solution, times)
    return float(np.abs(got.reshape(len(times), -1) - wanted).max() / target.scale)


def difference(quantity: Quantity, problem: Problem, one: DenseSolution, other: DenseSolution) -> tuple[float, Times]:
    """Difference of a quantity between two solutions, and along time up to each point, relative to its size.

    They are compared at the times of the second one.

    Returns
    -------
    tuple
        The difference of the reductions, or the largest along time; and the largest up to each time, of shape (t,).
    """
    values, others = (values_along(quantity, problem, s, other.t) for s in (one, other))
    _check_finite(values, other.t, quantity, problem)
    scale = np.abs(values).max() or 1.0
    along = np.maximum.accumulate(np.abs(values - others).max(axis=1) / scale)
    if quantity.reduce is None:
        return float(along[-1]), along
    ends = [target(quantity, problem, s) for s in (one, other)]
    return float(np.abs(ends[0].value - ends[1].value).max() / ends[0].scale), along  # type: ignore[operator]
