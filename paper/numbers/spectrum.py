"""Numbers of the text: the step for the peak drift of oscillators that yield under a record."""

import xarray as xr

from paper.products import numbers
from study.words import span

#: Periods in s from which on the record, not the oscillator, is what a step has to resolve.
LONG = 0.5


def _multiples(steps: xr.DataArray) -> str:
    """Steps in words, from multiples of the spacing of the record."""
    multiples = span(steps, "g")
    return "the spacing of the record" if multiples == "1" else f"{multiples} times the spacing of the record"


@numbers(
    asks={"spectrum.schemes": ["average_acceleration", "rk4"], "spectrum.periods": [0.2, LONG]},
)
def of_spectrum(spectrum: xr.Dataset) -> dict:
    """Steps over the spacing of the record for long periods, and over the period for a short one."""
    needed = spectrum.step_needed
    average, rk4 = (needed.sel(scheme=name) for name in ("average_acceleration", "rk4"))
    long = spectrum.period >= LONG
    steps = average.where(long, drop=True)
    same = float(steps.min()) == float(steps.max())
    varies = f"{float(steps.max() / steps.min()):.0f}"
    lasts = f"{float(spectrum.period.max()) / LONG:.0f}"
    yields = spectrum.reduction > 1
    return {
        "spectrum_error": f"{100 * spectrum.allowed_error.item():g}",
        "spectrum_long": f"{LONG:g}",
        "spectrum_ductility": f"{float(spectrum.ductility.max()):.0f}",
        "record_sets_the_step": same,
        "spectrum_rule": "the record sets the step, not the period"
        if same
        else f"the step of average acceleration changes by a factor of {varies} where the period does by {lasts}",
        "spectrum_average": _multiples(steps / spectrum.spacing),
        "spectrum_rk4": _multiples(rk4.where(long, drop=True) / spectrum.spacing),
        "spectrum_average_elastic": span((0.2 / average.sel(period=0.2)).where(~yields, drop=True), ".0f"),
        "spectrum_average_yielding": span((0.2 / average.sel(period=0.2)).where(yields, drop=True), ".0f"),
        "spectrum_rk4_elastic": span((0.2 / rk4.sel(period=0.2)).where(~yields, drop=True), ".0f"),
        "spectrum_rk4_yielding": span((0.2 / rk4.sel(period=0.2)).where(yields, drop=True), ".0f"),
    }
