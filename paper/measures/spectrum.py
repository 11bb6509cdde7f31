"""Runs under records that exceed the allowed error of the peak drift."""

import xarray as xr

#: Smallest period in s at which the record, not the oscillator, limits the step.
LONG = 1.0


def _beyond(spectrum: xr.Dataset) -> xr.DataArray:
    """Whether each run at a period of ``LONG`` or more exceeds the allowed error."""
    return ~(spectrum.peak_drift_error.sel(period=spectrum.period >= LONG) <= spectrum.allowed_error)


def share_beyond(spectrum: xr.Dataset) -> xr.DataArray:
    """Share of the runs at periods of ``LONG`` and more that exceed the allowed error, by scheme and step."""
    return _beyond(spectrum).mean(["record", "period", "reduction"])


def beyond_at_the_spacing(spectrum: xr.Dataset, scheme: str) -> xr.DataArray:
    """Whether each run of a scheme with a step equal to the spacing of the records exceeds the allowed error."""
    return _beyond(spectrum).sel(scheme=scheme).sel(step_size=spectrum.spacing, method="nearest")


def beyond_between(spectrum: xr.Dataset, scheme: str) -> xr.DataArray:
    """Whether each run with an incommensurate step from half the spacing to the spacing exceeds the allowed error."""
    off = spectrum.divides == 0
    between = off & (spectrum.step_size > spectrum.spacing / 2) & (spectrum.step_size < spectrum.spacing)
    return _beyond(spectrum).sel(scheme=scheme, step_size=between)
