"""Scales of errors: the values to which errors are relative, values of the reference, and remarks on scales."""

import warnings
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

#: Largest ratio of the components of a quantity, and of its largest value along time to its final value, without a
#: remark. Components below ``ROUND_OFF`` of the largest count as zero.
SPREAD, ROUND_OFF = 100.0, 1e-9

#: Number of parts of the duration for each of which the lowest and highest value of a quantity are kept.
PARTS = 400

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
    """

    relative_to: str
    units: str = "1"
    value: np.ndarray = np.full(1, np.nan)
    time: np.ndarray = np.full(1, np.nan)
    scale: np.ndarray = np.full(1, np.nan)
    along: tuple[np.ndarray, np.ndarray] = (np.empty(0), np.empty((0, 1)))


def _band(one: Measured, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest value between each two edges, of the component with the largest ``value``; NaN without any."""
    t, values = one.along
    if not len(t):
        return (np.full(len(edges) - 1, np.nan),) * 2
    grid = np.union1d(t, edges)
    x = np.interp(grid, t, values[:, np.abs(one.value).argmax()], left=np.nan, right=np.nan)
    places = np.searchsorted(grid, edges)
    # both edges belong to a part, so that neighbouring parts touch
    ends = [x[places[:-1]], x[places[1:]]]
    low, high = (join.reduceat(x, places[:-1]) for join in (np.fmin, np.fmax))
    return np.fmin.reduce([low, *ends]), np.fmax.reduce([high, *ends])


def with_reference(ds: xr.Dataset, found: dict[str, Measured]) -> xr.Dataset:
    """The dataset of an assessment with the values of its quantities in the reference, over quantity and component."""
    most = max(len(one.value) for one in found.values())

    def padded(key: str) -> np.ndarray:
        parts = [np.asarray(getattr(found[name], key), float) for name in ds.quantity.values]
        return np.array([np.append(part, np.full(most - len(part), np.nan)) for part in parts])

    dims, off = ("quantity", "component"), ds.reference_uncertainty.values[:, None] * padded("scale")
    of_each = [found[name] for name in ds.quantity.values]
    edges = np.linspace(0.0, max((one.along[0][-1] for one in of_each if len(one.along[0])), default=1.0), PARTS + 1)
    low, high = np.array([_band(one, edges) for one in of_each]).swapaxes(0, 1)
    of_band = ("quantity", "reference_t"), "value of the reference within a part of the duration, largest component"
    value = "value of the quantity in the reference, its largest along time if it is not reduced"
    return ds.assign(
        reference_value=(dims, padded("value"), {"long_name": f"{value}; quantity_units has its unit"}),
        reference_value_uncertainty=(dims, off, {"long_name": "uncertainty of this value, in the same unit"}),
        reference_time=(dims, padded("time"), {"long_name": "time at which this value is reached", "units": "s"}),
        reference_low=(of_band[0], low, {"long_name": f"lowest {of_band[1]}; quantity_units has its unit"}),
        reference_high=(of_band[0], high, {"long_name": f"highest {of_band[1]}; quantity_units has its unit"}),
    ).assign_coords(
        reference_t=("reference_t", (edges[:-1] + edges[1:]) / 2, {"long_name": "middle of the part", "units": "s"}),
        component=("component", np.arange(most), {"long_name": "component of a quantity", "units": "1"}),
        relative_to=("quantity", [one.relative_to for one in of_each], {"long_name": "value that scales the error"}),
        quantity_units=("quantity", [one.units for one in of_each], {"long_name": "unit of the quantity"}),
    )


def measured(reference: Certified, of_energy: bool) -> dict[str, Measured]:
    """How each quantity is measured, and its value in the reference."""
    found = {
        name: Measured(
            one.quantity.relative_to(len(one.scale)),
            one.quantity.units,
            one.own,
            one.reached,
            one.scale,
            (one.times, one.values),
        )
        for name, one in reference.targets.items()
    }
    found |= {ENERGY: Measured("relative to the energy that was put in")} if of_energy else {}
    if reference.oscillation:
        found |= {name: Measured(relative_to) for name, relative_to in oscillation.RELATIVE_TO.items()}
        period = np.atleast_1d(float(reference.oscillation.period))
        found["period"] = found["period"]._replace(units="s", value=period, scale=period)
    return found


def remark_on_components(name: str, sizes: np.ndarray, remedy: str) -> list[str]:
    """A remark, in a list, on components of very different size whose errors have one scale."""
    moving = np.flatnonzero(sizes > ROUND_OFF * sizes.max(initial=0.0))
    if not moving.size or sizes.max() <= SPREAD * sizes[moving].min():
        return []
    small, large = moving[sizes[moving].argmin()], sizes.argmax()
    few = int(np.sum(sizes[moving] < sizes.max() / SPREAD))
    return [
        f"{few} of {len(sizes)} components of '{name}' stay below a hundredth of the largest, down to "
        f"{sizes[small]:.2g} (component {small}) against {sizes[large]:.2g} (component {large}), and all errors are "
        f"relative to the largest: if units differ, {remedy}"
    ]


def remarks_on_scales(targets: Mapping[str, Target]) -> list[str]:
    """Remarks, with warnings, on quantities whose scale hides errors, or is close to zero."""
    remarks = []
    for name, one in targets.items():
        if one.quantity.scale in ("own", "peak"):
            each = f"study.Quantity(..., scale='each') as quantities['{name}'] gives each component its own scale"
            remarks += remark_on_components(name, np.abs(one.own) if one.quantity.scale == "own" else one.sizes, each)
        if one.quantity.reduce == "final" and one.quantity.scale in ("own", "each"):
            peaks = one.sizes if one.quantity.scale == "each" else np.full(len(one.scale), one.sizes.max())
            small = np.flatnonzero(one.scale < peaks / SPREAD)
            if small.size:
                last, largest = one.scale[small[0]], peaks[small[0]]
                remarks.append(
                    f"the final value of '{name}', {last:.2g}, is close to zero compared with its largest value along "
                    f"time, {largest:.2g}, and errors are relative to the final value: scale='peak' of study.Quantity "
                    "relates them to the largest value"
                )
    for remark in remarks:
        warnings.warn(f"{remark}.", RuntimeWarning, stacklevel=3)
    return remarks


def lack_of_energy(problem: Problem, motion: DenseSolution) -> str:
    """A sentence if the energy at the start is too small to scale the errors of the balance of energies; else empty.

    It is also empty for a problem with a load, whose work counts in this scale.
    """
    if problem.load is not None:
        return ""
    at_start = abs(float(problem.energy(problem.u0, problem.v0)))
    momenta = np.asarray(jax.lax.map(problem.momentum, jnp.asarray(motion.v)))
    kinetic = np.sum((motion.v * momenta).reshape(len(momenta), -1), axis=1).max() / 2
    if at_start >= LEAST_ENERGY * kinetic:
        return ""
    return (
        f"the balance of energies of '{problem.title}' is left out: errors would be relative to the energy at the "
        f"start, {at_start:g}, and the kinetic energy reaches {kinetic:g}; add a constant to the potential."
    )
