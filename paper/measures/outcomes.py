"""Outcomes of runs near the amplitudes of 1996, and steps that keep the energy at all amplitudes."""

import numpy as np
import xarray as xr

from study.sizes import largest_size

#: Factor up to which an amplitude larger or smaller than the amplitude of 1996 is near it.
SPAN = 3.0
#: Names of the failures among the outcomes of the maps.
FAILURES = ("damped_to_rest", "in_the_wrong_well", "chaotic", "growing", "no_solution_found", "unbounded")


def some_near_1996(exponents: dict) -> str:
    """Require that the maps have an amplitude near the amplitude of the paper."""
    amplitudes = np.linspace(exponents["first"], exponents["last"], exponents["count"])
    near = np.any(np.abs(amplitudes) <= np.log10(SPAN))
    return "" if near else f"has no amplitude within a factor of {SPAN:g} of the paper's; a claim on chaos needs one"


def near_1996(atlas: xr.Dataset) -> xr.Dataset:
    """The part of the maps whose amplitudes are near those of the paper."""
    return atlas.isel(amplitude=(atlas.amplitude >= 1 / SPAN) & (atlas.amplitude <= SPAN))


def is_outcome(atlas: xr.Dataset, name: str) -> xr.DataArray:
    """Whether each run ended in the named way."""
    return atlas.outcome == atlas.outcome.flag_meanings.split().index(name)


def fewest_steps(atlas: xr.Dataset, allowed_error: float) -> xr.DataArray:
    """Steps in a period that keep the energy at all amplitudes, as all larger numbers tried do, over (problem, scheme).

    NaN if the finest step of the maps does not keep it.
    """
    kept = (atlas.max_energy_error <= allowed_error).all("amplitude")
    largest = largest_size(kept, "step_size_over_period")
    steps = 1 / largest.where(largest > 0)
    return steps.copy(data=np.ceil(steps.values - 1e-9))


def most_steps(atlas: xr.Dataset) -> str:
    """Steps in a period of the finest step of the maps, in words for a step that would have to be finer."""
    return f"more than {1 / atlas.step_size_over_period.min().item():.0f}"
