"""Number of roots of the effective equation in the double well, and the root that Newton's iteration finds."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from paper.figures.style import PAGE, curve_styles, letter, panels
from paper.products import figure
from paper.requirements import as_many

#: Colours of the tolerances of Newton's iteration.
COLOURS = ("#56B4E9", "#0072B2", "#000000")
#: Shades of the displacement found, without the lightest, which resembles the white of a missing root.
SHADES = ListedColormap(plt.get_cmap("cividis")(np.linspace(0, 0.85, 256)))
#: Place of the legends of the outer panels.
BELOW = {"loc": "upper left", "bbox_to_anchor": (0, -0.22)}


@figure(
    "Equation of a step in the double well. (a) Inside the curves it has three roots; grey: the step size of "
    "Figure 4 of Xie (1996). (b) The root that Newton's iteration finds for Houbolt's method, white where it "
    "finds none. (c) Steps until runs of average acceleration with different tolerances of that iteration differ.",
    roots="stability/roots",
    requires={"stability.roots.schemes": ["houbolt"], "stability.roots.tolerances": as_many(len(COLOURS))},
)
def draw(roots: xr.Dataset) -> Figure:
    """Regions with three roots, the root that Newton's iteration finds, and the steps until two runs differ."""
    figure, axes = panels(1, 3, PAGE, 6.8)
    several, found, together = axes[0]
    styles = curve_styles(roots.scheme)
    for scheme, style in styles.items():
        number = (roots.number_of_roots.sel(scheme=scheme) > 1).T
        line = {"colors": [style["color"]], "linestyles": [style["linestyle"]], "linewidths": 1.0}
        several.contour(roots.step_size, roots.predictor, number, levels=[0.5], **line)
    several.axvline(roots.paper_step_size.item(), color="0.6", linewidth=0.8)
    several.set(xlabel="step size Δt (s)", ylabel="predicted displacement", ylim=(-3, 3))
    named = zip(styles.values(), roots.scheme_title.values, strict=True)
    handles = [Line2D([], [], **style | {"marker": ""}, label=title) for style, title in named]
    several.legend(handles=handles, **BELOW)
    houbolt = roots.root.sel(scheme="houbolt").T
    picture = found.pcolormesh(roots.guess, roots.predictor, houbolt, cmap=SHADES, rasterized=True)
    figure.colorbar(picture, ax=found, label="displacement found")
    found.set(xlabel="displacement at which Newton starts", ylabel="predicted displacement")
    for start, dashes in zip(roots.start.values, ("-", ":"), strict=True):
        for tolerance, colour in zip(roots.newton_tolerance.values, COLOURS, strict=True):
            steps = roots.steps_together.sel(start=start, newton_tolerance=tolerance).clip(min=1)
            label = f"tolerance $10^{{{np.log10(tolerance):.0f}}}$" if dashes == "-" else None
            together.semilogy(roots.step_size, steps, dashes, color=colour, linewidth=0.9, label=label)
    together.plot([], [], ":", color="0.4", label="Newton starts from zero")
    together.set(xlabel="step size Δt (s)", ylabel="steps until two runs differ")
    together.legend(**BELOW)
    at_paper = f"Houbolt's root, Δt = {roots.paper_step_size.item():g} s"
    for index, title in enumerate(("three roots inside", at_paper, "average acceleration")):
        letter(axes[0, index], index, title)
    return figure
