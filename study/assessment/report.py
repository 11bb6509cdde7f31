"""``study.report``: an assessment as one self-contained page of HTML."""

import itertools
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from study.analysis.recommendation import asked_for, costs_of, firsts, table_of_assessment
from study.assessment.assurance import (
    confirmation,
    limits_of_reference,
    other_durations,
    percent,
    reference_of,
    values_of_reference,
)
from study.assessment.drawing import LETTERS, curves, figure_of, maps, motion, times_of_runs
from study.assessment.failures import failed_runs
from study.assessment.search import ENERGY
from study.assessment.style import STYLE
from study.assessment.tables import answers, controlled, input_lines, needs, summary, table_of, time_in_words
from study.io import read, write
from study.words import document, listed, number, step_size, step_with_unit, text_of

#: Largest number of schemes whose curves are emphasised.
EMPHASISED = 6


def answer(assessed: xr.Dataset, quantity: str, error: float) -> str:
    """Sentences on the fastest scheme of each kind that keeps an error of a quantity; if none does, on the reasons."""
    table = table_of_assessment(assessed, error, quantity)
    suitable = table[table["step_size"].notna()]
    if suitable.empty:
        reasons = ", ".join(sorted(set(table.verdict)))
        return f"No scheme was found to keep {percent(error)} of {quantity}: {reasons}."
    titles = dict(zip(assessed.scheme.values, assessed.scheme_title.values, strict=True))
    best = [
        f"{titles[row.Index]} ({row.kind}) with Δt = {step_size(row.step_size, assessed.attrs.get('spacing'))} s "
        f"({row.steps:.0f} steps{f', {time_in_words(row.seconds)}' if row.seconds > 0 else ''})"
        f"{f', but {listed(limits)}' if (limits := caveats(assessed, row)) else ''}"
        for row in firsts(table).itertuples()
    ]
    ties, counts = suitable.index[1:][suitable.ties_with_fastest.iloc[1:]], costs_of(suitable)
    if ties.empty:
        return f"For {percent(error)} of {quantity}: {'; '.join(best)}."
    counted = "evaluations" if counts.name == "force_evaluations" else "steps"
    decides = f"the number of {counted} decides{', then the error' * (counts.iloc[0] in counts[ties].values)}"
    return (
        f"For {percent(error)} of {quantity}: {'; '.join(best)}. "
        f"Measured times do not distinguish it from {listed([titles[name] for name in ties])}; {decides}."
    )


def caveats(assessed: xr.Dataset, row) -> list[str]:
    """Clauses that limit the use of a recommended step, a row of ``recommend``; may be empty."""
    clauses = []
    if "largest_safe_step_size" in assessed and row.step_size >= assessed.map_step_size.min():
        safe = assessed.largest_safe_step_size.sel(scheme=row.Index)
        clauses += [] if row.step_size <= safe else ["some run fails at this or a finer step (see how it fails)"]
    clauses += ["no coarser step was tried"] if row.verdict == "already the coarsest step" else []
    if row.most_wrong_error > assessed.allowed_error.max():
        clauses.append(f"{row.most_wrong} is wrong by {percent(row.most_wrong_error)}")
    return clauses


def tables_of(assessed: xr.Dataset, quantity: str) -> list[pd.DataFrame]:
    """The table of ``recommend`` for each allowed error."""
    return [table_of_assessment(assessed, limit, quantity) for limit in assessed.allowed_error.values]


def emphasised(assessed: xr.Dataset, tables: list[pd.DataFrame]) -> list[str]:
    """Schemes whose curves are emphasised: the requested ones, then the first of each kind in each table.

    If there are none, they are the first schemes of the assessment.
    """
    best = (name for table in tables for name in firsts(table).index)
    return (list(dict.fromkeys([*asked_for(assessed), *best])) or assessed.scheme.values.tolist())[:EMPHASISED]


def _answer(assessed: xr.Dataset, quantity: str, titles: dict[str, str]) -> str:
    """The requested and the best steps for a quantity, and what limits their use, as HTML."""
    tables = tables_of(assessed, quantity)
    spacing = assessed.attrs.get("spacing")
    notes = dict.fromkeys(
        f"With {titles[row.Index]} at {step_with_unit(row.step_size, spacing)}, {listed(clauses)}."
        for table in tables
        for row in table.loc[list(dict.fromkeys([*asked_for(assessed), *firsts(table).index]))].itertuples()
        if row.step_size > 0 and (clauses := caveats(assessed, row))
    )
    return answers(assessed, tables, quantity, titles) + (f"<p>{text_of(' '.join(notes))}</p>" if notes else "")


