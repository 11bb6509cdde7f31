"""What moves collapse intensity, drift and residual drift of a yielding mass with P-Δ: medians and single records."""

import numpy as np
import xarray as xr

from study.sizes import unbroken

#: Quantities by the name of their variable, with their titles.
QUANTITIES = {
    "collapse_intensity": "collapse intensity",
    "peak_drift": "peak drift",
    "residual_drift": "residual drift",
}
#: Numbers of records that an engineer may choose.
CHOSEN = (20, 40)
#: Variants with a longer step than the reference, in ascending order.
STEPS = ["spacing", "off", "two", "four"]
#: Number of resamplings of the records, and percentiles of 95 % intervals.
RESAMPLED, INTERVAL = 6000, (2.5, 97.5)
#: Share of single records that do not exceed a change.
SINGLE = 0.9


def _resampled(values: np.ndarray, number: int) -> np.ndarray:
    """Records drawn with replacement, along the last axis: (..., resamplings, number)."""
    draws = np.random.default_rng(0).integers(values.shape[-1], size=(RESAMPLED, number))
    return values[..., draws]


def without_drift(moves: xr.Dataset) -> list[float]:
    """Periods at which a median drift is a collapse, so that it has no change in percent."""
    return moves.period.values[~_known(moves.peak_drift).values].tolist()


def median_changes(quantity: xr.DataArray) -> xr.Dataset:
    """Relative change of the median over records by variant and period, with its 95 % interval over the records.

    The same records are drawn for both medians. A collapse counts as an infinite drift; records with a failed run are
    left out. A change is NaN at a period where the median of any variant is infinite.
    """
    quantity = quantity.dropna("record")
    values = quantity.transpose("variant", "period", "record").values
    reference = list(quantity.variant.values).index("reference")
    # one variant at a time, because all draws of a thousand records would take gigabytes
    medians = np.array([np.median(_resampled(variant, values.shape[-1]), axis=-1) for variant in values])
    with np.errstate(invalid="ignore"):
        change = np.median(values, axis=-1) / np.median(values[reference], axis=-1) - 1
        low, high = np.percentile(medians / medians[reference] - 1, INTERVAL, axis=-1)
    dims = ("variant", "period")
    changes = xr.Dataset({"change": (dims, change), "low": (dims, low), "high": (dims, high)}, coords=quantity.coords)
    return changes.where(_known(quantity))


def coarsest_step(quantity: xr.DataArray) -> float:
    """Longest step tried, over the spacing, at and below which the step moves the median less than damping does.

    The upper end of the 95 % interval of the change by the step is compared, at every period with a finite median. NaN
    if no step tried moves the median less.
    """
    medians = median_changes(quantity).dropna("period", subset=["change"])
    outer = np.maximum(abs(medians.low), abs(medians.high))
    less = (outer < abs(medians.change.sel(variant="damping"))).all("period") & bool(medians.sizes["period"])
    fine = unbroken(less.sel(variant=STEPS).values)
    return float(quantity.ratio.sel(variant=STEPS[fine.sum() - 1])) if fine.any() else np.nan


def _known(quantity: xr.DataArray) -> xr.DataArray:
    """Whether the medians of all variants are finite, by period."""
    return (abs(quantity.median("record")) < np.inf).all("variant")


def choice_spread(quantity: xr.DataArray, number: int) -> xr.DataArray:
    """Half of the 95 % interval of the median over a choice of records, relative to the median over all, by period."""
    known = _known(quantity)
    quantity = quantity.sel(variant="reference").dropna("record")
    values = quantity.transpose("period", "record").values
    with np.errstate(invalid="ignore"):
        low, high = np.percentile(np.median(_resampled(values, number), axis=-1), INTERVAL, axis=-1)
        half = (high - low) / 2 / np.median(values, axis=-1)
    return xr.DataArray(half, dims="period", coords={"period": quantity.period}).where(known)


def record_changes(quantity: xr.DataArray) -> xr.DataArray:
    """Relative change of each single record; of a residual drift, relative to the median residual drift.

    The change is NaN if a run failed, and infinite if one of the two motions collapses.
    """
    reference = quantity.sel(variant="reference")
    scale = reference.median("record") if quantity.name == "residual_drift" else reference
    both = np.isinf(quantity) & np.isinf(reference)
    return (abs(quantity - reference) / scale.where(np.isfinite(scale), 1.0)).where(~both)


def single_changes(quantity: xr.DataArray) -> xr.Dataset:
    """The change that ``SINGLE`` of the single records do not exceed, by variant and period, with its 95 % interval.

    The interval is exact for any distribution: its ends are changes of records. An end is NaN if the records are too
    few for it, and all are NaN where no record has a change.
    """
    from scipy.stats import quantile_test  # here, as the import takes long

    def quantile(changes: np.ndarray) -> np.ndarray:
        known = changes[~np.isnan(changes)]
        if not known.size:
            return np.full(3, np.nan)
        interval = quantile_test(known, p=SINGLE).confidence_interval()
        return np.array([np.quantile(known, SINGLE, method="inverted_cdf"), *interval])

    changes = record_changes(quantity)
    parts = xr.apply_ufunc(quantile, changes, input_core_dims=[["record"]], output_core_dims=[["part"]], vectorize=True)
    return parts.assign_coords(part=["change", "low", "high"]).to_dataset("part")
