"""``study.report``: an assessment as one self-contained page of HTML."""

import io
import itertools
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from study.analysis.outcomes import Outcome
from study.analysis.recommendation import recommend
from study.assessment.assurance import confirmation, limits_of_reference, percent, reference_of
from study.assessment.failures import failed_runs
from study.assessment.style import STYLE
from study.io import read, write
from study.scheme.codes import names_in_codes
from study.scheme.named import schemes
from study.words import document, listed, number, text_of

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


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def table_of(head: Iterable[str], rows: Iterable[Iterable[object]], text: tuple[int, ...] = ()) -> str:
    """A table of HTML; ``text`` has the indices, from zero, of the columns of text."""

    def row_of(tag: str, row: list[object]) -> str:
        kinds = (' class="text"' if i in text else "" for i in itertools.count())
        # an empty cell in the head of the table is not marked as a heading
        tags = (tag if one else "td" for one in row)
        return "".join(f"<{t}{kind}>{text_of(one)}</{t}>" for t, kind, one in zip(tags, kinds, row, strict=False))

    cells, body = row_of("th", list(head)), "".join(f"<tr>{row_of('td', list(row))}</tr>" for row in rows)
    return f'<div class="scroll" tabindex="0"><table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table></div>'


def answer(assessed: xr.Dataset, quantity: str, error: float) -> str:
    """Sentences on the fastest scheme of each kind that keeps an error of a quantity; if none does, on the reasons."""
    table = recommend(assessed, error=error, quantity=quantity)
    found = table[table["step_size"].notna()]
    if found.empty:
        reasons = ", ".join(sorted(set(table.verdict)))
        return f"No scheme was found to keep {percent(error)} of {quantity}: {reasons}."
    titles = dict(zip(assessed.scheme.values, assessed.scheme_title.values, strict=True))
    best = []
    for one in found.groupby("kind", sort=False).head(1).itertuples():
        text = (
            f"{titles[one.Index]} ({one.kind}) with Δt = {number(one.step_size, 4)} s "
            f"({one.number_of_steps:.0f} steps{f', {_time(one.time)}' if one.time > 0 else ''})"
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
        f" As fast within the spread of times: {', '.join(ties)}." if ties else ""
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
        # the steps of a map descend in geometric progression
        place = np.interp(
            -np.log(assessed.stable_dt.sel(scheme=name).values),
            -np.log(assessed.map_dt.values),
            np.arange(assessed.sizes["map_dt"]),
            left=np.nan,
        )
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


def _input_lines(assessed: xr.Dataset) -> list[str]:
    """Heading and table of the recommended schemes' input in other codes; empty if no code has such a scheme."""
    recommended = assessed.recommended_dt.notnull().any(["quantity", "allowed_error"]).values
    titles = set(assessed.scheme_title.values[recommended])
    named = ((schemes[one.scheme].title, one.code, one.name, one.note) for one in names_in_codes())
    rows = [row for row in named if row[0] in titles]
    return ["<h2>In other codes</h2>", table_of(("", "code", "input", ""), rows, text=(1, 2, 3))] if rows else []


def _needs(table: pd.DataFrame, titles: dict[str, str]) -> str:
    """Tables of the steps that schemes need, one table for each kind of scheme, the fastest scheme first."""
    head = ("", "Δt (unrounded), s", "Δt·ω", "steps", "error", "time", "forces/s", "tried", "search")
    parts = []
    for kind, of_kind in table.groupby("kind", sort=False):
        rows = [
            (
                titles[row.Index],
                f"{number(row.step_size, 4)} ({number(row.largest_step, 4)})",
                number(row.omega_step, 2),
                f"{row.number_of_steps:.0f}",
                percent(row.error),
                "–" if np.isnan(row.time) else f"{_time(row.time)} ± {_time(row.time_spread / 2)}",
                number(row.forces_per_time),
                row.steps_tried,
                row.verdict,
            )
            if row.step_size > 0
            else (titles[row.Index], *"–––––––", row.verdict)
            for row in of_kind.itertuples()
        ]
        parts.append(table_of((kind, *head[1:]), rows))
    return "".join(parts)


def _controlled(table: pd.DataFrame, titles: dict[str, str]) -> str:
    """A table of the tolerances that keep an error; empty if there is no such tolerance."""
    found = table[table["tolerance"] > 0] if "tolerance" in table else table[:0]
    rows = [
        (
            titles[row.Index],
            f"{row.tolerance:g}",
            f"{row.controlled_force_evaluations:,.0f}",
            number(row.control_over_equal, 2),
        )
        for row in found.itertuples()
    ]
    head = ("controlled steps", "tolerance", "forces", "forces over forces with equal steps")
    return table_of(head, rows) if rows else ""


def judgement(assessed: xr.Dataset) -> list[str]:
    """An assessment as parts of a page: answers, errors, energy, failures, reference."""
    titles = dict(zip(assessed.scheme.values, map(str, assessed.scheme_title.values), strict=True))
    quantities, limits = assessed.quantity.values.tolist(), assessed.allowed_error.values
    answers = ["".join(f"<p>{text_of(answer(assessed, q, limit))}</p>" for limit in limits) for q in quantities]
    parts = [f'<div class="answer">{answers[0]}</div>']
    if others := quantities[1:]:
        parts += [f'<details class="answer"><summary>For {text_of(listed(others))}</summary>', *answers[1:]]
        parts.append("</details>")
    if limits_of_reference(assessed):
        parts.append(f"<p>{text_of(limits_of_reference(assessed))}</p>")
    parts.append(f"<p>{text_of(confirmation(assessed))}</p>")
    for quantity in quantities:
        parts.append(f"<h2>Error of {text_of(quantity)}</h2>")
        values = assessed.error.sel(quantity=quantity)
        caption = f"Worst error of {quantity} around each step, relative to its peak. Dashed lines: allowed errors."
        against_step = figure_of(curves(assessed, assessed.dt, "step size, s", values, "error", limits), caption)
        against_time = figure_of(
            curves(assessed, times_of_runs(assessed), "time of a run, s", values, "error", limits),
            "The same errors against the time of a run"
            + ("." if "run_time" in assessed else ", which is its number of steps times the time of a step."),
        )
        parts.append(f'<div class="pair">{against_step}{against_time}</div>')
        for limit in limits:
            table = recommend(assessed, error=limit, quantity=quantity)
            parts.append(f"<p><b>{percent(limit)}</b></p>{_needs(table, titles)}{_controlled(table, titles)}")
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
        if np.isfinite(assessed.stable_dt).any():
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
    parts += _input_lines(assessed)
    return [*parts, "<h2>The reference</h2>", f"<p>{text_of(reference_of(assessed))}</p>"]


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
