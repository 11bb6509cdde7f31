"""Motion of the α-method, whose energy grows on a softening spring (Figure 3 of the paper), and energies of all."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, curve_styles, empty, legend_below, letter
from paper.products import figure

SCHEME = "hht_alpha_1996"


@figure(
    "Figure 3 of Xie (1996): the α-method on the softening spring from the displacement 10 at eight steps per "
    "period. (a) Displacement; the band is the range of the exact motion. (b) The same run in the phase plane; the "
    "exact orbit is filled. (c) Energy of all schemes.",
    portrait="phase_portrait/softening_large",
    reference="reference/softening_large",
    requires={"phase_portrait.softening_large.schemes": [SCHEME]},
)
def draw(portrait: xr.Dataset, reference: xr.Dataset) -> Figure:
    """Displacement and orbit of the α-method, with the exact range and orbit in grey; energy of every scheme."""
    figure = empty(COLUMN, 10)
    grid = figure.add_gridspec(2, 2)
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
    for place, (name, look) in enumerate(curve_styles(portrait.scheme).items()):
        one = portrait.sel(scheme=name)
        height = 1 + one.energy_error
        marked = (0.02 + 0.03 * place, 0.2) if height.notnull().any() else None
        energy.plot(periods, height, label=one.scheme_title.item(), markevery=marked, **look)
    energy.set(xlabel="elapsed periods", ylabel="energy $E/E_0$", yscale="log")
    energy.set_ylim(bottom=1e-3)
    letter(energy, 2, "energy of all schemes")
    legend_below(figure, columns=3, axes=energy)
    return figure
