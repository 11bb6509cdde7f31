"""Figures of the page of an assessment, as SVG."""

import io
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from study.analysis.outcomes import Outcome
from study.words import printed_unit, text_of

#: Colours of curves, which differ in greyscale and for the colour-blind.
COLOURS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
#: Markers of curves. With seven colours and ten markers, each of 70 curves has its own pair of colour and marker.
MARKERS = "osD^vPX<>*"
#: Colour of the curves that are not emphasised.
PALE = "0.75"

#: Largest error that is drawn.
WORST = 10.0

#: Number of points of a curve per octave of steps or times; each point is the largest error in its part of the octave.
IN_OCTAVE = 8

#: Grey level of each outcome in a map, from the best to the worst outcome.
SHADES = np.linspace(1.0, 0.25, len(Outcome))
#: Colour of the letter of each outcome.
INK = np.where(SHADES > 0.5, "black", "white")
#: Letter of each outcome.
LETTERS = ("", "b", "r", "w", "c", "g", "s", "N", "∞")


def svg_of(figure) -> str:
    """A figure of matplotlib as SVG for a page."""
    text = io.StringIO()
    figure.draw_without_rendering()  # a constrained layout takes two passes where labels of ticks change their width
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]


def figure_of(svg: str, caption: str) -> str:
    """A figure of HTML with its caption, or a sentence if ``svg`` is empty."""
    if not svg:
        return "<p>No run has an error above zero.</p>"
    return f'<figure><div class="scroll">{svg}</div><figcaption>{text_of(caption)}</figcaption></figure>'


def times_of_runs(assessed: xr.Dataset) -> xr.DataArray:
    """Times of all runs: ``seconds_per_run``, or the number of steps times the time of a step if it is missing."""
    return assessed.seconds_per_run if "seconds_per_run" in assessed else assessed.seconds_per_step * assessed.steps


def motion(quantity: xr.Dataset) -> str:
    """The reference of a quantity along time, with its largest value as a point, as HTML; empty if it has no motion."""
    from matplotlib.figure import Figure

    low, high = quantity.reference_low.values, quantity.reference_high.values
    if not np.isfinite(low).any():
        return ""
    name = quantity.quantity.item()
    figure = Figure(figsize=(5.4, 2.2), layout="constrained")
    axes = figure.subplots()
    axes.fill_between(quantity.reference_t, low, high, color="black", lw=0.9)
    largest = quantity.isel(component=int(abs(quantity.reference_value).fillna(0).argmax("component")))
    if largest.reference_time.notnull():
        index = np.abs(quantity.reference_t.values - largest.reference_time.item()).argmin()
        axes.plot(largest.reference_time, max(low[index], high[index], key=abs), "o", color=COLOURS[2], ms=6)
    unit = "" if quantity.quantity_units.item() == "1" else f", {printed_unit(quantity.quantity_units.item())}"
    axes.set(xlabel="t, s", ylabel=f"{name}{unit}", xlim=(0, None))
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    component = f", component {largest.component.item()}" if quantity.reference_value.count() > 1 else ""
    return figure_of(svg_of(figure), f"Reference of {name}{component}, and its largest value as a point.")


