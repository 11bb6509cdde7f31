"""The table of all schemes, with sorting and filters."""

import html
import math
from collections.abc import Iterable

from docs.scheme_page import Library, Subject
from docs.text import described, narrowed
from docs.theory import ROUND_OFF, STEPS
from study.analysis.forces import forces_of
from study.scheme.codes import names_in_codes
from study.words import number, up_to

#: Heading of each column, and its meaning if the heading is not enough.
COLUMNS = {
    "scheme": "",
    "family": "",
    "kind": "",
    "order": "claimed order without damping and load; in brackets the least order with them, if it differs",
    "largest stable ωΔt": "without damping",
    "ρ∞": "spectral radius at infinite frequency",
    "period, %": f"relative error of the period at {STEPS} steps a period, in linear theory",
    "amplitude, %": f"loss of amplitude a period at {STEPS} steps a period, in linear theory",
    "forces": "evaluations of the force with several unknowns: per step if explicit, per Newton iteration if implicit",
    "memory": "vectors of the size of u that a step passes to the next",
    "time, ns": "median time of a step on the softening spring, at the smallest step size; a dash if not measured",
}


def _time(subject: Subject, library: Library) -> float:
    """Median time of a step on the softening spring, at the smallest step size, in ns; NaN if it was not measured."""
    times = 1e9 * library.data["work_precision"].median_seconds_per_step
    if subject.name not in times.scheme.values or "softening" not in times.problem.values:
        return math.nan
    return times.sel(scheme=subject.name, problem="softening").isel(steps_per_period=-1).item()


def _cells(subject: Subject, library: Library) -> list[str | float]:
    scheme, theory = subject.scheme, subject.theory
    decay, forces = theory.decay_of_rule, forces_of(scheme)
    return [
        scheme.title,
        scheme.family,
        "explicit" if scheme.explicit else "implicit",
        scheme.order,
        theory.limit,
        theory.at_infinity,
        100 * theory.elongation_of_rule,
        0.0 if abs(decay) < ROUND_OFF else 100 * decay,
        forces.per_step if scheme.explicit else forces.per_iteration,
        theory.linear.memory.item(),
        _time(subject, library),
    ]


def _row(subject: Subject, library: Library) -> str:
    title, *cells = _cells(subject, library)
    scheme = subject.scheme
    damped = "" if scheme.order_with_damping == scheme.order else f" ({scheme.order_with_damping})"
    called = [f"{entry.code} {entry.name}" for entry in names_in_codes() if entry.scheme == subject.name]
    words = html.escape(" ".join([subject.name, *library.aliases.get(subject.name, []), *called]))
    parts = [
        f'<td><input type="checkbox" aria-label="compare {html.escape(str(title))}"></td>',
        f'<th scope="row"><a href="{subject.name}.html">{html.escape(str(title))}</a></th>',
    ]
    for heading, cell in zip(list(COLUMNS)[1:], cells, strict=True):
        if isinstance(cell, str):
            parts.append(f"<td>{html.escape(cell)}</td>")
        else:
            printed = up_to(cell) if heading == "largest stable ωΔt" else number(cell)
            parts.append(f'<td data-value="{cell!r}">{printed}{damped if heading == "order" else ""}</td>')
    return f'<tr data-words="{words}">{"".join(parts)}</tr>'


def table_of(subjects: Iterable[Subject], library: Library) -> str:
    """The table as an element of a page."""
    heads = "".join(
        f'<th scope="col"><button type="button" title="{html.escape(meaning)}">{html.escape(name)}</button></th>'
        for name, meaning in COLUMNS.items()
    )
    rows = "\n".join(_row(subject, library) for subject in subjects)
    return narrowed(
        f'<tr><th scope="col"><span class="hidden">compare</span></th>{heads}</tr>',
        rows,
        ("schemes", "table of schemes"),
        "explicit, Verlet, OpenSees, …",
        '<label><input type="checkbox" name="chosen"> only schemes with a tick</label>',
        kind="schemes",
    )


def index_page(library: Library) -> str:
    """The page of the table, with a link to the page of every scheme."""
    subjects = [library.subject(name) for name in library.schemes]
    entries = "\n".join(f"{subject.scheme.title} <{subject.name}>" for subject in subjects)
    meanings = "\n".join(f"- **{name}**: {meaning}" for name, meaning in COLUMNS.items() if meaning)
    text = f"""# Time integration schemes: order, stability and numerical damping compared

{len(subjects)} schemes for M ü + C u̇ + p(u) = f(t), each with a page of its own. Click the heading of a column to sort
by it. Tick schemes to compare them side by side.

{table_of(subjects, library)}

{meanings}

Orders are the claimed orders; the pages of schemes give measured orders. Stability, damping and memory follow from the
code of each scheme by automatic differentiation. Times were measured on the machine that made this site. On a narrow
screen the table scrolls sideways. The box above it also finds schemes by their other names and by their names in codes.
{{doc}}`/how_to/choose` compares schemes at equal error.

```{{toctree}}
:hidden:

{entries}
```
"""
    description = (
        "Table of time integration schemes for structural dynamics: order, stability limit, spectral radius, period "
        "elongation, numerical damping, cost. Newmark, Wilson, Houbolt, HHT, generalized-α, Bathe, Runge-Kutta."
    )
    return described(description, text, hide_toc=True)
