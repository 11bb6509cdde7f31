"""Respects in which schemes are compared: cost at equal error, dissipation, stability and overshoot."""

import numpy as np
import xarray as xr

#: Relative error of the displacement at which costs are compared. Steps per period at which damping is compared.
ALLOWED, RESOLVED = 0.01, 20
#: Relative and absolute tolerance within which two numbers count as equal.
EQUAL = 1e-6


def _forces(runs: xr.Dataset, error: str) -> xr.DataArray:
    """Fewest force evaluations per period with a step at and below which all steps tried keep the allowed error."""
    fine = runs.sortby("steps_per_period", ascending=False)
    kept = (fine[error] <= ALLOWED).astype(int).cumprod("steps_per_period")
    return (fine.steps_per_period * fine.force_evaluations_per_step).where(kept == 1).min("steps_per_period")


def costs(kinks: xr.Dataset, structures: xr.Dataset) -> xr.DataArray:
    """Force evaluations per period for the allowed error, over (problem, scheme); NaN if the finest step exceeds it.

    The schemes are those that both datasets have.
    """
    common = [name for name in kinks.scheme.values if name in structures.scheme.values]
    parts = [_forces(kinks.sel(scheme=common), "error"), _forces(structures.sel(scheme=common), "displacement_error")]
    return xr.concat(parts, "problem", coords="minimal", compat="override").transpose("problem", "scheme")


def respects(costs_at: xr.DataArray, spectral: xr.Dataset) -> xr.DataArray:
    """Numbers that should be small, over (respect, scheme): costs, then properties in undamped linear theory.

    These properties are the spectral radius at infinite frequency, the damping of a resolved oscillation, the inverse
    of the stability limit, and the largest power of ωΔt with which the motion grows in a first step with large ωΔt.
    Radius and power are infinite for a scheme with a stability limit. A cost that is NaN in ``costs_at`` is infinite
    here.
    """
    free = spectral.sel(damping_ratio=0, scheme=costs_at.scheme.values)
    limited = np.isfinite(free.stability_limit)
    powers = [free[f"growth_{one}_from_{start}"] for one in "uv" for start in "uv"]
    rows = [
        free.infinite_frequency_radius.where(~limited, np.inf),
        abs(free.algorithmic_damping.sel(dt_over_period=1 / RESOLVED, method="nearest")).round(9),
        1 / free.stability_limit,
        xr.concat(powers, "power").max("power").where(~limited, np.inf),
    ]
    numbers = [*costs_at.fillna(np.inf).values, *(row.values for row in rows)]
    return xr.DataArray(np.array(numbers), {"scheme": costs_at.scheme.values}, ["respect", "scheme"])


def dominated_by(of: xr.DataArray, scheme: str) -> list[str]:
    """Schemes that are at least as good as ``scheme`` in every respect, and better in at least one."""
    own = of.sel(scheme=scheme).values

    def better(other: np.ndarray) -> bool:
        with np.errstate(invalid="ignore"):  # two infinities are equal
            close = np.isclose(other, own, rtol=EQUAL, atol=EQUAL)
        return bool(((other < own) | close).all() and ((other < own) & ~close).any())

    return [name for name in of.scheme.values if name != scheme and better(of.sel(scheme=name).values)]
