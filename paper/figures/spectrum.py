"""Step sizes that suffice for the peak drift of elastic and yielding oscillators under records of ground motion."""

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from paper.data import with_schemes
from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels, thinned
from paper.measures.spectrum import LONG, share_beyond
from paper.products import figure

#: Two implicit schemes, one with damping, and two explicit ones.
SHOWN = ["average_acceleration", "central_difference", "rho_bathe", "rk4"]
#: Titles of the two panels of sufficient steps, by the kind of steps among which they were found.
CONDITIONS = {"practice": "commensurate steps", "any_step": "all steps"}


@figure(
    "Largest step that keeps the error of the peak drift under all records, elastic and yielding, against the period "
    "of the oscillator: (a) among steps that are commensurate with the spacing of the records, (b) among all steps. "
    "(c) Share of runs at long periods that exceed the error, at commensurate steps (markers) and at others (lines). "
    "Grey: a fiftieth of the period, and the spacing.",
)
def draw(spectrum: xr.Dataset) -> Figure:
    """Two panels of sufficient steps by period, and one of the share of runs that exceed the error, by step.

    The sufficient steps are found among all steps, or among the commensurate steps only.
    """
    spectrum = with_schemes(spectrum, SHOWN)
    spacing, curves = 1e3 * spectrum.spacing.item(), curve_styles(spectrum.scheme)
    figure, axes = panels(1, 3, PAGE, 5.6)
    *left, right = axes[0]
    left[1].sharey(left[0])
    needed = 1e3 * spectrum.largest_step_size.min(["record", "reduction"], skipna=False)
    for index, (ax, (condition, title)) in enumerate(zip(left, CONDITIONS.items(), strict=True)):
        ax.plot(spectrum.period, 1e3 * spectrum.period / 50, color="0.85", linestyle="-", linewidth=2.5, zorder=0)
        ax.axhline(spacing, color="0.85", linewidth=2.5, zorder=0)
        for place, (name, look) in enumerate(curves.items()):
            steps = needed.sel(scheme=name, condition=condition)
            if steps.notnull().any():
                sizes = {"linewidth": thinned(2.2, 0.5, place), "markersize": thinned(6, 1.3, place)}
                ax.plot(spectrum.period, steps, label=steps.scheme_title.item(), **look | sizes)
        ax.set(xscale="log", yscale="log", xlabel="period (s)")
        ax.yaxis.set_minor_formatter(NullFormatter())
        labelled = spectrum.period.values[:: -(-len(spectrum.period) // 4)]
        ax.set_xticks(labelled, [f"{period:g}" for period in labelled])
        ax.set_yticks(marks := [2, 5, 10, 20, 50], marks)
        letter(ax, index, title)
    left[0].set_ylabel("sufficient step (ms)")
    share, off = 100 * share_beyond(spectrum), spectrum.divides.values == 0
    for place, (name, look) in enumerate(curves.items()):
        shares, steps = share.sel(scheme=name), 1e3 * spectrum.step_size
        right.plot(steps[off], shares[off], **look | {"marker": ""})
        right.plot(steps[~off], shares[~off], **look | {"linestyle": "", "markersize": thinned(6, 1.3, place)})
    right.axvline(spacing, color="0.85", linewidth=2.5, zorder=0)
    right.set(xscale="log", xlabel="step (ms)", xlim=(spacing / 4.2, 4.2 * spacing))
    right.set_ylabel(f"runs beyond {100 * spectrum.allowed_error.item():g} % (%)")
    right.set_xticks(marks := [spacing * factor for factor in (0.25, 0.5, 1, 2, 4)], [f"{mark:g}" for mark in marks])
    letter(right, 2, f"periods of {LONG:g} s and more")
    for ax in axes[0]:
        ax.xaxis.set_minor_formatter(NullFormatter())
    legend_below(figure, columns=4)
    return figure
