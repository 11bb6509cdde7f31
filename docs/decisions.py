"""The full and the short table of decisions, and the input lines of their schemes, as parts of pages."""

from collections.abc import Iterable
from pathlib import Path

import pandas as pd
import xarray as xr

import study
from docs.plan import DECISION
from docs.text import table
from paper.products import reader
from paper.tables.decision import NO_BREAK, column, rows_of, sentence, steps_of
from paper.tables.models import answers
from study.runs.needs import CODES
from study.scheme.codes import NameInCode, names_in_codes
from study.words import number

_HEAD = ("scheme", "code", "name and parameters", "remark")
#: Quantities whose rows the short table shows.
_QUANTITIES = ("displacement", "peak drift")


def short_cell(one: xr.Dataset) -> str:
    """A decision in few words: scheme, step and Δt·ω; a dash if no scheme keeps the error."""
    if not one.step_size > 0:
        return "–"
    step = steps_of(one)
    counted = (step if one.problem.item() == "records" else f"{step} steps").replace(" ", NO_BREAK)
    return f"{one.scheme_title.item()}: {counted}, ωΔt{NO_BREAK}={NO_BREAK}{number(one.omega_step.item(), 2)}"


def _input_lines(schemes: Iterable[str], codes: tuple[str, ...] = ("",)) -> list[NameInCode]:
    """Names that codes give to schemes. The name of each code begins with an entry of ``codes``."""
    wanted = set(schemes)
    return [one for one in names_in_codes() if one.code.startswith(codes) and one.scheme in wanted]


def recommended(results: Path) -> dict[str, str]:
    """The schemes of OpenSees, Abaqus and LS-DYNA for three errors, and their input lines, as tables in Markdown."""
    decisions = reader(results)("decisions").sel(filter="codes")
    rows, chosen = [], set()
    for problem, quantity, kind in rows_of(decisions.expand_dims("filter")):
        if quantity in _QUANTITIES:
            one = decisions.sel(problem=problem, quantity=quantity, kind=kind)
            cells = [short_cell(one.sel(allowed_error=error)) for error in one.allowed_error.values]
            rows.append([sentence(one.problem_title.item()), kind, *cells])
            chosen |= {*one.scheme.values}
    lines = [
        [study.schemes[one.scheme].title, one.code, f"`{one.name}`", one.note] for one in _input_lines(chosen, CODES)
    ]
    errors = [column(error) for error in decisions.allowed_error.values]
    return {
        "recommended": table(["problem", "kind", *errors], rows, numbers_from=2 + len(errors)),
        "recommended_lines": table(_HEAD, lines, numbers_from=len(_HEAD)),
    }


def measured(one: xr.Dataset) -> str:
    """What was run for a decision: the problem, its quantity and unknowns, and the duration in periods."""
    title, quantity = sentence(one.problem_title.item()), one.quantity.item()
    if one.problem.item() == "records":
        return f"{title}: {quantity} in {one.starts.item()} runs"
    unknowns, many = one.unknowns.item(), one.decided.item()
    times = f"{number(many)} period{'s' * (many != 1)} T = {number(one.time_scale.item(), 2)} s"
    return f"{title}, {unknowns} unknown{'s' * (unknowns > 1)}: {quantity} over {times}"


def by_model(results: Path) -> str:
    """The schemes of the programs for an error of one percent by kind of model, as a table in Markdown."""
    decisions = answers(reader(results)("decisions"))
    chosen = {name for one in decisions.values() for name in one.scheme.values.ravel()}
    lines = {one.scheme: f"`{one.name}`" for one in _input_lines(chosen, ("OpenSees",))}
    rows = []
    for model, one in decisions.items():
        kinds = [one.sel(kind=kind) for kind in ("explicit", "implicit")]
        line = next((lines[kind.scheme.item()] for kind in reversed(kinds) if kind.scheme.item() in lines), "–")
        rows.append([model, *map(short_cell, kinds), line, measured(one)])
    head = ["model", "explicit", "implicit", "OpenSees, implicit", "measured"]
    return table(head, rows, numbers_from=len(head))


def tables(results: Path) -> dict[str, str]:
    """All tables of decisions and of input lines in Markdown, by name."""
    decision = pd.read_csv(results / DECISION, keep_default_na=False)
    chosen = reader(results)("decisions").scheme.values.ravel()
    lines = [
        [f"[{study.schemes[one.scheme].title}](/schemes/{one.scheme}.md)", one.code, f"`{one.name}`", one.note]
        for one in _input_lines(chosen)
    ]
    return {
        **recommended(results),
        "by_model": by_model(results),
        "decisions": table(decision.columns, decision.to_numpy().tolist(), numbers_from=len(decision.columns)),
        "input_lines": table(_HEAD, lines, numbers_from=len(_HEAD)),
    }
