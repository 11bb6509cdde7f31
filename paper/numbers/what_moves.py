"""Numbers of the text: what moves collapse intensity, drift and residual drift of a yielding mass with P-Δ."""

import numpy as np
import xarray as xr

from paper.products import numbers
from study.words import listed, number, percent, span

#: Quantities by the name of their variable, with their titles.
QUANTITIES = {
    "collapse_intensity": "collapse intensity",
    "peak_drift": "peak drift",
    "residual_drift": "residual drift",
}
#: Numbers of records that an engineer may choose.
CHOSEN = (20, 40)
#: Number of resamplings of the records, and percentiles of 95 % intervals.
RESAMPLED, INTERVAL = 2000, (2.5, 97.5)
#: Change of the answer for a single record that counts.
NOTICED = 0.01


def _resampled(values: np.ndarray, number: int) -> np.ndarray:
    """Records drawn with replacement, along the last axis: (..., resamplings, number)."""
    draws = np.random.default_rng(0).integers(values.shape[-1], size=(RESAMPLED, number))
    return values[..., draws]


def of_medians(quantity: xr.DataArray) -> xr.Dataset:
    """Relative change of the median over records by variant and period, with its 95 % interval over the records.

    The same records are drawn for both medians. A collapse counts as an infinite drift; records with a failed run are
    left out.
    """
    quantity = quantity.dropna("record")
    values = quantity.transpose("variant", "period", "record").values
    reference = list(quantity.variant.values).index("reference")
    medians = np.median(_resampled(values, values.shape[-1]), axis=-1)
    change = np.median(values, axis=-1) / np.median(values[reference], axis=-1) - 1
    low, high = np.percentile(medians / medians[reference] - 1, INTERVAL, axis=-1)
    dims = ("variant", "period")
    return xr.Dataset({"change": (dims, change), "low": (dims, low), "high": (dims, high)}, coords=quantity.coords)


def of_choices(quantity: xr.DataArray, number: int) -> xr.DataArray:
    """Half of the 95 % interval of the median over a choice of records, relative to the median over all, by period."""
    quantity = quantity.sel(variant="reference").dropna("record")
    values = quantity.transpose("period", "record").values
    low, high = np.percentile(np.median(_resampled(values, number), axis=-1), INTERVAL, axis=-1)
    return xr.DataArray(
        (high - low) / 2 / np.median(values, axis=-1), dims="period", coords={"period": quantity.period}
    )


def of_records(quantity: xr.DataArray) -> xr.DataArray:
    """Relative change of each single record; of a residual drift, relative to the median residual drift.

    The change is NaN if a run failed, and infinite if one of the two motions collapses.
    """
    reference = quantity.sel(variant="reference")
    scale = reference.median("record") if quantity.name == "residual_drift" else reference
    both = np.isinf(quantity) & np.isinf(reference)
    return (abs(quantity - reference) / scale.where(np.isfinite(scale), 1.0)).where(~both)


@numbers(moves="what_moves")
def of_what_moves(moves: xr.Dataset) -> dict:
    """Changes of medians and of single records by step, damping, strength and choice of records."""
    found = {
        "moves_runs": f"{int(moves.runs):,}",
        "moves_records": moves.sizes["record"],
        "moves_failed": int(moves.failed.sum()),
        "moves_spacing": f"{1e3 * moves.spacing.item():g}",
        "moves_parts": int(moves.parts),
        "moves_intensity": f"{moves.intensity.item():g}",
        "moves_periods": listed(f"{period:g}" for period in moves.period.values),
        "moves_chosen": listed(map(str, CHOSEN)),
    }
    smaller = []
    for name in QUANTITIES:
        quantity, short = moves[name], name.partition("_")[0]
        change = 100 * of_medians(quantity).change
        for variant in ("spacing", "two", "four", "damping", "strength"):
            found[f"moves_{short}_{variant}"] = span(change.sel(variant=variant), "+.1f").replace("-", "−")
        for count in CHOSEN:
            found[f"moves_{short}_choice_{count}"] = span(100 * of_choices(quantity, count), ".0f")
        single = of_records(quantity).sel(variant="spacing")
        beyond = (single > NOTICED).where(single.notnull())
        found[f"moves_{short}_single"] = percent(float(beyond.mean()))
        found[f"moves_{short}_worst"] = number(100 * float(single.where(np.isfinite(single)).max()), 2)
        smaller.append(abs(change.sel(variant="spacing")).max() < abs(change.sel(variant="damping")).min())
    found["moves_step_is_least"] = bool(np.all(smaller))
    return found
