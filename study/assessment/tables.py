"""Tables of the page of an assessment."""

import itertools
from collections.abc import Container, Iterable, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from study.analysis.recommendation import asked_for, best_of, controller_answer, firsts, own_scheme_answer
from study.assessment.assurance import percent
from study.scheme.codes import names_in_codes
from study.scheme.named import schemes
from study.words import listed, number, printed, step_with_unit, text_of


def time_in_words(seconds: float) -> str:
    """A time in s, ms, µs or ns, with three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def table_of(
    head: Iterable[str],
    rows: Iterable[Iterable[object]],
    text: tuple[int, ...] = (),
    strong: Container[tuple[int, int]] = (),
    groups: Sequence[str] = (),
) -> str:
    """A table of HTML.

    ``text`` has the indices, from zero, of the columns of text, and ``strong`` those of rows and columns of cells in
    bold type. ``groups`` has headings above equal numbers of the last columns, whose first ones are set apart.
    """
    head = list(head)
    width = (len(head) - 2) // len(groups) if groups else 0

    def row_of(tag: str, row: list[object], place: int = -1) -> str:
        kinds = (
            ' class="text"' if i in text else ' class="group"' if width and i > 1 and (i - 2) % width == 0 else ""
            for i in itertools.count()
        )
        # an empty cell in the head of the table is not marked as a heading
        tags = (tag if cell else "td" for cell in row)
        words = (f"<b>{text_of(cell)}</b>" if (place, i) in strong else text_of(cell) for i, cell in enumerate(row))
        return "".join(f"<{t}{kind}>{word}</{t}>" for t, kind, word in zip(tags, kinds, words, strict=False))

    above = "".join(f'<th class="group" colspan="{width}" scope="colgroup">{text_of(group)}</th>' for group in groups)
    above = f'<tr><td colspan="2"></td>{above}</tr>' if groups else ""
    cells = f"{above}<tr>{row_of('th', [*head])}</tr>"
    body = "".join(f"<tr>{row_of('td', list(row), place)}</tr>" for place, row in enumerate(rows))
    style = ' class="tight"' if groups else ""
    return f'<div class="scroll" tabindex="0"><table{style}><thead>{cells}</thead><tbody>{body}</tbody></table></div>'


def input_lines(titles: Iterable[str]) -> list[str]:
    """Heading and table of the input of schemes in other codes; empty if no code has a scheme with these titles."""
    title_set = set(titles)
    named = ((schemes[entry.scheme].title, entry.code, entry.name, entry.note) for entry in names_in_codes())
    rows = [row for row in named if row[0] in title_set]
    return ["<h2>In other codes</h2>", table_of(("", "code", "input", ""), rows, text=(1, 2, 3))] if rows else []


def needs(table: pd.DataFrame, titles: dict[str, str]) -> str:
    """Tables of the steps that schemes need, one table for each kind of scheme, the fastest scheme first."""
    spacing = table.attrs.get("spacing")
    head = ("", "Δt (unrounded)", "Δt·ω", "steps", "error", "time", "forces/s", "tried", "search")
    parts = []
    for kind, group in table.groupby("kind", sort=False):
        rows = [
            (
                titles[row.Index],
                f"{step_with_unit(row.step_size, spacing)} ({step_with_unit(row.largest_step_size)})",
                number(row.omega_step, 2),
                f"{row.steps:.0f}",
                percent(row.error),
                "–"
                if np.isnan(row.seconds)
                else f"{time_in_words(row.seconds)} ± {time_in_words(row.seconds_spread / 2)}",
                number(row.force_evaluations_per_time),
                row.steps_tried,
                row.verdict,
            )
            if row.step_size > 0
            else (titles[row.Index], *"–––––––", row.verdict)
            for row in group.itertuples()
        ]
        parts.append(table_of((kind, *head[1:]), rows))
    return "".join(parts)


def controlled(tables: list[pd.DataFrame], limits: Iterable[float], titles: dict[str, str]) -> str:
    """A table of the tolerances that keep the allowed errors; empty if there is no such tolerance."""
    if "tolerance" not in tables[0] or all(table["tolerance"].isna().all() for table in tables):
        return ""
    names = ["tolerance", "controlled_force_evaluations", "control_over_equal"]
    rows = [
        [titles[scheme], kind, *(number(value, 3) for table in tables for value in table.loc[scheme, names])]
        for scheme, kind in tables[len(tables) // 2]["kind"].items()
    ]
    groups = [percent(limit) for limit in limits]
    head = ["controlled steps", "", *["tolerance", "forces", "× equal steps"] * len(groups)]
    return table_of(head, rows, groups=groups)


def answers(assessed: xr.Dataset, tables: list[pd.DataFrame], quantity: str, titles: dict[str, str]) -> str:
    """A table with a line for each allowed error: what was asked for first, then the best scheme and step of each kind.

    The requested scheme or controller, otherwise the fastest scheme, is in bold type.

    Parameters
    ----------
    tables
        Table of :func:`study.recommend` for each allowed error.
    """
    requested = asked_for(assessed)
    head = [f"error of {quantity}", *(titles[name] for name in requested)]
    if "controller" in assessed.attrs:
        head.append(f"controlled steps, {assessed.attrs['controller']} (× forces of equal steps)")
    kinds = sorted({kind for table in tables for kind in firsts(table)["kind"]})
    rows, strong = [], []
    for i, (limit, table) in enumerate(zip(assessed.allowed_error.values, tables, strict=True)):
        cells = [own_scheme_answer(assessed, table, name) for name in requested]
        if "tolerance" in table:
            words, ratio = controller_answer(assessed, table)
            cells.append(printed(f"{words} ({ratio})" if ratio else words))
        best = {row["kind"]: best_of(assessed, row) for _, row in firsts(table).iterrows()}
        fastest = len(cells) + 1 + kinds.index(next(iter(best))) if best else 1
        strong.append((i, 1 if cells else fastest))
        none = [f"no scheme was found ({listed(sorted(set(table.verdict)))})"]
        rows.append((percent(limit), *cells, *([best.get(kind, "–") for kind in kinds] if best else none)))
    head += kinds or ["scheme"]
    return table_of(head, rows, text=tuple(range(1, len(head))), strong=strong)


def _cells(table: pd.DataFrame, name: str, counts: str) -> tuple[str, str, str]:
    """Step, number of forces or steps, and time of a scheme."""
    row = table.loc[name]
    time = "–" if np.isnan(row.seconds) else time_in_words(row.seconds)
    step = step_with_unit(row.step_size, table.attrs.get("spacing")) if row.step_size > 0 else "–"
    return step, number(row[counts], 4), time


def summary(
    tables: list[pd.DataFrame], limits: Iterable[float], titles: dict[str, str], requested: Sequence[str]
) -> str:
    """A table of steps, forces and times of all schemes for all allowed errors.

    The requested schemes are first, then the fastest of each kind. Where forces are not counted, the number of steps
    stands in their place. A sentence states why steps are missing.
    """
    counted = any(table["force_evaluations"].notna().any() for table in tables)
    counts, label = ("force_evaluations", "forces") if counted else ("steps", "steps")
    groups = [percent(limit) for limit in limits]
    kinds = tables[len(tables) // 2]["kind"]
    by_kind = [name for _, group in kinds.groupby(kinds, sort=False) for name in group.index]
    rows = [
        [titles[name], kinds[name], *(cell for table in tables for cell in _cells(table, name, counts))]
        for name in dict.fromkeys([*requested, *by_kind])
    ]
    table = table_of(["", "", *["Δt", label, "time"] * len(groups)], rows, groups=groups)
    missing = [
        f"{titles[row.Index]} for {percent(limit)} ({row.verdict})"
        for limit, table in zip(limits, tables, strict=True)
        for row in table.itertuples()
        if not row.step_size > 0
    ]
    return table + (f"<p>No step was found for {text_of('; '.join(missing))}.</p>" if missing else "")
