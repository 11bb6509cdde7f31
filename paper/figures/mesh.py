"""Times of an implicit and of an explicit scheme, against the frequencies of mesh and motion and against the error."""

import itertools

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles, letter, panels, whole_decades
from paper.products import figure

#: Markers of the panels, and their colours, which differ in greyscale.
LOOKS = (("o", "#000000"), ("s", "#0072B2"), ("^", "#D55E00"), ("D", "#E69F00"), ("v", "#CC79A7"))


@figure(
    "(a) Time that average acceleration needs for the peak displacement of a yielding panel over the time of central "
    "difference, against the highest frequency of the mesh over the frequency of the motion. Above one the explicit "
    "scheme is faster. (b) Time of a period against the error of the peak displacement, for the panel with the most "
    "unknowns, without and with a stiffer row."
)
def draw(mesh: xr.Dataset) -> Figure:
    """One curve per panel, with a point for each stiffness of one row; on one panel, curves over the steps tried."""
    picture, ((ratios, errors),) = panels(1, 2, PAGE, 7.0)
    names = [f"{rows} × {columns}" for rows, columns in zip(mesh.rows.values, mesh.columns.values, strict=True)]
    implicit, explicit = (
        mesh.seconds_per_period.sel(scheme=name) for name in ("average_acceleration", "central_difference")
    )
    for name, (marker, colour) in zip(dict.fromkeys(names), itertools.cycle(LOOKS), strict=False):
        ratio = (implicit / explicit).isel(case=np.array(names) == name)
        ratios.plot(ratio.mesh_ratio, ratio, marker=marker, color=colour, label=f"{name} masses")
    ratios.axhline(1, color="0.6", linewidth=0.8)
    ratios.set(xlabel="ω of the mesh / ω of the motion", ylabel="time, implicit / explicit")
    largest = mesh.isel(case=np.flatnonzero(mesh.unknowns == mesh.unknowns.max()))
    for factor, line in ((largest.stiffening.min(), "-"), (largest.stiffening.max(), "--")):
        case = largest.isel(case=np.flatnonzero(largest.stiffening == factor)[-1])
        for scheme, look in curve_styles(mesh.scheme).items():
            steps = case.sel(scheme=scheme)
            steps = steps.isel(tried=(steps.tried_peak_error > 0).values)
            label = f"{steps.scheme_title.item()}, row × {factor.item():,g}"
            errors.plot(steps.tried_peak_error, steps.tried_seconds, label=label, **{**look, "linestyle": line})
    errors.set(xlabel="error of the peak displacement", ylabel="time of a period (s)")
    name = f"{largest.rows.values[0]} × {largest.columns.values[0]} masses"
    for index, (ax, title) in enumerate(((ratios, "at an equal error"), (errors, name))):
        ax.set(xscale="log", yscale="log")
        whole_decades(ax)
        letter(ax, index, title)
        ax.legend(loc="upper center", bbox_to_anchor=(0.45, -0.22), ncols=2)
    return picture
