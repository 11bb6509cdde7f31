"""The α-method growing without bound on a softening spring (Figure 3 of the paper), beside the other schemes."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, legend_size, letter, looks
from paper.products import figure

SCHEME = "hht_alpha"


@figure(
    "Unbounded growth of the α-method on the softening spring.",
    portrait="phase_portrait/softening_large",
    reference="reference/softening_large",
    asks={"phase_portrait.softening_large.schemes": [SCHEME]},
)
def draw(portrait: xr.Dataset, reference: xr.Dataset) -> Figure:
    """Displacement and phase portrait of the α-method over the exact ones in grey; energy of every scheme."""
    figure, (history, plane, energy) = plt.subplots(1, 3, figsize=(PAGE, 0.32 * PAGE))
    run = portrait.sel(scheme=SCHEME)
    periods = portrait.t / reference.period
    history.plot(periods, run.u, color="black", linewidth=0.7)
    history.axhspan(-reference.u.max().item(), reference.u.max().item(), color="0.85", zorder=0)
    history.set(xlabel="elapsed periods", ylabel="displacement $u$")
    letter(history, 0, "α-method, history")
    plane.plot(run.u, run.v, color="black", linewidth=0.4, marker=".", markersize=2)
    plane.fill(reference.u, reference.v, color="0.85", zorder=0)
    plane.set(xlabel="displacement $u$", ylabel="velocity $\\dot u$ (1/s)")
    letter(plane, 1, "α-method, portrait")
    for name, look in looks(portrait.scheme).items():
        one = portrait.sel(scheme=name)
        energy.plot(periods, 1 + one.energy_error / 100, label=one.scheme_title.item(), markevery=(0.1, 0.3), **look)
    energy.set(xlabel="elapsed periods", ylabel="energy $E/E_0$", yscale="log")
    energy.set_ylim(bottom=1e-3)
    energy.legend(loc="upper left", bbox_to_anchor=(1, 1), fontsize=legend_size(portrait.sizes["scheme"], most=12))
    letter(energy, 2, "all schemes")
    return figure
