"""The full and the short table of decisions, and the input lines of their schemes, as parts of pages."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import xarray as xr

import study
from docs.text import table
from paper.claims.chaos import fewest_steps_of_mean, ueda_of
from paper.numbers.chaos import MEAN_ERROR
from paper.products import reader
from paper.tables.decision import (
    NO_BREAK,
    answer,
    beware,
    column,
    duration_of,
    limits_of,
    omega_step_of,
    rows_of,
    sentence,
    steps_of,
)
from paper.tables.models import FILTER, USUAL, answers
from study.runs.needs import CODES, FILTERS, KINDS, MOTION, cheapest, keeps_part
from study.scheme.codes import NameInCode, names_in_codes
from study.words import number, step_with_unit

#: Mark of a step that keeps its quantity, while the whole motion needs another step.
PARTLY = "‡"

_HEAD = ("scheme", "code", "name and parameters", "remark")


def _unbroken(words: str) -> str:
    return words.replace(" ", NO_BREAK)


def step_cell(need: xr.Dataset) -> str:
    """The step of a need or decision with its unit; a dash if no step keeps the error."""
    if not need.step_size > 0:
        return "–"
    step = steps_of(need)
    return _unbroken(step if need.problem.item() == "records" else f"{step} steps")


def short_cell(decision: xr.Dataset, limits: Mapping[str, float], costs: bool = False) -> str:
    """A decision in words: scheme, step, ωΔt and its stability limit; a dash if no scheme keeps the error.

    With ``costs``, the number of forces follows, the computing time if it decides, and ``…`` if other schemes tie.
    """
    words = answer(decision, limits)
    if not words["Steps"]:
        return words["Scheme"]
    limit = f" (limit{NO_BREAK}{words['Limit']})" if words["Limit"] else ""
    parts = [step_cell(decision), f"{_unbroken('ωΔt = ' + words['ωΔt'])}{limit}"]
    if costs:
        parts.append(_unbroken(f"{words['Forces']} forces{'/s' if decision.problem.item() == 'records' else ''}"))
        parts += [_unbroken(f"{words['Time [ms]']} ms")] * bool(words["Time [ms]"]) + ["…"] * bool(words["Ties"])
    return f"{words['Scheme']}: {', '.join(parts)}"


def _decided(
    decisions: xr.Dataset, limits: Mapping[str, float], costs: bool = False, needs: xr.Dataset | None = None
) -> dict[tuple, list[str]]:
    """The cells of each problem, quantity and kind, one for each allowed error.

    With ``needs``, a cell ends with ``PARTLY`` if the whole motion needs another step.
    """
    rows, partly = {}, None if needs is None else keeps_part(needs)
    place = ("problem", "quantity", "allowed_error", "scheme")
    for problem, quantity, kind in rows_of(decisions.expand_dims("filter")):
        decision = decisions.sel(problem=problem, quantity=quantity, kind=kind)
        cells = [decision.sel(allowed_error=error) for error in decision.allowed_error.values]
        title = sentence(decision.problem_title.item())
        marks = [
            partly is not None and cell.step_size > 0 and partly.sel({name: cell[name] for name in place})
            for cell in cells
        ]
        rows[title, quantity, kind] = [
            f"{short_cell(cell, limits, costs)}{f'{NO_BREAK}{PARTLY}' if mark else ''}"
            for cell, mark in zip(cells, marks, strict=True)
        ]
    return rows


def _input_lines(schemes: Iterable[str], codes: tuple[str, ...] = ("",)) -> list[NameInCode]:
    """Names that codes give to schemes. The name of each code begins with an entry of ``codes``."""
    names = set(schemes)
    return [entry for entry in names_in_codes() if entry.code.startswith(codes) and entry.scheme in names]


def recommended(results: Path) -> dict[str, str]:
    """The schemes of OpenSees, Abaqus and LS-DYNA for three errors, and their input lines, as tables in Markdown."""
    read = reader(results)
    decisions = read("decisions").sel(filter="codes")
    shown = decisions.sel(quantity=[name for name in MOTION if name in decisions.quantity.values])
    decided = _decided(shown, limits_of(read("spectral")), needs=read("needs"))
    chosen = {*shown.scheme.values.ravel()}
    lines = [
        [study.schemes[entry.scheme].title, entry.code, f"`{entry.name}`", entry.note]
        for entry in _input_lines(chosen, CODES)
    ]
    errors = [column(error) for error in decisions.allowed_error.values]
    return {
        "recommended": table(
            ["problem", "kind", *errors],
            [[problem, kind, *cells] for (problem, _, kind), cells in decided.items()],
            numbers_from=2 + len(errors),
        ),
        "recommended_lines": table(_HEAD, lines, numbers_from=len(_HEAD)),
    }


def measured(decision: xr.Dataset) -> str:
    """What was run for a decision: the problem, its unknowns if there are several, the duration and the starts."""
    title, starts = sentence(decision.problem_title.item()), decision.starts.item()
    if decision.problem.item() == "records":
        return f"{title}: {starts} runs, samples every {number(1e3 * decision.spacing.item())} ms"
    unknowns = decision.unknowns.item()
    parts = [
        title,
        *([f"{unknowns} unknowns"] if unknowns > 1 else []),
        f"{duration_of(decision)} of T = {number(decision.time_scale.item(), 2)} s",
        f"{starts} {'record' if decision.spacing > 0 else 'start'}{'s' * (starts != 1)}",
    ]
    return ", ".join(parts)


def _chaos(chaos: xr.Dataset, lines: Mapping[str, str]) -> list[str]:
    """The row of chaotic motion, with the steps that keep a mean square within the allowed error."""
    needed, ueda = fewest_steps_of_mean(chaos, MEAN_ERROR), ueda_of(chaos)
    steps = {name: _unbroken(f"{number(needed[name])} steps") for name in ("central_difference", USUAL)}
    runs = f"{ueda.periods.item()} periods T of the load, {ueda.runs.item()} starts"
    return [
        "chaos: averages alone",
        *(f"{study.schemes[name].title}: {cell}" for name, cell in steps.items()),
        ", ".join(lines[name] for name in steps),
        steps[USUAL],
        f"Mean square of Ueda's oscillator, {runs}",
    ]


def by_model(results: Path) -> str:
    """The schemes of the programs for an error of one percent by kind of model, as a table in Markdown.

    The cheaper of the explicit and the implicit scheme is in bold type. The row of chaotic motion is that of a mean,
    since no step keeps the displacement.
    """
    read = reader(results)
    decisions, limits = answers(read("decisions")), limits_of(read("spectral"))
    usual = read("needs").sel(scheme=USUAL, condition=FILTERS[FILTER][0])
    chosen = {name for decision in decisions.values() for name in decision.scheme.values.ravel()}
    chosen |= {"central_difference", USUAL}
    entries = _input_lines(chosen, ("OpenSees",))
    lines = {entry.scheme: f"`{entry.name.removeprefix('integrator ')}`" for entry in entries}
    rows = []
    for model, decision in decisions.items():
        kinds = [decision.sel(kind=kind) for kind in KINDS]
        cells = [short_cell(kind, limits) for kind in kinds]
        if (decision.step_size > 0).any():
            best = cheapest(decision, "kind").item()
            cells[best] = f"**{cells[best]}**"
        named = ", ".join(lines.get(kind.scheme.item(), "–") for kind in kinds)
        need = usual.sel({name: decision[name] for name in ("problem", "quantity", "allowed_error")})
        omega_step = f", {_unbroken(f'ωΔt = {omega_step_of(need, limits)}')}" if need.step_size > 0 else ""
        rows.append([model, *cells, named, step_cell(need) + omega_step, measured(decision)])
    rows.append(_chaos(read("chaos"), lines))
    head = ["model", "explicit", "implicit", "OpenSees `integrator` of both", "by average acceleration", "measured"]
    return table(head, rows, numbers_from=len(head))


def frame(results: Path) -> str:
    """The steps for the peak drift under all records by scheme and period, as a table in Markdown."""
    read = reader(results)
    decision = answers(read("decisions"))["frame under an earthquake"]
    chosen = dict.fromkeys([*filter(None, decision.scheme.values.tolist()), USUAL])
    spectrum = read("spectrum")
    needed = spectrum.largest_step_size.sel(condition="practice").min(["record", "reduction"], skipna=False)
    spacing = spectrum.spacing.item()
    rows = [
        [
            study.schemes[name].title,
            *(step_with_unit(step, spacing) if step > 0 else "–" for step in needed.sel(scheme=name).values),
        ]
        for name in chosen
    ]
    head = ["scheme", *(f"T = {number(period)} s" for period in needed.period.values)]
    return table(head, rows, numbers_from=1)


def tables(results: Path) -> dict[str, str]:
    """All tables of decisions and of input lines in Markdown, by name."""
    read = reader(results)
    decisions = read("decisions")
    chosen = decisions.scheme.values.ravel()
    decided = _decided(decisions.sel(filter="all"), limits_of(read("spectral")), costs=True)
    names = ("problem", "quantity", "kind")
    remarks = [beware(decisions.sel(dict(zip(names, row, strict=True)))) for row in rows_of(decisions)]
    rows = [[*row, *cells, remark] for (row, cells), remark in zip(decided.items(), remarks, strict=True)]
    errors = [column(error) for error in decisions.allowed_error.values]
    head = ["problem", "right in", "kind", *errors, "beware of"]
    lines = [
        [
            f"[{study.schemes[entry.scheme].title}](/schemes/{entry.scheme}.md)",
            entry.code,
            f"`{entry.name}`",
            entry.note,
        ]
        for entry in _input_lines(chosen)
    ]
    return {
        **recommended(results),
        "by_model": by_model(results),
        "frame": frame(results),
        "decisions": table(head, rows, numbers_from=len(head)),
        "input_lines": table(_HEAD, lines, numbers_from=len(_HEAD)),
    }
