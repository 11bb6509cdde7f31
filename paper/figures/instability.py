"""Motion of the α-method, whose energy grows on a softening spring (Figure 3 of the paper), and energies near by."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, curve_styles, empty, legend_below, letter, whole_decades
from paper.products import figure

SCHEME = "hht_alpha_1996"
#: Scheme whose energy is left out; it is damped away first.
LEFT_OUT = "houbolt"


@figure(
    "Figure 3 of Xie (1996): the α-method on the softening spring from the displacement 10 at eight steps per "
    "period. (a) Displacement; the band is the range of the exact motion. (b) The same run in the phase plane; the "
    "exact orbit is filled. (c) Energy of the schemes, without Houbolt's method. (d) Share of the runs at close "
    "steps, from starts that differ by round-off, whose largest energy does not exceed a value.",
    portrait="phase_portrait/softening_large",
    reference="reference/softening_large",
    window="step_window",
    requires={
        "phase_portrait.softening_large.schemes": [SCHEME],
        "step_window.problem": "softening_large",
        "step_window.schemes": [SCHEME],
    },
)
def draw(portrait: xr.Dataset, reference: xr.Dataset, window: xr.Dataset) -> Figure:
    """Displacement and orbit of the α-method, with the exact range and orbit in grey; energies of the schemes."""
    figure = empty(COLUMN, 11.5)
    grid = figure.add_gridspec(3, 2)
    history, plane = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
    energy = figure.add_subplot(grid[1, :])
    run = portrait.sel(scheme=SCHEME)
    periods = portrait.t / reference.period
    history.plot(periods, run.u, color="black", linewidth=0.7)
    history.axhspan(-reference.u.max().item(), reference.u.max().item(), color="0.8", zorder=0)
    history.set(xlabel="elapsed periods", ylabel="displacement $u$")
    letter(history, 0, "α-method along time")
    plane.plot(run.u, run.v, color="black", linewidth=0.4, marker=".", markersize=2)
    plane.fill(reference.u, reference.v, color="0.8", zorder=0)
    plane.set(xlabel="displacement $u$", ylabel="velocity $\\dot u$ (1/s)")
    letter(plane, 1, "its phase portrait")
    looks = curve_styles(portrait.scheme)
    for place, name in enumerate(name for name in looks if name != LEFT_OUT):
        look = looks[name]
        motion = portrait.sel(scheme=name)
        height = 1 + motion.energy_error
        marked = (0.02 + 0.03 * place, 0.2) if height.notnull().any() else None
        energy.plot(periods, height, label=motion.scheme_title.item(), markevery=marked, **look)
    energy.set(xlabel="elapsed periods", ylabel="energy over\nits initial value", yscale="log")
    energy.set_ylim(bottom=1e-3)
    letter(energy, 2, "energy of the schemes")
    close = figure.add_subplot(grid[2, :])
    for name in window.scheme.values:
        largest = np.sort(1 + window.largest_gain.sel(scheme=name).values, axis=None)
        look = {key: looks[name][key] for key in ("color", "linestyle")}
        close.plot(largest, np.arange(1, largest.size + 1) / largest.size, **look)
    close.set(xlabel="largest energy over the initial energy", ylabel="share of runs", xscale="log")
    whole_decades(close)
    letter(close, 3, "runs at close steps and starts")
    legend_below(figure, columns=2, axes=energy)
    return figure
