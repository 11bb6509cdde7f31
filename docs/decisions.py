"""The tables of decisions, whole and in short, and the input lines of their schemes, as parts of pages."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

import study
from docs.plan import DECISION, RECOMMENDED
from docs.text import table
from paper.products import made, reader
from study.scheme.codes import names_in_codes

#: The title of a scheme in a cell: before a number of steps, or at the end of a remark.
_TITLE = re.compile(r"(?:^|[:;] )([^:;\n]+)(?=[:;]|$)", re.MULTILINE)

#: Programs whose schemes the short table compares, by the beginning of their names.
_PROGRAMS = ("OpenSees", "Abaqus", "LS-DYNA")
#: Quantities of the short table.
_QUANTITIES = ("displacement", "peak drift")
#: A cell of the table of decisions: the scheme and its step, and ω Δt in the brackets.
_CELL = re.compile(r"(.+): (.+?) \(.*ωΔt\s([\d.]+)[^)]*\)")


def _short_cell(cell: str) -> str:
    if not (found := _CELL.match(cell)):
        return cell
    title, step, omega_step = found.groups()
    return f"{title}: {step if step.endswith('ms') else f'{step} steps'}, ωΔt\u00a0=\u00a0{omega_step}"


def recommended(results: Path) -> dict[str, str]:
    """The schemes of the programs for an error of 1 %, and how the programs call them, as tables in Markdown."""
    lines: dict[str, dict[str, str]] = {program: {} for program in _PROGRAMS}
    for one in names_in_codes():
        for program in _PROGRAMS:
            if one.code.startswith(program):
                lines[program][one.scheme] = f"`{one.name}`"
    known, read = set().union(*lines.values()), reader(results)

    def of_programs(name: str) -> xr.Dataset:
        data = read(name)
        return data.isel(scheme=[k for k, scheme in enumerate(data.scheme.values) if scheme in known])

    decided = made(RECOMMENDED, of_programs)
    decided = decided.assign(Problem=decided["Problem"].replace("", np.nan).ffill())
    decided["Right in"] = decided["Right in"].replace("", np.nan).ffill()
    chosen = decided[decided["Right in"].isin(_QUANTITIES)]
    picks = chosen.pivot(index="Problem", columns="Scheme", values="1 %").loc[chosen["Problem"].unique()]
    rows = [[problem, *map(_short_cell, row)] for problem, row in zip(picks.index, picks.to_numpy(), strict=True)]
    titles = "\n".join(picks.to_numpy().ravel())
    named = [name for name in study.schemes if name in known and f"{study.schemes[name].title}: " in titles]
    calls = [[study.schemes[name].title, *(lines[one].get(name, "–") for one in _PROGRAMS)] for name in named]
    return {
        "recommended": table(["problem", *picks.columns], rows, numbers_from=3),
        "recommended_lines": table(["scheme", *_PROGRAMS], calls, numbers_from=4),
    }


def tables(results: Path) -> dict[str, str]:
    """All tables in Markdown, by name."""
    decision = pd.read_csv(results / DECISION, keep_default_na=False)
    cells = decision.to_numpy()
    titles = set(_TITLE.findall("\n".join(cells.ravel())))
    chosen = {name: one.title for name, one in study.schemes.items() if one.title in titles}
    lines = [
        [f"[{chosen[one.scheme]}](/schemes/{one.scheme}.md)", one.code, f"`{one.name}`", one.note]
        for one in names_in_codes()
        if one.scheme in chosen
    ]
    head = ["scheme", "code", "name and parameters", "remark"]
    return {
        **recommended(results),
        "decisions": table(decision.columns, cells.tolist(), numbers_from=len(decision.columns)),
        "input_lines": table(head, lines, numbers_from=len(head)),
    }
