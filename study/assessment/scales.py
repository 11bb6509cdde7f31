"""Scales of errors: the values to which errors are relative, values of the reference, and remarks on scales."""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr

from study.assessment import oscillation
from study.assessment.certified import Certified
from study.assessment.errors import Target
from study.assessment.search import ENERGY
from study.assessment.solution import DenseSolution
from study.mechanics.definition import Problem
from study.observer.motion import Quantity
from study.warn import warn

#: Largest ratio of the components of a quantity, and of its largest value along time to its final value, without a
#: remark. Components below ``ROUND_OFF`` of the largest count as zero.
SPREAD, ROUND_OFF = 100.0, 1e-9

#: Relative difference of two values to which errors are relative that counts as none.
SAME = 1e-3

#: Number of parts of the duration for each of which the lowest and highest value of a quantity are kept.
PARTS = 400

#: Ratio of the largest values in the second and the first half of the time from which on a motion runs away.
RUNS_AWAY = 1e3
#: Smallest ratio of the energy at the start to the largest kinetic energy. Below this ratio, the balance of energies is
#: not assessed for a problem without a load.
LEAST_ENERGY = 0.01


class Measured(NamedTuple):
    """How a quantity is measured, and its value in the reference.

    Attributes
    ----------
    relative_to
        The value to which errors are relative, in words.
    units
        Unit of the quantity.
    value, time, scale
        Reduced value of each component, or its largest absolute value along time, the time in s at which it is reached,
        and the scale of its errors, each of shape (components,); NaN where there is none.
    along
        Times in s of shape (t,), and the quantity at these times, of shape (t, components); empty where there are none.
    scaled_from
        Time in s from which on a longer duration does not change the value to which errors are relative, to ``SAME``.
        It is infinite if a shorter run may have a larger error, and NaN if no law extends the error to longer runs, as
        of a quantity that is one value of the whole duration.
    """

    relative_to: str
    units: str = "1"
    value: np.ndarray = np.full(1, np.nan)
    time: np.ndarray = np.full(1, np.nan)
    scale: np.ndarray = np.full(1, np.nan)
    along: tuple[np.ndarray, np.ndarray] = (np.empty(0), np.empty((0, 1)))
    scaled_from: float = np.nan


