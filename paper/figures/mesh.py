"""Time of an implicit over the time of an explicit scheme, against the frequencies of mesh and motion."""

import itertools

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, legend_below, panels, whole_decades
from paper.products import figure

#: Markers of the panels, and their colours, which differ in greyscale.
LOOKS = (("o", "#000000"), ("s", "#0072B2"), ("^", "#D55E00"), ("D", "#E69F00"), ("v", "#CC79A7"))


@figure(
    "Time that average acceleration needs for the peak displacement of a yielding panel over the time of central "
    "difference, against the highest frequency of the mesh over the frequency of the motion. Above one the explicit "
    "scheme is faster."
)
def draw(mesh: xr.Dataset) -> Figure:
    """One curve per panel; its points differ in the stiffness of one row."""
    picture, ((axes,),) = panels(1, 1, COLUMN, 6.5)
    names = [f"{rows} × {columns}" for rows, columns in zip(mesh.rows.values, mesh.columns.values, strict=True)]
    implicit, explicit = (
        mesh.seconds_per_period.sel(scheme=name) for name in ("average_acceleration", "central_difference")
    )
    for name, (marker, colour) in zip(dict.fromkeys(names), itertools.cycle(LOOKS), strict=False):
        ratio = (implicit / explicit).isel(case=np.array(names) == name)
        axes.plot(ratio.mesh_ratio, ratio, marker=marker, color=colour, label=f"{name} masses")
    axes.axhline(1, color="0.6", linewidth=0.8)
    axes.set(xscale="log", yscale="log", xlabel="ω of the mesh / ω of the motion", ylabel="time, implicit / explicit")
    whole_decades(axes)
    legend_below(picture, columns=2)
    return picture
