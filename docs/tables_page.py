"""The ledger of claims and all tables of the study as pages of the site, with filters."""

import html
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from docs.plan import LEDGER, TABLES
from docs.text import described, narrowed
from paper.manuscript import places
from study.io import read

#: Columns of the ledger, in the order of its page.
_COLUMNS = ("No.", "Verdict", "Claim", "Printed", "Ours", "Decided by", "Whose")


def _read(results: Path, name: str) -> pd.DataFrame:
    return read(results / "tables" / f"{name}.csv")


def _head(columns: Iterable[str], buttons: bool) -> str:
    names = (html.escape(name) for name in columns)
    inside = (f'<button type="button">{name}</button>' if buttons else name for name in names)
    return "<tr>" + "".join(f'<th scope="col">{content}</th>' for content in inside) + "</tr>"


def _claim(claim: dict[str, str]) -> str:
    verdict, _, reason = claim["Verdict"].partition("; ")
    shown = {name: html.escape(text) for name, text in claim.items()}
    shown["Verdict"] = f"<strong>{html.escape(verdict)}</strong>{html.escape('; ' * bool(reason) + reason)}"
    cells = "".join(f'<td class="{name.lower().split()[0].strip(".")}">{shown[name]}</td>' for name in _COLUMNS)
    return f'<tr data-verdict="{html.escape(verdict)}">{cells}</tr>'


def claims_page(results: Path) -> str:
    """The page of the ledger, with a filter by words and by verdict."""
    ledger = _read(results, LEDGER)
    counts = ledger["Verdict"].str.partition(";")[0].value_counts()
    choices = "".join(
        f'<option value="{html.escape(verdict)}">{html.escape(verdict)} ({count})</option>'
        for verdict, count in counts.items()
    )
    select = (
        f'<label>Verdict <select name="verdict"><option value="">all ({len(ledger)})</option>{choices}</select></label>'
    )
    rows = "\n".join(_claim(claim) for claim in ledger.to_dict("records"))
    table = narrowed(
        _head(_COLUMNS, buttons=True),
        rows,
        ("claims", "ledger of claims"),
        "energy, Houbolt, chaos, …",
        select,
        kind="ledger",
    )
    counted = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
    text = f"""# Ledger of claims

{len(ledger)} claims: {counted}. A verdict follows from the datasets by the rule under “decided by”. The words of the
paper of 1996 are in quotation marks. `results/claims.csv` has the same rows.

{table}"""
    description = (
        "Ledger of claims on time integration schemes, of the paper of 1996 and later ones: what was printed, what is "
        "computed, and the verdict, reproduced or not reproduced."
    )
    return described(description, text, hide_toc=True)


def _section(title: str, about: str, frame: pd.DataFrame) -> str:
    # an empty first cell repeats the cell above
    known = frame.iloc[:, 0].replace("", pd.NA).ffill().fillna("")
    rows = "\n".join(
        f'<tr data-words="{html.escape(words)}">' + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
        for words, row in zip(known, frame.to_numpy(), strict=True)
    )
    table = narrowed(_head(frame.columns, buttons=False), rows, ("rows", f"table: {title}"), "scheme, problem, …")
    return f"## {title}\n\n{about}\n\n{table}"


def tables_page(results: Path) -> str:
    """The page of all tables except the ledger, each with a filter by words."""
    shown, known, sections = [table for table in TABLES if table.name != LEDGER], places(), []
    for table in shown:
        place, about = known.get((table.kind, table.name)), (table.function.__doc__ or "").strip().splitlines()[0]
        sections.append(_section(table.title, about + (f" {place}." if place else ""), _read(results, table.name)))
    links = ", ".join(f"[{table.title}](#{table.title.lower().replace(' ', '-')})" for table in shown)
    first = "The tables of the study. `results/tables/` has them as CSV and LaTeX."
    text = "\n\n".join(["# All tables", first, f"{links}.", *sections]) + "\n"
    return described("All tables of the study of time integration schemes, each with a filter.", text, hide_toc=True)
