"""The page: its data, its style and its scripts in one file that loads no other file."""

import html
import json
from pathlib import Path
from typing import Any

import xarray as xr

from paper.explorer.data import ERRORS, LOG_CODES, coarse, map_arrays, packed
from paper.figures.style import OUTCOME_STYLES
from paper.products import page
from paper.tables.decision import rows_of, steps_of

#: Initial state of the controls of the page; ``step`` is the step size divided by the period.
FIRST: dict[str, Any] = {
    "problem": "hardening",
    "schemes": ["average_acceleration", "central_difference"],
    "u0": 1.5,
    "step": 1 / 20,
    "error": 1.0,
    "colour": "error",
}
#: Names of the scripts, each after the scripts that it uses.
SCRIPTS = ("springs", "schemes", "data", "choice", "classes", "map", "panels", "page")
#: Names of the springs of the page.
PROBLEMS = ["hardening", "softening", "double_well"]
CASES = ["hardening", "softening", "softening_large", "double_well"]

_HERE = Path(__file__).parent


def _read(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def _schemes(atlas: xr.Dataset) -> list[dict[str, Any]]:
    """Name and title of each scheme, whether it is explicit, and its force evaluations per step and per iteration."""
    names = ("scheme", "scheme_title", "explicit", "force_evaluations_per_step", "force_evaluations_per_iteration")
    keys = ("name", "title", "explicit", "forces", "forcesPerIteration")
    return [
        dict(zip(keys, values, strict=True)) for values in zip(*(atlas[n].values.tolist() for n in names), strict=True)
    ]


def _problems(atlas: xr.Dataset) -> list[dict[str, Any]]:
    """Name and title of each spring, and its displacement at the relative amplitude one."""
    units = (atlas.u0 / atlas.amplitude).isel(amplitude=0).values.tolist()
    problems = zip(atlas.problem.values.tolist(), atlas.problem_title.values.tolist(), units, strict=True)
    return [{"name": name, "title": title, "unit": float(f"{unit:.12g}")} for name, title, unit in problems]


def _outcomes(outcome: xr.DataArray) -> list[dict[str, str]]:
    """Label, colour and meaning of each outcome, in the order of the numbers that stand for outcomes in the maps."""
    meanings, notes = outcome.attrs["flag_meanings"].split(), outcome.attrs["flag_explanations"].split("; ")
    return [
        {"label": OUTCOME_STYLES[name][0], "colour": OUTCOME_STYLES[name][1], "note": note}
        for name, note in zip(meanings, notes, strict=True)
    ]


def _decisions(decisions: xr.Dataset) -> list[dict[str, Any]]:
    """Scheme and number of steps in a period of each decision on the springs; the title is empty if there is none."""
    choices = []
    for problem, quantity, kind in rows_of(decisions):
        for error in decisions.allowed_error.values.tolist() if problem in PROBLEMS else ():
            decision = decisions.sel(problem=problem, quantity=quantity, kind=kind, allowed_error=error, filter="all")
            row = {"problem": problem, "quantity": quantity, "kind": kind, "error": 100 * error}
            shown = {
                "title": decision.scheme_title.item(),
                "steps": steps_of(decision) if decision.step_size > 0 else "",
            }
            choices.append(row | shown | {"periods": decision.decided.item(), "starts": decision.starts.item()})
    return choices


def _cases(cases: list[xr.Dataset]) -> list[dict[str, Any]]:
    """Spring, initial displacement and step size of each run of the paper."""
    # the problem softening_large is the softening spring from its large amplitude
    return [
        {
            "problem": next(name for name in PROBLEMS if case.problem.startswith(name)),
            "u0": case.u.isel(scheme=0, t=0).item(),
            "dt": case.step_size.item(),
        }
        for case in cases
    ]


def _as_script(value: object) -> str:
    """JSON that is safe in a page: no string in it can end the script."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


@page(
    "Explorer of the maps of stability: largest safe steps of all schemes, and the motion at each point of the maps.",
    name="explorer",
    atlas="stability/atlas",
    cases=[f"phase_portrait/{name}" for name in CASES],
    requires={"atlas.problems": PROBLEMS, "atlas.schemes": FIRST["schemes"]},
)
def explorer(atlas: xr.Dataset, cases: list[xr.Dataset], decisions: xr.Dataset) -> str:
    """The page as HTML with all its parts; equal data give equal text.

    Parameters
    ----------
    atlas
        Maps of stability.
    cases
        Runs of the paper, which the maps mark.
    decisions
        Cheapest schemes for allowed errors.
    """
    atlas = atlas.sel(problem=PROBLEMS)
    maps = coarse(atlas)
    places, content = packed(map_arrays(atlas))
    meta = {
        "first": FIRST,
        "periods": atlas.periods.item(),
        "problems": _problems(atlas),
        "schemes": _schemes(atlas),
        "outcomes": _outcomes(atlas.outcome),
        "errors": [100 * error for error in ERRORS],
        "decisions": _decisions(decisions),
        "amplitudes": maps.amplitude.values.tolist(),
        "steps": maps.step_size_over_period.values.tolist(),
        "cases": _cases(cases),
        "codes": LOG_CODES,
        "blocks": places,
    }
    shape = (
        f"{maps.sizes['amplitude']} of {atlas.sizes['amplitude']} amplitudes and "
        f"{maps.sizes['step_size_over_period']} of {atlas.sizes['step_size_over_period']} step sizes"
    )
    versions = ", ".join(f"{key} {atlas.attrs[key]}" for key in ("version", "commit") if key in atlas.attrs)
    parts = {
        "STYLE": _read("page.css"),
        "META": _as_script(meta),
        "CONTENT": content,
        "SCRIPT": "\n".join(_read(f"{name}.js") for name in SCRIPTS),
        "PERIODS": f"{atlas.periods.item():g}",
        "CELLS": shape,
        "MADE": html.escape(versions),
    }
    text = _read("page.html")
    for name, part in parts.items():
        text = text.replace(f"{{{{{name}}}}}", part)
    return text
