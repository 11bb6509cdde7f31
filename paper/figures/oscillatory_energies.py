"""The Fermi-Pasta-Ulam chain: exchange of oscillatory energy between stiff springs, and its sum over long times."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter, looks
from paper.products import figure

SPRINGS = (1, 2, 3)


def total(history: xr.Dataset) -> xr.DataArray:
    """The sum of the oscillatory energies."""
    return (
        history[[f"oscillatory_energy_{spring}" for spring in SPRINGS]]
        .to_dataarray("spring")
        .sum("spring", skipna=False)
    )


@figure(
    "Oscillatory energies of the stiff springs of the Fermi-Pasta-Ulam chain.",
    exchange="structure_history/energy_exchange",
    long_times="structure_history/long_times",
    asks={
        "structure_history.energy_exchange.problem": "fpu_chain",
        "structure_history.long_times.problem": "fpu_chain",
    },
)
def draw(exchange: xr.Dataset, long_times: xr.Dataset) -> Figure:
    """One panel per scheme with the energies of the springs and their sum, and one with the sums over long times."""
    names = exchange.scheme.values
    rows = -(-len(names) // 2) + 1
    figure = plt.figure(figsize=(PAGE, 0.25 * PAGE * rows))
    grid = figure.add_gridspec(rows, 2)
    first = None
    for index, name in enumerate(names):
        ax = first = figure.add_subplot(grid[divmod(index, 2)], sharex=first, sharey=first)
        one = exchange.sel(scheme=name)
        for spring, colour in zip(SPRINGS, ("#0072B2", "#D55E00", "#009E73"), strict=True):
            energy = f"oscillatory_energy_{spring}"
            ax.plot(one.t, one[energy], color=colour, linewidth=0.8, label=f"spring {spring}")
            ax.plot(one.t_reference, one[f"reference_{energy}"], ".", color=colour, markersize=1.5, alpha=0.5)
        ax.plot(one.t, total(one), color="black", linewidth=0.8, label="sum")
        ax.set_ylim(0, 1.5)
        letter(ax, index, one.scheme_title.item())
        ax.set_xlabel("time")
        if index % 2 == 0:
            ax.set_ylabel("oscillatory energy")
        if index == 0:
            ax.legend(ncols=4, loc="upper center", columnspacing=1.0, handlelength=1.2)
    ax = figure.add_subplot(grid[-1, :])
    styles = looks(long_times.scheme)
    for name in long_times.scheme.values:
        one = long_times.sel(scheme=name)
        ax.plot(one.t, total(one), label=one.scheme_title.item(), **{**styles[name], "marker": ""})
    ax.set(xlabel="time", ylabel="sum of the\noscillatory energies", ylim=(0, 1.4))
    ax.legend(ncols=4, loc="upper right")
    letter(ax, len(names), "over long times")
    return figure
