"""The answers that a reader narrows by model, error, duration, kind and code: data of ``static/answers.js``."""

import json
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from paper.products import reader
from paper.tables.decision import column, limits_of, omega_step_of, sentence, steps_of
from paper.tables.models import MODELS
from study.runs.needs import CODES, TIED, cost, keeps_part
from study.scheme.codes import names_in_codes
from study.words import number

#: First choices of the form: the kind of model, and the allowed error.
FIRST = {"model": "frame under an earthquake", "error": "1 %"}

#: Variables of the needs that a row shows or is ranked by.
_USED = """step_size steps_per_period omega_step force_evaluations error largest_error smaller_steps verdict exponent
spacing duration""".split()

_FORM = """<form id="answers" class="narrow" hidden>
<label>model <select name="model"></select></label>
<label>error of <select name="quantity"></select></label>
<label>at most <select name="error"></select></label>
<label>over <input name="periods" type="number" min="0.1" step="any"> periods</label>
<label>scheme <select name="kind"><option value="">of any kind</option><option>explicit</option>\
<option>implicit</option></select></label>
<label>of <select name="code"></select></label>
</form>
<div id="answer" aria-live="polite"><p>The filters need JavaScript; the table of all recommendations does not.</p></div>
<script type="application/json" id="needs">DATA</script>
"""


def _number(value: float, digits: int = 6) -> float | None:
    return float(f"{value:.{digits}g}") if np.isfinite(value) else None


def _rows(needed: xr.Dataset, partly: xr.DataArray, limits: Mapping[str, float]) -> list[list[Any]]:
    """A row for each scheme that keeps an error: places of problem, quantity, error and scheme, then its numbers.

    The numbers are the step in words, the steps in a period, Δt·ω, the forces in a second of simulated time, the error
    by which ties are decided, the exponent of the law of :mod:`study.analysis.duration`, None if the law does not
    apply, the cost in a second, by which schemes are ranked, and whether the whole motion needs another step.
    """
    dims = ("problem", "quantity", "allowed_error", "scheme")
    rates = (cost(needed) / needed.duration).transpose(*dims).values
    wrong = partly.transpose(*dims).values
    used = needed.reset_coords(["spacing", "duration"])[_USED].transpose(*dims).reset_coords(drop=True)
    rows = []
    for places in np.argwhere(used.step_size.notnull().values).tolist():
        need = used.isel(dict(zip(dims, places, strict=True)))
        decides = need.largest_error if need.largest_error.notnull() else need.error
        rows.append(
            [
                *places,
                steps_of(need),
                _number(need.steps_per_period.item()),
                omega_step_of(need, limits),
                _number((need.force_evaluations / need.duration).item(), 12),
                _number(decides.item(), 12),
                _number(need.exponent.item(), 12),
                _number(rates[tuple(places)], 12),
                int(wrong[tuple(places)]),
            ]
        )
    return rows


def data(needed: xr.Dataset, limits: Mapping[str, float]) -> dict[str, Any]:
    """The needs of all schemes as lists of numbers and words; ``limits`` has the limits of Δt·ω by scheme."""
    partly = keeps_part(needed)
    needed = needed.sel(condition="practice")
    codes = defaultdict[str, dict[str, str]](dict)
    for entry in names_in_codes():
        codes[entry.scheme][entry.code] = entry.name
    models = {problem: model for model, (problem, _) in MODELS.items()}
    problems = [
        {
            "title": sentence(title) if name not in models else f"{sentence(models[name])}: {title}",
            "model": models.get(name, ""),
            "scale": number(scale, 2),
            "decided": decided,
            "duration": number(decided * scale, 3),
            "omega": number(omega, 3),
            "unknowns": unknowns,
            "records": name == "records",
            "timed": decides == "seconds",
        }
        for name, title, scale, decided, omega, unknowns, decides in zip(
            *(
                needed[variable].values.tolist()
                for variable in (
                    "problem",
                    "problem_title",
                    "time_scale",
                    "decided",
                    "highest_frequency",
                    "unknowns",
                    "cost",
                )
            ),
            strict=True,
        )
    ]
    schemes = [
        {"title": title, "explicit": bool(explicit), "codes": codes[name]}
        for name, title, explicit in zip(
            *(needed[variable].values.tolist() for variable in ("scheme", "scheme_title", "explicit")), strict=True
        )
    ]
    return {
        "first": FIRST,
        "programs": CODES,
        "tied": TIED,
        "problems": problems,
        "quantities": needed.quantity.values.tolist(),
        "errors": [column(error) for error in needed.allowed_error.values],
        "schemes": schemes,
        "codes": sorted({code for scheme in schemes for code in scheme["codes"]}),
        "rows": _rows(needed, partly, limits),
    }


def form(results: Path) -> str:
    """The form, its place for the answer and its data, as HTML in Markdown."""
    read = reader(results)
    answered = data(read("needs"), limits_of(read("spectral")))
    text = json.dumps(answered, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return _FORM.replace("DATA", text.replace("<", "\\u003c"))
