"""The full and the short table of decisions, and the input lines of their schemes, as parts of pages."""

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pandas as pd
import xarray as xr

import study
from docs.plan import DECISION, RECOMMENDED
from docs.text import table
from paper.picks import ERRORS, NO_BREAK, Pick, cell
from paper.products import made, reader
from paper.tables.decision import column, decided
from study.scheme.codes import NameInCode, names_in_codes
from study.words import number

#: Pattern of the title of a scheme in a cell: it precedes a number of steps, or ends a remark.
_TITLE = re.compile(r"(?:^|[:;] )([^:;\n]+)(?=[:;]|$)", re.MULTILINE)

#: Beginnings of the names of the programs whose schemes the short table compares.
_PROGRAMS = ("OpenSees", "Abaqus", "LS-DYNA")
_HEAD = ("scheme", "code", "name and parameters", "remark")
#: Quantities whose rows the short table shows.
_QUANTITIES = ("displacement", "peak drift")
_ERRORS = [column(error) for error in ERRORS]


def _short_cell(picks: list[Pick]) -> str:
    if not picks:
        return cell(picks)
    one = picks[0]
    counted = (one.step if one.step.endswith("ms") else f"{one.step} steps").replace(" ", NO_BREAK)
    return f"{one.title}: {counted}, ωΔt{NO_BREAK}={NO_BREAK}{number(one.omega_step, 2)}"


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

    choices = made(replace(RECOMMENDED, function=decided), of_programs)
    names = choices[["Problem", "Right in"]].replace("", pd.NA).ffill()
    chosen = choices.assign(**names)[names["Right in"].isin(_QUANTITIES)]
    picks = chosen[_ERRORS].map(_short_cell)
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
