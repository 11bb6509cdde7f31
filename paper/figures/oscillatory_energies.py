"""The Fermi-Pasta-Ulam chain: exchange of oscillatory energy between stiff springs, and its sum over long times."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles, empty, legend_below, letter
from paper.products import figure

SPRINGS = (1, 2, 3)
#: Colour, line and marker of each spring.
STYLES = (("#0072B2", "--", "s"), ("#D55E00", "-.", "v"), ("#009E73", ":", "^"))


def total(history: xr.Dataset) -> xr.DataArray:
    """The sum of the oscillatory energies of all stiff springs."""
    energies = history[[f"oscillatory_energy_{spring}" for spring in SPRINGS]]
    return energies.to_dataarray("spring").sum("spring", skipna=False)


@figure(
    "Oscillatory energies of the stiff springs of the Fermi-Pasta-Ulam chain. Upper panels: their exchange and "
    "their sum; markers: the reference. Last panel: the sum over long times.",
    exchange="structure_history/energy_exchange",
    long_times="structure_history/long_times",
    requires={
        "structure_history.energy_exchange.problem": "fpu_chain",
        "structure_history.long_times.problem": "fpu_chain",
    },
)
def draw(exchange: xr.Dataset, long_times: xr.Dataset) -> Figure:
    """One panel per scheme with the energies of the springs and their sum; a last panel with sums over long times."""
    names = exchange.scheme.values
    figure = empty(PAGE, 9.5)
    grid = figure.add_gridspec(2, len(names))
    first = None
    for index, name in enumerate(names):
        ax = figure.add_subplot(grid[0, index], sharex=first, sharey=first)
        first = first or ax
        one = exchange.sel(scheme=name)
        for spring, (colour, line, marker) in enumerate(STYLES, start=1):
            energy = f"oscillatory_energy_{spring}"
            ax.plot(one.t, one[energy], color=colour, linestyle=line, linewidth=0.8, label=f"spring {spring}")
            exact = one[f"reference_{energy}"]
            every = max(len(exact) // 10, 1)
            ax.plot(one.t_reference, exact, marker, color=colour, markersize=3, markerfacecolor="none", markevery=every)
        ax.plot(one.t, total(one), color="black", linestyle="-", linewidth=1.2, label="sum")
        ax.plot([], [], "s", color="0.5", markersize=3, markerfacecolor="none", label="markers: exact")
        ax.set(ylim=(0, 1.5), xlabel="elapsed time $t$ (s)")
        letter(ax, index, one.scheme_title.item())
        ax.tick_params(labelleft=index == 0)
    figure.axes[0].set_ylabel("oscillatory energy")
    ax = figure.add_subplot(grid[1, :])
    for name, look in curve_styles(long_times.scheme).items():
        one = long_times.sel(scheme=name)
        ax.plot(one.t, total(one), label=one.scheme_title.item(), **look | {"marker": ""})
    ax.set(xlabel="elapsed time $t$ (s)", ylabel="sum of the\noscillatory energies", ylim=(0, 1.4))
    letter(ax, len(names), "over long times")
    ax.legend(loc="center right", ncols=2)
    legend_below(figure, columns=5)
    return figure
