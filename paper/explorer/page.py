"""The page: its data, its style and its scripts in one file that loads nothing."""

import html
import json
from pathlib import Path
from typing import Any

import xarray as xr

from paper.explorer.data import (
    EXPONENT_CODES,
    HEIGHT_CODES,
    LEAST,
    LOG_CODES,
    MOST,
    coarse,
    of_cases,
    of_maps,
    of_runs,
    packed,
)
from paper.figures.style import OUTCOME_STYLES
from paper.products import page

#: What is shown first: the most surprising run of the paper, by two of its schemes.
FIRST: dict[str, Any] = {"run": "softening_large", "schemes": ["hht_alpha_1996", "average_acceleration"]}
#: Scripts in the order in which they build on each other.
SCRIPTS = ("data", "choice", "classes", "map", "panels", "page")
CASES = ["hardening", "softening", "softening_large", "double_well"]

_HERE = Path(__file__).parent


def _read(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def _named(dataset: xr.Dataset, name: str) -> list[dict[str, str]]:
    """Name and title of everything along a coordinate."""
    titles = dataset[f"{name}_title"].values.tolist()
    return [{"name": n, "title": title} for n, title in zip(dataset[name].values.tolist(), titles, strict=True)]


def _outcomes(outcome: xr.DataArray) -> list[dict[str, str]]:
    """Label, colour and meaning of each outcome, in the order of the map's numbers."""
    meanings, told = outcome.attrs["flag_meanings"].split(), outcome.attrs["flag_explanations"].split("; ")
    return [
        {"name": name, "label": OUTCOME_STYLES[name][0], "colour": OUTCOME_STYLES[name][1], "note": note}
        for name, note in zip(meanings, told, strict=True)
    ]


def _as_script(value: object) -> str:
    """JSON that may stand in a page: no text in it can end the script."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


@page(
    "Explorer of the maps of stability: outcome, orbit, energy and largest safe step.",
    name="explorer",
    atlas="stability/atlas",
    portraits="stability/portraits",
    amplitudes="reference/amplitudes",
    cases=[f"phase_portrait/{name}" for name in CASES],
    references=[f"reference/{name}" for name in CASES],
    asks={"atlas.problems": ["hardening", "softening", "double_well"], "atlas.schemes": FIRST["schemes"]},
)
def explorer(
    atlas: xr.Dataset,
    portraits: xr.Dataset,
    amplitudes: xr.Dataset,
    cases: list[xr.Dataset],
    references: list[xr.Dataset],
) -> str:
    """The page with all that it needs, the same text for the same data.

    Parameters
    ----------
    atlas, portraits
        Maps of stability, and samples of some of their runs.
    amplitudes
        Exact orbits at the amplitudes of the maps.
    cases, references
        The paper's own runs, which the maps mark, and the exact motion of each.
    """
    maps = coarse(atlas)
    described, blocks = of_cases(atlas, cases, references)
    places, content = packed(of_maps(atlas) | of_runs(portraits, amplitudes) | blocks)
    meta = {
        "first": FIRST,
        "periods": atlas.periods.item(),
        "problems": _named(atlas, "problem"),
        "schemes": _named(atlas, "scheme"),
        "outcomes": _outcomes(atlas.outcome),
        "amplitudes": maps.amplitude.values.tolist(),
        "parts": maps.dt_over_period.values.tolist(),
        "sampled": {
            "amplitudes": portraits.amplitude.values.tolist(),
            "parts": portraits.dt_over_period.values.tolist(),
            "every": portraits.every.values.tolist(),
            "earlyEvery": portraits.early_every.values.tolist(),
            "samples": portraits.sizes["sample"],
        },
        "cases": described,
        "codes": {"height": HEIGHT_CODES, "log": LOG_CODES, "exponent": EXPONENT_CODES, "least": LEAST, "most": MOST},
        "blocks": places,
    }
    shape = (
        f"{maps.sizes['amplitude']} of {atlas.sizes['amplitude']} amplitudes and {maps.sizes['dt_over_period']} of "
        f"{atlas.sizes['dt_over_period']} step sizes"
    )
    made = ", ".join(f"{key} {atlas.attrs[key]}" for key in ("version", "commit") if key in atlas.attrs)
    parts = {
        "STYLE": _read("page.css"),
        "META": _as_script(meta),
        "CONTENT": content,
        "SCRIPT": "\n".join(_read(f"{name}.js") for name in SCRIPTS),
        "PERIODS": f"{atlas.periods.item():g}",
        "CELLS": shape,
        "MADE": html.escape(made),
    }
    text = _read("page.html")
    for name, part in parts.items():
        text = text.replace(f"{{{{{name}}}}}", part)
    return text
