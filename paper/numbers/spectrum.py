"""Numbers of the text: steps that suffice for the peak drift of oscillators under records of ground motion."""

import numpy as np
import xarray as xr

from paper.products import numbers
from study.words import number, percent, span

#: Smallest period in s at which the record, not the oscillator, limits the step.
LONG = 1.0
#: Period in s at which the oscillator, not the record, limits the step.
SHORT = 0.2


def share_beyond(spectrum: xr.Dataset) -> xr.DataArray:
    """Share of the runs at periods of ``LONG`` and more that exceed the allowed error, by scheme and step."""
    kept = spectrum.error.sel(period=spectrum.period >= LONG) <= spectrum.allowed_error
    return 1 - kept.mean(["record", "period", "reduction"])


def share_at_the_spacing(spectrum: xr.Dataset) -> xr.DataArray:
    """Value of :func:`share_beyond` at a step equal to the spacing of the records, by scheme."""
    return share_beyond(spectrum).sel(step_size=spectrum.spacing, method="nearest")


def share_between(spectrum: xr.Dataset) -> xr.DataArray:
    """Mean of :func:`share_beyond` over incommensurate steps from half the spacing of the records to the spacing."""
    off = spectrum.commensurate == 0
    between = off & (spectrum.step_size > spectrum.spacing / 2) & (spectrum.step_size < spectrum.spacing)
    return share_beyond(spectrum).sel(step_size=between).mean("step_size")


def largest_steps(spectrum: xr.Dataset, error: float) -> xr.DataArray:
    """Largest step of each scheme at and below which all runs keep an error of the peak drift; NaN if there is none."""
    kept = (spectrum.error <= error).all(["record", "period", "reduction"])
    kept = kept.sortby("step_size").transpose("scheme", "step_size")
    holds = kept.copy(data=np.logical_and.accumulate(kept.values, axis=1))
    return holds.step_size.where(holds).max("step_size")


@numbers(
    requires={"spectrum.schemes": ["average_acceleration", "rk4"], "spectrum.periods": [SHORT, LONG]},
)
def of_spectrum(spectrum: xr.Dataset) -> dict:
    """Steps that suffice under all records, among commensurate and among all steps; shares of runs beyond the error."""
    needed = spectrum.step_needed.min(["record", "reduction"], skipna=False)
    at_spacing, between = share_at_the_spacing(spectrum), share_between(spectrum)
    found = {
        "spectrum_records": str(spectrum.sizes["record"]),
        "spectrum_stochastic": str(spectrum.sizes["record"] - 1),
        "spectrum_spacing": f"{1e3 * spectrum.spacing.item():g}",
        "spectrum_finest": f"{1e3 * spectrum.step_size.values[-1]:g}",
        "spectrum_coarsest": f"{1e3 * spectrum.step_size.values[0]:g}",
        "spectrum_ratio": percent((spectrum.step_size.values[:-1] / spectrum.step_size.values[1:]).max() - 1),
        "spectrum_error": f"{100 * spectrum.allowed_error.item():g}",
        "spectrum_long": f"{LONG:g}",
        "spectrum_short": f"{SHORT:g}",
        "spectrum_ductility": number(float(spectrum.ductility.max()), 2),
        "dividing_matters": bool((at_spacing < between).sel(scheme="average_acceleration")),
    }
    for short, scheme in (("average", "average_acceleration"), ("rk4", "rk4")):
        of_scheme = needed.sel(scheme=scheme)
        for name, tried in (("dividing", "commensurate"), ("any", "all")):
            long = of_scheme.sel(tried=tried, period=spectrum.period >= LONG)
            found[f"spectrum_{short}_{name}"] = span(1e3 * long, ".2g")
            found[f"spectrum_{short}_{name}_steps"] = span(long.period / long, ".0f")
            found[f"spectrum_{short}_{name}_short"] = f"{SHORT / of_scheme.sel(tried=tried, period=SHORT).item():.0f}"
        found[f"spectrum_{short}_at_spacing"] = percent(at_spacing.sel(scheme=scheme).item())
        found[f"spectrum_{short}_between"] = percent(between.sel(scheme=scheme).item())
    return found
