"""Respects in which schemes are compared: cost at equal error, dissipation, stability and overshoot."""

import numpy as np
import xarray as xr

from study.runs.needs import NO_VALUE

#: Relative error of the displacement at which costs are compared. Steps per period at which damping is compared.
ALLOWED, RESOLVED = 0.01, 20


def costs(needs: xr.Dataset) -> xr.DataArray:
    """Force evaluations per time scale for the allowed error, over (problem, scheme); NaN if no step keeps it.

    The problems are those whose error is measured in the displacement.
    """
    cells = needs.sel(condition="practice", quantity="displacement", allowed_error=ALLOWED)
    measured = (cells.verdict != NO_VALUE).any("scheme").values
    return (cells.force_evaluations / cells.decided).isel(problem=measured).transpose("problem", "scheme")


def respects(costs_at: xr.DataArray, spectral: xr.Dataset) -> xr.DataArray:
    """Numbers that should be small, over (respect, scheme): costs, then properties in undamped linear theory.

    These properties are the spectral radius at infinite frequency, the damping of a resolved oscillation, the inverse
    of the stability limit, and the largest power of ωΔt with which the motion grows in a first step with large ωΔt.
    Radius and power are infinite for a scheme with a stability limit. A cost that is NaN in ``costs_at`` is infinite
    here.
    """
    free = spectral.sel(damping_ratio=0, scheme=costs_at.scheme.values)
    limited = np.isfinite(free.stability_limit)
    powers = [free[f"growth_{variable}_from_{start}"] for variable in "uv" for start in "uv"]
    rows = [
        free.infinite_frequency_radius.where(~limited, np.inf),
        abs(free.algorithmic_damping.sel(step_size_over_period=1 / RESOLVED, method="nearest")).round(9),
        1 / free.stability_limit,
        xr.concat(powers, "power").max("power").where(~limited, np.inf),
    ]
    numbers = [*costs_at.fillna(np.inf).values, *(row.values for row in rows)]
    return xr.DataArray(np.array(numbers), {"scheme": costs_at.scheme.values}, ["respect", "scheme"])
