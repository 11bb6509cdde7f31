"""The table of decisions, and the input lines of its schemes in other codes, as parts of a page."""

import re
from pathlib import Path

import pandas as pd

import study
from docs.plan import DECISION
from docs.text import table
from study.scheme.codes import names_in_codes

#: The title of a scheme in a cell: before a number of steps, or at the end of a remark.
_TITLE = re.compile(r"(?:^|[:;] )([^:;\n]+)(?=[:;]|$)", re.MULTILINE)


def tables(results: Path) -> dict[str, str]:
    """Both tables in Markdown, by name."""
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
        "decisions": table(decision.columns, cells.tolist(), numbers_from=len(decision.columns)),
        "input_lines": table(head, lines, numbers_from=len(head)),
    }
