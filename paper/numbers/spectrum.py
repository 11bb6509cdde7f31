"""Numbers of the text: steps that suffice for the peak drift of oscillators under records of ground motion."""

import numpy as np
import xarray as xr

from paper.measures.shares import with_interval
from paper.measures.spectrum import LONG, beyond_at_the_spacing, beyond_between
from paper.products import numbers
from study.words import listed, number, percent, span

#: Period in s at which the oscillator, not the record, limits the step.
SHORT = 0.2


@numbers(
    requires={"spectrum.schemes": ["average_acceleration", "rk4"], "spectrum.periods": [SHORT, LONG]},
)
def spectrum_numbers(spectrum: xr.Dataset) -> dict:
    """Steps that suffice under all records, among commensurate and among all steps; shares of runs beyond the error."""
    needed = spectrum.largest_step_size.min(["record", "reduction"], skipna=False)
    # without the spacing itself, which is its first fraction and its first multiple
    ratios = np.sort(spectrum.step_size.values[spectrum.divides.values == 1]) / spectrum.spacing.item()
    ratios = ratios[~np.isclose(ratios, 1)]
    at_spacing, between = (of(spectrum, "average_acceleration") for of in (beyond_at_the_spacing, beyond_between))
    entries = {
        "spectrum_records": str(spectrum.sizes["record"]),
        "spectrum_stochastic": str(spectrum.sizes["record"] - 1),
        "spectrum_spacing": f"{1e3 * spectrum.spacing.item():g}",
        "spectrum_finest": f"{1e3 * spectrum.step_size.values[-1]:.2g}",
        "spectrum_coarsest": f"{1e3 * spectrum.step_size.values[0]:g}",
        "spectrum_fractions": listed(f"{1 / ratio:.0f}" for ratio in ratios[::-1] if ratio < 1),
        "spectrum_multiples": listed(f"{ratio:.0f}" for ratio in ratios if ratio > 1),
        "spectrum_ratio": percent((spectrum.step_size.values[:-1] / spectrum.step_size.values[1:]).max() - 1),
        "spectrum_reductions": listed(f"{reduction:g}" for reduction in spectrum.reduction.values if reduction > 1),
        "spectrum_damping": f"{100 * spectrum.damping_ratio.item():g}",
        "spectrum_error": f"{100 * spectrum.allowed_error.item():g}",
        "spectrum_long": f"{LONG:g}",
        "spectrum_short": f"{SHORT:g}",
        "spectrum_ductility": number(float(spectrum.ductility.max()), 2),
        "dividing_matters": bool(at_spacing.mean() < between.mean()),
    }
    for short, scheme in (("average", "average_acceleration"), ("rk4", "rk4")):
        sizes = needed.sel(scheme=scheme)
        for name, condition in (("dividing", "practice"), ("any", "any_step")):
            long = sizes.sel(condition=condition, period=spectrum.period >= LONG)
            entries[f"spectrum_{short}_{name}"] = span(1e3 * long, ".2g")
            entries[f"spectrum_{short}_{name}_steps"] = span(long.period / long, ".0f")
            entries[f"spectrum_{short}_{name}_short"] = (
                f"{SHORT / sizes.sel(condition=condition, period=SHORT).item():.0f}"
            )
        entries[f"spectrum_{short}_at_spacing"] = with_interval(beyond_at_the_spacing(spectrum, scheme))
        entries[f"spectrum_{short}_between"] = with_interval(beyond_between(spectrum, scheme))
    return entries
