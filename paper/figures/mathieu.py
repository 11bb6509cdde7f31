"""Tongues of instability of Mathieu's equation, as the schemes find them."""

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure

SHADE = "0.85"


@figure(
    "Mathieu's equation. (a) The highest tongue of instability at the coarsest step; grey: theory. A curve begins "
    "where the tongue of the scheme opens. (b) Distance of the middle of this tongue from theory, at the largest ε."
)
def draw(mathieu: xr.Dataset) -> Figure:
    """The tongue in the plane of δ and ε, and its shift by step size."""
    figure, axes = panels(1, 2, PAGE, 6.8)
    plane, shift = axes[0]
    last = mathieu.isel(tongue=-1)
    exact, coarsest = last.exact_edge, last.edge.isel(steps_per_period=0)
    plane.fill_betweenx(last.epsilon, *exact.transpose("side", "epsilon"), color=SHADE, linewidth=0)
    widest = last.isel(epsilon=-1)
    moved = abs((widest.edge - widest.exact_edge).mean("side", skipna=False))
    handles: list[Artist] = [Patch(color=SHADE, label="theory")]
    for name, look in curve_styles(mathieu.scheme).items():
        line = {key: look[key] for key in ("color", "linestyle")}
        for side in last.side.values:
            plane.plot(coarsest.sel(scheme=name, side=side), last.epsilon, **line)
        shift.loglog(mathieu.steps_per_period, 100 * moved.sel(scheme=name) / widest.exact_edge.mean("side"), **look)
        handles.append(Line2D([], [], **look, label=mathieu.scheme_title.sel(scheme=name).item()))
    plane.set(xlabel="stiffness δ", ylabel="amplitude ε", ylim=(0, None))
    shift.set(xlabel="steps per period", ylabel="shift of the tongue (%)")
    steps = mathieu.steps_per_period.values
    shift.set_xticks(steps, [f"{number:g}" for number in steps])
    shift.set_xticks([], minor=True)
    letter(plane, 0, f"tongue {last.tongue.item()}, {np.min(steps)} steps per period")
    letter(shift, 1, f"tongue {last.tongue.item()}, ε = {widest.epsilon.item():g}")
    legend_below(figure, columns=6, handles=handles)
    return figure
