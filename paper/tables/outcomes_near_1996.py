"""The smallest Δt/T at which runs of each scheme fail, by kind of failure."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import families
from paper.products import table

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
    enough = is_outcome(atlas, "accurate").all("amplitude")
    count = enough.cumprod("dt_over_period").sum("dt_over_period")
    return xr.DataArray(np.append(0.0, atlas.dt_over_period.values)[count.values], count.coords, count.dims)


def first_of(atlas: xr.Dataset, name: str) -> xr.DataArray:
    """Smallest Δt/T at which a run ends in the named way, over (problem, scheme); infinite if no run does."""
    met = is_outcome(atlas, name).any("amplitude")
    return met.dt_over_period.where(met, np.inf).min("dt_over_period")


def _with_problem(values: xr.DataArray) -> str:
    """The smallest value of all problems, and the first letter of its problem; a dash if the value is infinite."""
    least = values.min().item()
    return "–" if np.isinf(least) else f"{least:.2g} ({values.problem.values[int(np.argmin(values.values))][0]})"


@table(
    "First failures near the amplitudes of 1996", atlas="stability/atlas", requires={"atlas.amplitudes": some_near_1996}
)
def tabulate(atlas: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    near = near_1996(atlas)
    accurate, first = accurate_up_to(near), {title: first_of(near, name) for name, title in FAILURES.items()}
    rows = []
    for part in families(near).values():
        for name in part.scheme.values:
            up_to = accurate.sel(scheme=name)
            rows.append(
                {
                    "Scheme": part.scheme_title.sel(scheme=name).item(),
                    "1 % up to": "–" if up_to.min() == 0 else _with_problem(up_to),
                    **{title: _with_problem(values.sel(scheme=name)) for title, values in first.items()},
                }
            )
    return pd.DataFrame(rows)
