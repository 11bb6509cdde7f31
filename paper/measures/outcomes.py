"""Outcomes of runs near the amplitudes of 1996."""

import numpy as np
import xarray as xr

from study.runs.needs import largest_size

#: Factor up to which an amplitude larger or smaller than the amplitude of 1996 is near it.
SPAN = 3.0
#: Title of the column of each failure, by the name of the outcome in the maps.
FAILURES = {
    "damped_to_rest": "Damped to rest",
    "in_the_wrong_well": "Wrong well",
    "chaotic": "Chaotic",
    "growing": "Growing",
    "no_solution_found": "No solution",
    "unbounded": "Unbounded",
}


def some_near_1996(exponents: dict) -> str:
    """Require that the maps have an amplitude near the amplitude of the paper."""
    amplitudes = np.linspace(exponents["first"], exponents["last"], exponents["count"])
    near = np.any(np.abs(amplitudes) <= np.log10(SPAN))
    return (
        "" if near else f"has no amplitude within a factor of {SPAN:g} of the paper's; the table of outcomes needs one"
    )


def near_1996(atlas: xr.Dataset) -> xr.Dataset:
    """The part of the maps whose amplitudes are near those of the paper."""
    return atlas.isel(amplitude=(atlas.amplitude >= 1 / SPAN) & (atlas.amplitude <= SPAN))


def is_outcome(atlas: xr.Dataset, name: str) -> xr.DataArray:
    """Whether each run ended in the named way."""
    return atlas.outcome == atlas.outcome.flag_meanings.split().index(name)


def accurate_up_to(atlas: xr.Dataset) -> xr.DataArray:
    """Largest Δt/T up to which all runs are accurate, over (problem, scheme); zero if there is none."""
    return largest_size(is_outcome(atlas, "accurate").all("amplitude"), "step_size_over_period")


def first_of(atlas: xr.Dataset, name: str) -> xr.DataArray:
    """Smallest Δt/T at which a run ends in the named way, over (problem, scheme); infinite if no run does."""
    met = is_outcome(atlas, name).any("amplitude")
    return met.step_size_over_period.where(met, np.inf).min("step_size_over_period")
