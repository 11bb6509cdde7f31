"""References of problems with a known motion."""

import numpy as np
import xarray as xr


def cosine(steps: int) -> xr.Dataset:
    """Reference of cos(2πt) as the pipeline writes it, one period in 64 × ``steps`` equal parts."""
    phase = np.linspace(0, 1, 64 * steps + 1)
    return xr.Dataset(
        {
            "u": ("t", np.cos(2 * np.pi * phase)),
            "v": ("t", -2 * np.pi * np.sin(2 * np.pi * phase)),
            "period": 1.0,
            "period_remainder": 0.0,
        },
        coords={"t": phase, "phase": ("t", phase)},
        attrs={"problem": "harmonic"},
    )
