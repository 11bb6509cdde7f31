"""Numbers of the text: the step for the peak drift of oscillators that yield under a record."""

import xarray as xr

from paper.products import numbers

#: Periods in s from which on the record, not the oscillator, is what a step has to resolve.
LONG = 0.5


def _span(values: xr.DataArray, digits: str) -> str:
    """The smallest and the largest value."""
    low, high = format(float(values.min()), digits), format(float(values.max()), digits)
    return low if low == high else f"{low} to {high}"


@numbers(
    spectrum="spectrum",
    asks={"spectrum.schemes": ["average_acceleration", "rk4"], "spectrum.periods": [0.2, LONG]},
)
def of_spectrum(spectrum: xr.Dataset) -> dict:
    """Steps over the spacing of the record for long periods, and over the period for a short one."""
    needed = spectrum.step_needed
    average, rk4 = (needed.sel(scheme=name) for name in ("average_acceleration", "rk4"))
    long = spectrum.period >= LONG
    yields = spectrum.reduction > 1
    return {
        "spectrum_error": f"{100 * spectrum.allowed_error.item():g}",
        "spectrum_long": f"{LONG:g}",
        "spectrum_ductility": f"{float(spectrum.ductility.max()):.0f}",
        "spectrum_average": _span(average.where(long, drop=True) / spectrum.spacing, "g"),
        "spectrum_rk4": _span(rk4.where(long, drop=True) / spectrum.spacing, "g"),
        "spectrum_average_elastic": _span((0.2 / average.sel(period=0.2)).where(~yields, drop=True), ".0f"),
        "spectrum_average_yielding": _span((0.2 / average.sel(period=0.2)).where(yields, drop=True), ".0f"),
        "spectrum_rk4_elastic": _span((0.2 / rk4.sel(period=0.2)).where(~yields, drop=True), ".0f"),
        "spectrum_rk4_yielding": _span((0.2 / rk4.sel(period=0.2)).where(yields, drop=True), ".0f"),
    }
