"""Overshoot of schemes without a stability limit: growth in a first step with large ωΔt, and largest overshoot."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import families
from paper.products import table
from study.words import number


def _class(scheme: xr.Dataset, start: str) -> str:
    """Powers of ωΔt with which displacement and velocity grow in a first step with large ωΔt, such as U0V1."""
    u, v = (round(scheme[f"growth_{quantity}_from_{start}"].item()) for quantity in "uv")
    return f"U{u}V{v}"


@table("Overshoot", requires={"spectral.damping_ratios": [0.0]})
def tabulate(spectral: xr.Dataset) -> pd.DataFrame:
    """One row per scheme that is unconditionally stable for linear systems."""
    free = spectral.sel(damping_ratio=0)
    rows = []
    for part in families(free.isel(scheme=np.flatnonzero(np.isinf(free.stability_limit)))).values():
        for name in part.scheme.values:
            scheme = part.sel(scheme=name)
            largest = (scheme[f"{one}_overshoot"].max().item() for one in ("displacement", "velocity"))
            rows.append(
                [scheme.scheme_title.item(), _class(scheme, "u"), _class(scheme, "v"), *(number(x, 2) for x in largest)]
            )
    return pd.DataFrame(rows, columns=["Scheme", "From u₀", "From u̇₀", "64 steps, u", "64 steps, u̇"])
