"""The full and the short table of decisions, and the input lines of their schemes, as parts of pages."""

import re
from collections.abc import Iterable
from pathlib import Path

import pandas as pd
import xarray as xr

import study
from docs.plan import DECISION, RECOMMENDED
from docs.text import table
from paper.products import made, reader
from study.scheme.codes import NameInCode, names_in_codes

#: Pattern of the title of a scheme in a cell: it precedes a number of steps, or ends a remark.
_TITLE = re.compile(r"(?:^|[:;] )([^:;\n]+)(?=[:;]|$)", re.MULTILINE)

#: Beginnings of the names of the programs whose schemes the short table compares.
_PROGRAMS = ("OpenSees", "Abaqus", "LS-DYNA")
_HEAD = ("scheme", "code", "name and parameters", "remark")
#: Quantities whose rows the short table shows.
_QUANTITIES = ("displacement", "peak drift")
_ERRORS = ("10 %", "1 %", "0.1 %")
#: Pattern of a cell of the table of decisions: title of the scheme, step, and ω Δt in the brackets.
_CELL = re.compile(r"(.+): (.+?) \(.*ωΔt\s([\d.]+)[^)]*\)")


def _short_cell(cell: str) -> str:
    if not (found := _CELL.match(cell)):
        return cell
    title, step, omega_step = found.groups()
    counted = (step if step.endswith("ms") else f"{step} steps").replace(" ", "\u00a0")
    return f"{title}: {counted}, ωΔt\u00a0=\u00a0{omega_step}"


def _input_lines(cells: Iterable[str], codes: tuple[str, ...] = ("",)) -> list[NameInCode]:
    """Names that codes give to the schemes in the cells. The name of each code begins with an entry of ``codes``."""
    titles = set(_TITLE.findall("\n".join(cells)))
    named = [one for one in names_in_codes() if one.code.startswith(codes)]
    return [one for one in named if study.schemes[one.scheme].title in titles]


def recommended(results: Path) -> dict[str, str]:
    """The schemes of OpenSees, Abaqus and LS-DYNA for three errors, and their input lines, as tables in Markdown."""
    known, read = {one.scheme for one in names_in_codes() if one.code.startswith(_PROGRAMS)}, reader(results)

    def of_programs(name: str) -> xr.Dataset:
        data = read(name)
        return data.isel(scheme=[k for k, scheme in enumerate(data.scheme.values) if scheme in known])

    decided = made(RECOMMENDED, of_programs).replace("", pd.NA).ffill()
    chosen = decided[decided["Right in"].isin(_QUANTITIES)]
    picks = chosen[list(_ERRORS)].map(_short_cell)
    rows = chosen[["Problem", "Scheme"]].join(picks).to_numpy().tolist()
    lines = [
        [study.schemes[one.scheme].title, one.code, f"`{one.name}`", one.note]
        for one in _input_lines(picks.to_numpy().ravel(), _PROGRAMS)
    ]
    return {
        "recommended": table(["problem", "kind", *_ERRORS], rows, numbers_from=2 + len(_ERRORS)),
        "recommended_lines": table(_HEAD, lines, numbers_from=len(_HEAD)),
    }


def tables(results: Path) -> dict[str, str]:
    """All tables of decisions and of input lines in Markdown, by name."""
    decision = pd.read_csv(results / DECISION, keep_default_na=False)
    cells = decision.to_numpy()
    lines = [
        [f"[{study.schemes[one.scheme].title}](/schemes/{one.scheme}.md)", one.code, f"`{one.name}`", one.note]
        for one in _input_lines(cells.ravel())
    ]
    return {
        **recommended(results),
        "decisions": table(decision.columns, cells.tolist(), numbers_from=len(decision.columns)),
        "input_lines": table(_HEAD, lines, numbers_from=len(_HEAD)),
    }