def _quantity_section(assessed: xr.Dataset, quantity: str, titles: dict[str, str], order: Sequence[str]) -> list[str]:
    """Errors of a quantity, and the steps that keep it, as parts of a page; ``order`` sets the colours of schemes."""
    limits, values = assessed.allowed_error.values, assessed.error.sel(quantity=quantity)
    tables = tables_of(assessed, quantity)
    strong = emphasised(assessed, tables)
    caption = (
        f"Worst error of {quantity} around each step, {assessed.relative_to.sel(quantity=quantity).item()}. Dashed: "
        f"allowed errors. With markers: {'your own, and ' * bool(asked_for(assessed))}the best of each kind."
    )
    stable = assessed.stable_step_size.sel(excitation=1.0) if "stable_step_size" in assessed else None
    against_step = curves(assessed, assessed.step_size, "step size, s", values, "error", limits, strong, stable, order)
    single = "seconds_per_run" in assessed
    times, label = times_of_runs(assessed), "time of a run, s"
    against_time = curves(assessed, times, label, values, "error", limits, strong, order=order, joined=not single)
    time_note = ", measured once." if single else ", which is its number of steps times the time of a step."
    parts = [
        f"<h2>Error of {text_of(quantity)}</h2>",
        f'<div class="pair">{figure_of(against_step, caption)}',
        figure_of(against_time, f"The same errors against the time of a run{time_note}"),
        f"</div>{controlled(tables, limits, titles)}{summary(tables, limits, titles, asked_for(assessed))}",
    ]
    for limit, table in zip(limits, tables, strict=True):
        parts.append(f"<details><summary>All numbers for {percent(limit)}</summary>{needs(table, titles)}</details>")
    return parts


def _failures(assessed: xr.Dataset, titles: dict[str, str]) -> list[str]:
    """Maps of failures, and the largest steps without failure, as parts of a page."""
    names = assessed.outcome.flag_meanings.split()
    used = np.unique(assessed.outcome)
    legend = "; ".join(f"{LETTERS[outcome] or 'white'}: {names[outcome].replace('_', ' ')}" for outcome in used)
    limited = ""
    if (np.isfinite(assessed.stable_step_size) & (assessed.stable_step_size > 0)).any():
        limited = " Dashed: stability limit for small motions about the start."
    rows = [
        (
            titles[n],
            number(assessed.largest_safe_step_size.sel(scheme=n).item(), 4),
            str(assessed.failure.sel(scheme=n).values),
        )
        for n in assessed.scheme.values
    ]
    head = ("scheme", "largest Δt without failure, s", "cause of the limit, and remedies")
    return [
        "<h2>How it fails</h2>",
        figure_of(maps(assessed), f"Outcome of runs. {legend}.{limited}"),
        "<p>At the largest step without failure, and at all finer steps, no run with at most the given start and "
        "load fails, grows, becomes chaotic or is beyond the stability limit. The errors of these runs may still "
        "be large.</p>",
        table_of(head, rows, text=(2,)),
    ]


def judgement(assessed: xr.Dataset) -> list[str]:
    """An assessment as parts of a page: answer, model and reference, errors, energy, failures."""
    titles = dict(zip(assessed.scheme.values, map(str, assessed.scheme_title.values), strict=True))
    quantities = assessed.quantity.values.tolist()
    first, *others = (_answer(assessed, quantity, titles) for quantity in quantities)
    limited = f"<p>{text_of(remarks)}</p>" if (remarks := limits_of_reference(assessed)) else ""
    parts = [f'<div class="answer">{limited}{first}</div>']
    if others:
        words = text_of(listed(quantities[1:]))
        parts.append(f"<details><summary>The same for {words}</summary>{''.join(others)}</details>")
    model = "<br>".join(map(text_of, assessed.attrs.get("model", "").splitlines()))
    values = table_of(("reference", "value", "at t, s"), values_of_reference(assessed))
    if assessed.quantity_units.isin(["1", "s-1", "s-2"]).any():
        values = f"<div>{values}<p>Units that are missing are those of the model.</p></div>"
    parts.append(f'<h2>Model and reference motion</h2><p>{model}</p><div class="pair">{values}')
    drawn = next((figure for name in quantities if (figure := motion(assessed.sel(quantity=name)))), "")
    parts.append(f"{drawn}</div>")
    strong = (emphasised(assessed, tables_of(assessed, quantity)) for quantity in quantities)
    order = list(dict.fromkeys(itertools.chain.from_iterable(strong)))
    for quantity in quantities:
        parts += _quantity_section(assessed, quantity, titles, order)
    if ENERGY not in quantities and np.isfinite(assessed.energy_imbalance).any():
        imbalance, label = assessed.energy_imbalance, "imbalance of energies"
        drawn = curves(assessed, assessed.step_size, "step size, s", imbalance, label, emphasised=order, order=order)
        caption = "Largest error of the balance of energy, dissipation and work, relative to the energy put in."
        parts += ["<h2>Energy</h2>", figure_of(drawn, caption)]
    if "outcome" in assessed:
        parts += _failures(assessed, titles)
    if rows := failed_runs(assessed):
        parts += ["<h2>Runs that failed</h2>", table_of(("scheme", "Δt, s", "reason"), rows, text=(2,))]
    sure = (confirmation(assessed), other_durations(assessed), reference_of(assessed))
    parts += ["<h2>How sure the steps are</h2>", *(f"<p>{text_of(sentence)}</p>" for sentence in sure if sentence)]
    best = {name for table in tables_of(assessed, quantities[0]) for name in firsts(table).index}
    return [*parts, *input_lines(titles[name] for name in best)]


def provenance(attributes: dict) -> list[str]:
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
    if not isinstance(assessed, xr.Dataset) or "recommended_step_size" not in assessed:
        raise ValueError("report takes a dataset of study.assess.")
    return document(assessed.attrs["title"], [*judgement(assessed), *provenance(assessed.attrs)], STYLE)


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
