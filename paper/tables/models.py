"""The short answer: scheme and step by kind of model."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.tables.decision import REQUIRES, answer, duration_of, limits_of, sentence

#: Problem and quantity that stand for each kind of model.
MODELS = {
    "frame under an earthquake": ("records", "peak drift"),
    "free vibration over a long time": ("softening", "displacement"),
    "yielding": ("yielding", "displacement"),
    "impact and contact": ("bouncing", "displacement"),
    "stiff constraint": ("elastic_pendulum", "displacement"),
    "stiff beside soft parts": ("stiff_soft", "displacement"),
    "mesh with a wave": ("impact_bar", "displacement"),
}
#: Allowed error of the answers, and the filter of their candidates.
ERROR, FILTER = 0.01, "codes"
#: Scheme that is taken by habit, with which the answers are compared.
USUAL = "average_acceleration"


def answers(decisions: xr.Dataset) -> dict[str, xr.Dataset]:
    """The decisions for an error of :data:`ERROR` by kind of model, among the schemes of :data:`FILTER`.

    A model whose problem was not run is left out.
    """
    chosen = decisions.sel(filter=FILTER, allowed_error=ERROR)
    return {
        model: chosen.sel(problem=problem, quantity=quantity)
        for model, (problem, quantity) in MODELS.items()
        if problem in chosen.problem.values
    }


def _measured(decision: xr.Dataset) -> str:
    """The problem, and the duration of its runs unless the records give it."""
    title = decision.problem_title.item()
    if decision.problem.item() == "records":
        return title
    return f"{title}, {duration_of(decision)}"


@table("Schemes and steps by kind of model", requires={**REQUIRES, "runs.allowed_errors": [ERROR]})
def tabulate(decisions: xr.Dataset, spectral: xr.Dataset) -> pd.DataFrame:
    """One row per kind of model: the explicit and the implicit scheme with their steps and Δt·ω, and what was run."""
    limits, rows = limits_of(spectral), []
    for model, decided in answers(decisions).items():
        row = {"Model": sentence(model)}
        for kind in decided.kind.values:
            words = answer(decided.sel(kind=kind), limits)
            row |= {sentence(kind): words["Scheme"]} | {f"{name}, {kind}": words[name] for name in ("Steps", "ωΔt")}
        rows.append(row | {"Measured on": _measured(decided)})
    return pd.DataFrame(rows)
