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
from study.runs.needs import CODES
from study.scheme.codes import NameInCode, names_in_codes
from study.words import number

_HEAD = ("scheme", "code", "name and parameters", "remark")
#: Quantities whose rows the short table shows.
_QUANTITIES = ("displacement", "peak drift")
#: Problem and quantity that stand for a kind of model in the table of README, and its allowed error.
_MODELS = {
    "frame under an earthquake": ("records", "peak drift"),
    "free vibration over a long time": ("softening", "displacement"),
    "forced vibration": ("shaken", "displacement"),
    "yielding": ("yielding", "displacement"),
    "impact and contact": ("bouncing", "displacement"),
    "stiff constraint": ("elastic_pendulum", "displacement"),
    "stiff beside soft parts": ("stiff_soft", "displacement"),
    "mesh with a wave": ("impact_bar", "displacement"),
}
_ERROR = 0.01


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


def by_model(results: Path) -> str:
    """The schemes of the programs for an error of ``_ERROR`` by kind of model, as a table in Markdown."""
    decisions = reader(results)("decisions").sel(filter="codes").sel(allowed_error=_ERROR, method="nearest")
    lines = {one.scheme: f"`{one.name}`" for one in _input_lines(decisions.scheme.values.ravel(), ("OpenSees",))}
    rows = []
    for model, (problem, quantity) in _MODELS.items():
        one = decisions.sel(problem=problem, quantity=quantity)
        kinds = [one.sel(kind=kind) for kind in ("explicit", "implicit")]
        chosen = next((lines[kind.scheme.item()] for kind in reversed(kinds) if kind.scheme.item() in lines), "–")
        rows.append([model, *map(short_cell, kinds), chosen, f"{sentence(one.problem_title.item())}: {quantity}"])
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
        "decisions": table(decision.columns, decision.to_numpy().tolist(), numbers_from=len(decision.columns)),
        "input_lines": table(_HEAD, lines, numbers_from=len(_HEAD)),
    }