def _band(quantity: Measured, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest value between each two edges, of the component with the largest ``value``; NaN without any."""
    t, values = quantity.along
    if not len(t):
        return (np.full(len(edges) - 1, np.nan),) * 2
    grid = np.union1d(t, edges)
    x = np.interp(grid, t, values[:, np.abs(quantity.value).argmax()], left=np.nan, right=np.nan)
    places = np.searchsorted(grid, edges)
    # both edges belong to a part, so that neighbouring parts touch
    ends = [x[places[:-1]], x[places[1:]]]
    low, high = (join.reduceat(x, places[:-1]) for join in (np.fmin, np.fmax))
    return np.fmin.reduce([low, *ends]), np.fmax.reduce([high, *ends])


def with_reference(ds: xr.Dataset, quantities: dict[str, Measured]) -> xr.Dataset:
    """The dataset of an assessment with the values of its quantities in the reference, over quantity and component."""
    most = max(len(quantity.value) for quantity in quantities.values())

    def padded(key: str) -> np.ndarray:
        parts = [np.asarray(getattr(quantities[name], key), float) for name in ds.quantity.values]
        return np.array([np.append(part, np.full(most - len(part), np.nan)) for part in parts])

    dims, uncertainty = ("quantity", "component"), ds.reference_uncertainty.values[:, None] * padded("scale")
    ordered = [quantities[name] for name in ds.quantity.values]
    edges = np.linspace(
        0.0, max((quantity.along[0][-1] for quantity in ordered if len(quantity.along[0])), default=1.0), PARTS + 1
    )
    low, high = np.array([_band(quantity, edges) for quantity in ordered]).swapaxes(0, 1)
    band = ("quantity", "reference_t"), "value of the reference within a part of the duration, largest component"
    value = "value of the quantity in the reference, its largest along time if it is not reduced"
    return ds.assign(
        reference_value=(dims, padded("value"), {"long_name": f"{value}; quantity_units has its unit"}),
        reference_value_uncertainty=(dims, uncertainty, {"long_name": "uncertainty of this value, in the same unit"}),
        reference_time=(dims, padded("time"), {"long_name": "time at which this value is reached", "units": "s"}),
        reference_low=(band[0], low, {"long_name": f"lowest {band[1]}; quantity_units has its unit"}),
        reference_high=(band[0], high, {"long_name": f"highest {band[1]}; quantity_units has its unit"}),
    ).assign_coords(
        reference_t=("reference_t", (edges[:-1] + edges[1:]) / 2, {"long_name": "middle of the part", "units": "s"}),
        component=("component", np.arange(most), {"long_name": "component of a quantity", "units": "1"}),
        relative_to=(
            "quantity",
            [quantity.relative_to for quantity in ordered],
            {"long_name": "value that scales the error"},
        ),
        scaled_from=(
            "quantity",
            [quantity.scaled_from for quantity in ordered],
            {"long_name": "time from which on the value that scales the error does not change", "units": "s"},
        ),
        quantity_units=("quantity", [quantity.units for quantity in ordered], {"long_name": "unit of the quantity"}),
    )


def scaled_from(quantity: Quantity | None, t: np.ndarray, values: np.ndarray) -> float:
    """``Measured.scaled_from`` of a quantity, None by default, with ``values`` (t, components) along its times."""
    if quantity is not None and quantity.reduce is not None:
        return np.nan
    if quantity is not None and isinstance(quantity.scale, tuple):
        return 0.0
    sizes = np.abs(values)
    peaks = sizes.max(axis=0)
    times = t[(sizes >= (1 - SAME) * peaks).argmax(axis=0)]
    return float(np.max(times if quantity is not None and quantity.scale == "each" else times[peaks.argmax()]))


def measured(reference: Certified, with_energy: bool, conservative: bool) -> dict[str, Measured]:
    """How each quantity is measured, and its value in the reference."""
    quantities = {
        name: Measured(
            target.quantity.relative_to(len(target.scale)),
            target.quantity.units,
            target.value,
            target.reached,
            target.scale,
            (target.times, target.values),
            scaled_from(target.quantity, target.times, target.values),
        )
        for name, target in reference.targets.items()
    }
    if with_energy:
        put_in = 0.0 if conservative else np.nan
        quantities[ENERGY] = Measured("relative to the energy that was put in", scaled_from=put_in)
    if reference.oscillation:
        quantities |= {
            name: Measured(relative_to, scaled_from=np.inf) for name, relative_to in oscillation.RELATIVE_TO.items()
        }
        period = np.atleast_1d(float(reference.oscillation.period))
        quantities["period"] = quantities["period"]._replace(units="s", value=period, scale=period)
    return quantities


def remark_on_components(name: str, sizes: np.ndarray, remedy: str) -> list[str]:
    """A remark, in a list, on components of very different size whose errors have one scale."""
    moving = np.flatnonzero(sizes > ROUND_OFF * sizes.max(initial=0.0))
    if not moving.size or sizes.max() <= SPREAD * sizes[moving].min():
        return []
    small, large = moving[sizes[moving].argmin()], sizes.argmax()
    count = int(np.sum(sizes[moving] < sizes.max() / SPREAD))
    return [
        f"{count} of {len(sizes)} components of '{name}' stay below a hundredth of the largest, down to "
        f"{sizes[small]:.2g} (component {small}) against {sizes[large]:.2g} (component {large}), and all errors are "
        f"relative to the largest: if units differ, {remedy}"
    ]


def remarks_on_scales(targets: Mapping[str, Target]) -> list[str]:
    """Remarks, with warnings, on quantities whose scale hides errors, is close to zero, or grows without end."""
    remarks = []
    for name, target in targets.items():
        first_half = np.abs(target.values[target.times <= target.times[-1] / 2]).max(initial=0.0)
        if 0 < first_half * RUNS_AWAY < target.sizes.max():
            remarks.append(
                f"'{name}' grows {target.sizes.max() / first_half:.1g}-fold in the second half of the time: the motion "
                "runs away, as in a collapse, and its errors are relative to its last values"
            )
        if target.quantity.scale in ("own", "peak"):
            remedy = f"study.Quantity(..., scale='each') as quantities['{name}'] gives each component its own scale"
            remarks += remark_on_components(
                name, np.abs(target.value) if target.quantity.scale == "own" else target.sizes, remedy
            )
        if target.quantity.reduce == "final" and target.quantity.scale in ("own", "each"):
            peaks = target.sizes if target.quantity.scale == "each" else np.full(len(target.scale), target.sizes.max())
            small = np.flatnonzero(target.scale < peaks / SPREAD)
            if small.size:
                last, largest = target.scale[small[0]], peaks[small[0]]
                remarks.append(
                    f"the final value of '{name}', {last:.2g}, is close to zero compared with its largest value along "
                    f"time, {largest:.2g}, and errors are relative to the final value: scale='peak' of study.Quantity "
                    "relates them to the largest value"
                )
    for remark in remarks:
        warn(f"{remark}.")
    return remarks


def lack_of_energy(problem: Problem, motion: DenseSolution) -> str:
    """A sentence if the energy at the start is too small to scale the errors of the balance of energies; else empty.

    It is also empty for a problem with a load, whose work counts in this scale.
    """
    if problem.load is not None:
        return ""
    start_energy = abs(float(problem.energy(problem.u0, problem.v0)))
    momenta = np.asarray(jax.lax.map(problem.momentum, jnp.asarray(motion.v)))
    kinetic = np.sum((motion.v * momenta).reshape(len(momenta), -1), axis=1).max() / 2
    if start_energy >= LEAST_ENERGY * kinetic:
        return ""
    return (
        f"the balance of energies of '{problem.title}' is left out: errors would be relative to the energy at the "
        f"start, {start_energy:g}, and the kinetic energy reaches {kinetic:g}; add a constant to the potential."
    )
