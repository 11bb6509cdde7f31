"""Tables of the page of an assessment."""

import itertools
from collections.abc import Iterable

import numpy as np
import pandas as pd
import xarray as xr

from study.assessment.assurance import percent
from study.scheme.codes import names_in_codes
from study.scheme.named import schemes
from study.words import number, step_size, text_of


def time_in_words(seconds: float) -> str:
    """A time in s, ms, µs or ns, with three digits."""
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


def input_lines(assessed: xr.Dataset) -> list[str]:
    """Heading and table of the recommended schemes' input in other codes; empty if no code has such a scheme."""
    recommended = assessed.recommended_dt.notnull().any(["quantity", "allowed_error"]).values
    titles = set(assessed.scheme_title.values[recommended])
    named = ((schemes[one.scheme].title, one.code, one.name, one.note) for one in names_in_codes())
    rows = [row for row in named if row[0] in titles]
    return ["<h2>In other codes</h2>", table_of(("", "code", "input", ""), rows, text=(1, 2, 3))] if rows else []


def needs(table: pd.DataFrame, titles: dict[str, str]) -> str:
    """Tables of the steps that schemes need, one table for each kind of scheme, the fastest scheme first."""
    spacing = table.attrs.get("spacing")
    head = ("", "Δt (unrounded), s", "Δt·ω", "steps", "error", "time", "forces/s", "tried", "search")
    parts = []
    for kind, of_kind in table.groupby("kind", sort=False):
        rows = [
            (
                titles[row.Index],
                f"{step_size(row.step_size, spacing)} ({step_size(row.largest_step)})",
                number(row.omega_step, 2),
                f"{row.number_of_steps:.0f}",
                percent(row.error),
                "–" if np.isnan(row.time) else f"{time_in_words(row.time)} ± {time_in_words(row.time_spread / 2)}",
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


def controlled(table: pd.DataFrame, titles: dict[str, str]) -> str:
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
