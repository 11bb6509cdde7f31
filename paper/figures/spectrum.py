"""The step that schemes need for the peak drift of oscillators that yield under a record."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from paper.figures.style import PAGE, letter, looks
from paper.products import figure


@figure("Step that keeps the peak drift of yielding oscillators under a record within an error.", spectrum="spectrum")
def draw(spectrum: xr.Dataset) -> Figure:
    """One panel per reduction of the strength; grey: a tenth of the period, and the spacing of the record."""
    columns = 2
    rows = -(-spectrum.sizes["reduction"] // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(PAGE, rows * 0.3 * PAGE), sharex=True, sharey=True, squeeze=False
    )
    for index, (ax, reduction) in enumerate(zip(axes.flat, spectrum.reduction, strict=False)):
        of_reduction = spectrum.sel(reduction=reduction)
        ax.plot(spectrum.period, spectrum.period / 10, color="0.8", linewidth=2.5, zorder=0)
        ax.axhline(spectrum.spacing.item(), color="0.8", linewidth=2.5, zorder=0)
        for name, look in looks(spectrum.scheme).items():
            needed = of_reduction.step_needed.sel(scheme=name)
            if needed.notnull().any():
                ax.plot(spectrum.period, needed, label=needed.scheme_title.item(), **look)
        ax.set(xscale="log", yscale="log")
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set_xticks(spectrum.period, [f"{period:g}" for period in spectrum.period.values])
        low, high = float(of_reduction.ductility.min()), float(of_reduction.ductility.max())
        ductility = f"ductility {low:.1f}" + ("" if f"{low:.1f}" == f"{high:.1f}" else f" to {high:.1f}")
        letter(ax, index, "elastic" if reduction == 1 else f"elastic force over strength {reduction:g}, {ductility}")
    for ax in axes[:, 0]:
        ax.set_ylabel("step that suffices, s")
    for ax in axes[-1]:
        ax.set_xlabel("period, s")
    for ax in axes.flat[spectrum.sizes["reduction"] :]:
        ax.remove()
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=5)
    return figure
