"""``study.report``: an assessment as one self-contained page of HTML."""

import io
import itertools
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from study.analysis.outcomes import Outcome
from study.analysis.recommendation import of_assessment
from study.assessment.assurance import (
    confirmation,
    limits_of_reference,
    other_durations,
    percent,
    reference_of,
    values_of_reference,
)
from study.assessment.failures import failed_runs
from study.assessment.style import STYLE
from study.assessment.tables import controlled, input_lines, needs, table_of, time_in_words
from study.io import read, write
from study.words import document, listed, number, step_size, text_of

#: Colours of curves, which differ in greyscale and for the colour-blind.
COLOURS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
#: Markers of curves. With seven colours and ten markers, each of 70 curves has its own pair of colour and marker.
MARKERS = "osD^vPX<>*"

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


def answer(assessed: xr.Dataset, quantity: str, error: float) -> str:
    """Sentences on the fastest scheme of each kind that keeps an error of a quantity; if none does, on the reasons."""
    table = of_assessment(assessed, error, quantity)
    found = table[table["step_size"].notna()]
    if found.empty:
        reasons = ", ".join(sorted(set(table.verdict)))
        return f"No scheme was found to keep {percent(error)} of {quantity}: {reasons}."
    titles = dict(zip(assessed.scheme.values, assessed.scheme_title.values, strict=True))
    best = []
    for one in found.groupby("kind", sort=False).head(1).itertuples():
        text = (
            f"{titles[one.Index]} ({one.kind}) with Δt = {step_size(one.step_size, assessed.attrs.get('spacing'))} s "
            f"({one.number_of_steps:.0f} steps{f', {time_in_words(one.time)}' if one.time > 0 else ''})"
        )
        if "largest_safe_dt" in assessed and one.step_size >= assessed.map_dt.min():
            safe = assessed.largest_safe_dt.sel(scheme=one.Index)
            text += "" if one.step_size <= safe else ", beyond its largest step without failure (see how it fails)"
        text += ", the coarsest step tried" if one.verdict == "already the coarsest step" else ""
        if one.most_wrong_error > assessed.allowed_error.max():
            text += f", where {one.most_wrong} is wrong by {percent(one.most_wrong_error)}"
        best.append(text)
    ties = [titles[name] for name in found.index[1:] if found.ties_with_fastest[name]]
    return f"For {percent(error)} of {quantity}: {'; '.join(best)}." + (
        f" Measured times do not distinguish it from {listed(ties)}; the number of evaluations decides." if ties else ""
    )