def _label(axis) -> None:
    """Label a logarithmic axis at powers of ten, and at twice and five times these on less than two decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    close = high < 100 * low
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if close else (1.0,)))
    axis.set_minor_formatter(NullFormatter())
    if close:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def curves(
    assessed: xr.Dataset,
    along: xr.DataArray,
    label: str,
    values: xr.DataArray,
    ylabel: str,
    limits: Sequence[float] = (),
    emphasised: Sequence[str] | None = None,
    stable: xr.DataArray | None = None,
    order: Sequence[str] = (),
    joined: bool = True,
) -> str:
    """Values of every scheme against the step sizes or times of its runs, as SVG; empty if there is nothing to draw.

    Schemes that are not ``emphasised`` are grey; by default none is. Colours follow from the place in ``order``, by
    default of the emphasised schemes, so that figures with one order agree. A dotted line marks the step of each
    emphasised scheme in ``stable``, its limit of stability. Points are not ``joined`` if their places along the axis
    scatter, as the times of single runs do.
    """
    from matplotlib.figure import Figure

    names = assessed.scheme.values.tolist()
    strong = names if emphasised is None else list(emphasised)
    # narrow, so that a phone does not shrink the letters
    figure = Figure(figsize=(4.6, 3.0 + 0.1 * len(strong)), layout="constrained")
    axes = figure.subplots()
    drawn = 0
    for name in [*(other for other in names if other not in strong), *strong]:
        selected = assessed.sel(scheme=name)
        x = along.broadcast_like(values).sel(scheme=name).values
        y = values.sel(scheme=name).values
        tried = np.isfinite(y) & (y > 0) & np.isfinite(x)
        drawn += int(tried.sum())
        worst = pd.DataFrame({"x": x[tried], "y": y[tried]})
        worst = worst.loc[worst.groupby(np.floor(IN_OCTAVE * np.log2(worst.x))).y.idxmax()]
        if name not in strong:
            axes.plot(worst.x, worst.y, "-" if joined else ".", color=PALE, lw=0.8)
            continue
        s = list(order or strong).index(name)
        colour = COLOURS[s % len(COLOURS)]
        style: dict[str, Any] = {"color": colour, "marker": MARKERS[s % len(MARKERS)], "mfc": "none"}
        style |= {"markevery": IN_OCTAVE} if joined else {"ls": ""}
        axes.plot(worst.x, worst.y, **style, ms=5, lw=1.4, label=str(selected.scheme_title.values))
        if stable is not None and 0 < stable.sel(scheme=name) < np.inf:
            axes.axvline(stable.sel(scheme=name).item(), color=colour, ls=":", lw=1.4)
    for limit in limits:
        axes.axhline(limit, color="0.4", lw=0.8, ls="--")
    if not drawn:  # every run failed, or was exact
        return ""
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel=ylabel)
    axes.set_ylim(top=min(axes.get_ylim()[1], WORST))
    _label(axes.xaxis)
    _label(axes.yaxis)
    axes.grid(color="0.9")
    if len(strong) < len(names):
        axes.plot([], [], color=PALE, lw=0.8, label="other schemes")
    if stable is not None and bool(((stable > 0) & np.isfinite(stable)).sel(scheme=strong).any()):
        axes.plot([], [], color="black", ls=":", lw=1.4, label="limit of stability")
    figure.legend(loc="outside lower center", ncols=2, fontsize=9.5, frameon=False)
    return svg_of(figure)


def maps(assessed: xr.Dataset) -> str:
    """Maps of the outcome over step size and excitation, a panel for each scheme, as SVG."""
    from matplotlib.figure import Figure

    columns = min(4, assessed.sizes["scheme"])
    rows = -(-assessed.sizes["scheme"] // columns)
    figure = Figure(figsize=(2.5 * columns + 1, 2.2 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for axes, name in zip(panels, assessed.scheme.values, strict=False):
        outcome = assessed.outcome.sel(scheme=name).values
        axes.imshow(SHADES[outcome], cmap="gray", vmin=0, vmax=1, aspect="auto", origin="lower")
        for e, row in enumerate(outcome):
            ends = np.flatnonzero(np.diff(row, prepend=-1, append=-1))  # a letter for each stretch of equal outcomes
            for first, end in itertools.pairwise(ends):
                code, middle = row[first], (first + end - 1) / 2
                axes.text(middle, e, LETTERS[code], color=INK[code], ha="center", va="center", fontsize=9)
        # the steps of a map descend in geometric progression; a limit of zero or infinity is not drawn
        stable = assessed.stable_step_size.sel(scheme=name)
        log_limits = -np.log(stable.where((stable > 0) & np.isfinite(stable)).values)
        steps = np.arange(assessed.sizes["map_step_size"])
        place = np.interp(log_limits, -np.log(assessed.map_step_size.values), steps, left=np.nan, right=np.nan)
        for e, x in enumerate(place):
            axes.plot([x, x], [e - 0.5, e + 0.5], color="black", lw=1.2, ls="--")
        axes.set_title(str(assessed.scheme_title.sel(scheme=name).values), fontsize=9)
    for axes in panels[assessed.sizes["scheme"] :]:
        axes.remove()
    ticks = range(0, assessed.sizes["map_step_size"], max(1, assessed.sizes["map_step_size"] // 3))
    panels[0].set_xticks(list(ticks), [f"{assessed.map_step_size.values[i]:.2g}" for i in ticks])
    panels[0].invert_xaxis()
    panels[0].set_yticks(range(assessed.sizes["excitation"]), [f"{x:g}" for x in assessed.excitation.values])
    figure.supxlabel("step size, s", fontsize=10)
    figure.supylabel("multiple of start and load", fontsize=10)
    return svg_of(figure).replace("<svg", '<svg class="wide"', 1) if columns > 2 else svg_of(figure)
