"""The step that schemes need for the peak drift of oscillators that yield under a record."""

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from paper.data import of_kinds
from paper.figures.style import PAGE, legend_below, letter, looks, panels, thinned
from paper.products import figure

#: Two implicit schemes, of which one damps, and two explicit ones.
SHOWN = ["average_acceleration", "central_difference", "rho_bathe", "rk4"]


@figure(
    "Largest step that keeps the error of the peak drift of oscillators that yield under a record, by their "
    "period and by the strength over the elastic force. Grey: a tenth of the period (rising) and the spacing of "
    "the record (level). Curves that coincide lie over each other, from wide to thin.",
)
def draw(spectrum: xr.Dataset) -> Figure:
    """One panel per reduction of the strength; grey: a tenth of the period, and the spacing of the record."""
    spectrum = of_kinds(spectrum, SHOWN)
    number = spectrum.sizes["reduction"]
    figure, axes = panels(1, number, PAGE, 5.2, sharex=True, sharey=True)
    for index, (ax, reduction) in enumerate(zip(axes.flat, spectrum.reduction, strict=False)):
        of_reduction = spectrum.sel(reduction=reduction)
        ax.plot(spectrum.period, spectrum.period / 10, color="0.85", linestyle="-", linewidth=2.5, zorder=0)
        ax.axhline(spectrum.spacing.item(), color="0.85", linewidth=2.5, zorder=0)
        for place, (name, look) in enumerate(looks(spectrum.scheme).items()):
            needed = of_reduction.step_needed.sel(scheme=name)
            if needed.notnull().any():
                # the steps that were tried are few, so that curves coincide
                sizes = {"linewidth": thinned(2.6, 0.6, place), "markersize": thinned(7, 1.6, place)}
                ax.plot(spectrum.period, needed, label=needed.scheme_title.item(), **look | sizes)
        ax.set(xscale="log", yscale="log")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_minor_formatter(NullFormatter())
        labelled = spectrum.period.values[:: -(-len(spectrum.period) // 4)]
        ax.set_xticks(labelled, [f"{period:g}" for period in labelled])
        low, high = float(of_reduction.ductility.min()), float(of_reduction.ductility.max())
        ductility = f"{low:.1f}" + ("" if f"{low:.1f}" == f"{high:.1f}" else f" to {high:.1f}")
        letter(ax, index, "elastic" if reduction == 1 else f"strength 1/{reduction:g},\nductility {ductility}")
    axes[0, 0].set_ylabel("sufficient step (s)")
    for ax in axes[0]:
        ax.set_xlabel("period (s)")
    legend_below(figure, columns=4)
    return figure