def svg_of(figure) -> str:
    """A figure of matplotlib as SVG for a page."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]


def times_of_runs(assessed: xr.Dataset) -> xr.DataArray:
    """Times of all runs: ``run_time`` if the dataset has it, otherwise the number of steps times the time of a step."""
    return assessed.run_time if "run_time" in assessed else assessed.time_per_step * assessed.steps


def curves(assessed: xr.Dataset, along: xr.DataArray, label: str, values: xr.DataArray, ylabel: str, limits=()) -> str:
    """Values of every scheme against the step sizes or times of its runs, as SVG; empty if there is nothing to draw."""
    from matplotlib.figure import Figure

    # narrow, so that a phone does not shrink the letters
    figure = Figure(figsize=(5.4, 3.6 + 0.1 * assessed.sizes["scheme"]), layout="constrained")
    axes = figure.subplots()
    drawn = 0
    for s, name in enumerate(assessed.scheme.values):
        one = assessed.sel(scheme=name)
        x = along.broadcast_like(values).sel(scheme=name).values
        y = values.sel(scheme=name).values
        tried = np.isfinite(y) & (y > 0) & np.isfinite(x)
        colour, marker = COLOURS[s % len(COLOURS)], MARKERS[s % len(MARKERS)]
        drawn += int(tried.sum())
        worst = pd.DataFrame({"x": x[tried], "y": y[tried]})
        worst = worst.loc[worst.groupby(np.floor(IN_OCTAVE * np.log2(worst.x))).y.idxmax()]
        style: dict[str, Any] = {"color": colour, "marker": marker, "mfc": "none", "markevery": IN_OCTAVE}
        axes.plot(worst.x, worst.y, **style, ms=5, lw=1.0, label=str(one.scheme_title.values))
    for limit in limits:
        axes.axhline(limit, color="0.6", lw=0.8, ls="--")
    if not drawn:  # every run failed, or was exact
        return ""
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel=ylabel)
    axes.set_ylim(top=min(axes.get_ylim()[1], WORST))
    axes.grid(color="0.9")
    figure.legend(loc="outside lower center", ncols=2, fontsize="small", frameon=False)
    return svg_of(figure)


def _maps(assessed: xr.Dataset) -> str:
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
                one, middle = row[first], (first + end - 1) / 2
                axes.text(middle, e, LETTERS[one], color=INK[one], ha="center", va="center", fontsize=8)
        # the steps of a map descend in geometric progression; a limit of zero or infinity is not drawn
        stable = assessed.stable_dt.sel(scheme=name)
        at_limit = -np.log(stable.where((stable > 0) & np.isfinite(stable)).values)
        steps = np.arange(assessed.sizes["map_dt"])
        place = np.interp(at_limit, -np.log(assessed.map_dt.values), steps, left=np.nan, right=np.nan)
        for e, at in enumerate(place):
            axes.plot([at, at], [e - 0.5, e + 0.5], color="black", lw=1.2, ls="--")
        axes.set_title(str(assessed.scheme_title.sel(scheme=name).values), fontsize=9)
    for axes in panels[assessed.sizes["scheme"] :]:
        axes.remove()
    every = range(0, assessed.sizes["map_dt"], max(1, assessed.sizes["map_dt"] // 4))
    panels[0].set_xticks(list(every), [f"{assessed.map_dt.values[i]:.2g}" for i in every])
    panels[0].set_yticks(range(assessed.sizes["excitation"]), [f"{x:g}" for x in assessed.excitation.values])
    figure.supxlabel("step size, s", fontsize=10)
    figure.supylabel("multiple of start and load", fontsize=10)
    return svg_of(figure).replace("<svg", '<svg class="wide"', 1) if columns > 2 else svg_of(figure)


def figure_of(svg: str, caption: str) -> str:
    """A figure of HTML with its caption, or a sentence if ``svg`` is empty."""
    if not svg:
        return "<p>No run has an error above zero.</p>"
    return f'<figure><div class="scroll">{svg}</div><figcaption>{text_of(caption)}</figcaption></figure>'


def judgement(assessed: xr.Dataset) -> list[str]:
    """An assessment as parts of a page: answers, errors, energy, failures, reference."""
    titles = dict(zip(assessed.scheme.values, map(str, assessed.scheme_title.values), strict=True))
    quantities, limits = assessed.quantity.values.tolist(), assessed.allowed_error.values
    answers = ["".join(f"<p>{text_of(answer(assessed, q, limit))}</p>" for limit in limits) for q in quantities]
    first = [of_assessment(assessed, limit, quantities[0]).attrs["answer"] for limit in limits]
    short = "".join(f"<p><b>{'. '.join(map(text_of, lines))}</b></p>" for lines in first)
    parts = [f'<div class="answer">{short}{answers[0]}</div>']
    if assessed.attrs.get("model"):
        parts.append(f"<p>{'<br>'.join(map(text_of, assessed.attrs['model'].splitlines()))}</p>")
    if others := quantities[1:]:
        parts += [f'<details class="answer"><summary>For {text_of(listed(others))}</summary>', *answers[1:]]
        parts.append("</details>")
    if limits_of_reference(assessed):
        parts.append(f"<p>{text_of(limits_of_reference(assessed))}</p>")
    parts.append(f"<p>{text_of(confirmation(assessed))}</p><p>{text_of(other_durations(assessed))}</p>")
    for quantity in quantities:
        parts.append(f"<h2>Error of {text_of(quantity)}</h2>")
        values = assessed.error.sel(quantity=quantity)
        relative_to = assessed.relative_to.sel(quantity=quantity).item()
        caption = f"Worst error of {quantity} around each step, {relative_to}. Dashed lines: allowed errors."
        against_step = figure_of(curves(assessed, assessed.dt, "step size, s", values, "error", limits), caption)
        against_time = figure_of(
            curves(assessed, times_of_runs(assessed), "time of a run, s", values, "error", limits),
            "The same errors against the time of a run"
            + ("." if "run_time" in assessed else ", which is its number of steps times the time of a step."),
        )
        parts.append(f'<div class="pair">{against_step}{against_time}</div>')
        for limit in limits:
            table = of_assessment(assessed, limit, quantity)
            parts.append(f"<p><b>{percent(limit)}</b></p>{needs(table, titles)}{controlled(table, titles)}")
    if np.isfinite(assessed.energy_imbalance).any():
        parts.append("<h2>Energy</h2>")
        parts.append(
            figure_of(
                curves(assessed, assessed.dt, "step size, s", assessed.energy_imbalance, "imbalance of energies"),
                "Largest error of the balance of energy, dissipation and work, relative to the energy put in.",
            )
        )
    if "outcome" in assessed:
        names = assessed.outcome.flag_meanings.split()
        used = np.unique(assessed.outcome)
        legend = "; ".join(f"{LETTERS[one] or 'white'}: {names[one].replace('_', ' ')}" for one in used)
        limited = ""
        if (np.isfinite(assessed.stable_dt) & (assessed.stable_dt > 0)).any():
            limited = " Dashed: stability limit for small motions about the start."
        parts += [
            "<h2>How it fails</h2>",
            figure_of(_maps(assessed), f"Outcome of runs. {legend}.{limited}"),
            "<p>At the largest step without failure, and at all finer steps, no run with at most the given start and "
            "load fails, grows, becomes chaotic or is beyond the stability limit. The errors of these runs may still "
            "be large.</p>",
        ]
        rows = [
            (
                titles[n],
                number(assessed.largest_safe_dt.sel(scheme=n).item(), 4),
                str(assessed.failure.sel(scheme=n).values),
            )
            for n in assessed.scheme.values
        ]
        head = ("scheme", "largest Δt without failure, s", "cause of the limit, and remedies")
        parts.append(table_of(head, rows, text=(2,)))
    if rows := failed_runs(assessed):
        parts += ["<h2>Runs that failed</h2>", table_of(("scheme", "Δt, s", "reason"), rows, text=(2,))]
    parts += input_lines(assessed)
    of_values = ("quantity", "component", "value in the reference", "uncertainty", "unit", "reached at t, s")
    values = table_of(of_values, values_of_reference(assessed))
    return [*parts, "<h2>The reference</h2>", f"<p>{text_of(reference_of(assessed))}</p>", values]


def made_by(attributes: dict) -> list[str]:
    """Versions, processor and command, as parts of a page."""
    parts = ["<h2>Provenance</h2><dl>"]
    for key in ("version", "commit", "packages", "python", "processor", "not_fit"):
        if attributes.get(key):
            parts.append(f"<dt>{text_of(key.replace('_', ' '))}</dt><dd>{text_of(attributes[key])}</dd>")
    parts.append("</dl>")
    if attributes.get("command"):
        parts.append(f"<p>To run it again:</p><pre>{text_of(attributes['command'])}</pre>")
    return parts


def page(assessed: xr.Dataset) -> str:
    """The page of an assessment as HTML."""
    if not isinstance(assessed, xr.Dataset) or "recommended_dt" not in assessed:
        raise ValueError("report takes a dataset of study.assess.")
    return document(assessed.attrs["title"], [*judgement(assessed), *made_by(assessed.attrs)], STYLE)


def report(assessed: xr.Dataset, path: str | Path) -> Path:
    """Write an assessment as one page of HTML that needs no server and loads nothing.

    Parameters
    ----------
    assessed
        Dataset of :func:`study.assess`.
    path
        File of HTML to write.

    Raises
    ------
    ValueError
        If the dataset is not an assessment.
    OSError
        If there is no such folder, or the file cannot be written.
    """
    if not Path(path).parent.is_dir():
        raise FileNotFoundError(f"the folder '{Path(path).parent}' does not exist; make it first.")
    write(page(assessed), path)
    return Path(path)


if __name__ == "__main__":
    report(read(Path(sys.argv[1])), sys.argv[2])
