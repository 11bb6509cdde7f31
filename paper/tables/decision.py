"""Recommended explicit and implicit schemes, with their steps, for each problem, quantity and error."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.products import table
from paper.requirements import contained
from study.words import number

NO_BREAK = "\u00a0"
#: Mark of the coarsest step that was tried, before a number of steps, and of the finest, after it.
AT_MOST, FINEST = f"≤{NO_BREAK}", "\u00a0†"
#: Verdict of a search that ended at the coarsest step.
COARSEST = 1


def column(error: float) -> str:
    """The name of the column of an allowed error."""
    return f"{100 * error:g} %"


def sentence(title: str) -> str:
    """A title with a capital first letter, as at the beginning of a sentence."""
    return title[0].upper() + title[1:]


def steps_of(one: xr.Dataset) -> str:
    """The step of a need or decision: steps in a time scale, or its size in ms under records."""
    if one.problem.item() == "records":
        return f"{number(1e3 * one.step_size.item(), 2)} ms"
    # a multiple of the spacing of a record need not be a whole part of the time scale
    steps = f"{one.steps_per_period.item():,.1f}".removesuffix(".0")
    at_most = AT_MOST if one.verdict.item() == COARSEST else ""
    return f"{at_most}{steps}{FINEST if one.smaller_steps.item() == 0 else ''}"


def cost_of(one: xr.Dataset) -> str:
    """The number of forces in a time scale, or in a second under records, and the computing time if it decides."""
    if one.problem.item() == "records":
        return f"{one.force_evaluations.item():,.0f} forces/s"
    forces = f"{one.force_evaluations.item() * one.time_scale.item():,.0f} forces"
    if one.cost.item() != "seconds":
        return forces
    return f"{forces}, {number(1e3 * one.seconds.item() * one.time_scale.item(), 2)} ms"


def cell(one: xr.Dataset, limits: dict[str, float]) -> str:
    """A decision: the scheme, its step, cost and Δt·ω, and ``…`` if others tie; a dash if no scheme keeps the error."""
    if not one.step_size > 0:
        return "–"
    limit = limits.get(one.scheme.item(), np.inf)
    below = f" < {limit:.3g}" if np.isfinite(limit) else ""
    condition = f"ωΔt {number(one.omega_step.item(), 2)}{below}"
    work, condition = (part.replace(" ", NO_BREAK) for part in (cost_of(one), condition))
    return f"{one.scheme_title.item()}: {steps_of(one)} ({work}, {condition})" + ("; …" if one.ties > 1 else "")


def rows_of(decisions: xr.Dataset) -> list[tuple[str, str, str]]:
    """Problem, quantity and kind of each row: those for which some scheme has the quantity on the problem."""
    has = (decisions.verdict != decisions.verdict.attrs["flag_values"][-1]).any(["allowed_error", "filter", "kind"])
    quantities = [name for name in TABULATED if name in decisions.quantity.values]
    return [
        (problem, quantity, kind)
        for problem in decisions.problem.values
        for quantity in quantities
        if has.sel(problem=problem, quantity=quantity)
        for kind in decisions.kind.values
    ]


#: Quantities of the rows, in their order.
TABULATED = ("displacement", "energy", "peak drift")


def _beware(decided: xr.Dataset) -> str:
    """Remark if other schemes or steps are chosen where the whole motion must be right."""
    row, whole = decided.sel(filter="all"), decided.sel(filter="whole_motion")
    same = (row.scheme == whole.scheme) & ((row.step_size == whole.step_size) | row.step_size.isnull())
    return "" if same.all() else "the whole motion needs other steps"


def tabulated(decisions: xr.Dataset, limits: dict[str, float], chosen: str) -> pd.DataFrame:
    """The decisions with one filter, a row for each problem, quantity and kind."""
    rows, before = [], ("", "")
    for problem, quantity, kind in rows_of(decisions):
        one = decisions.sel(problem=problem, quantity=quantity, kind=kind)
        row = one.sel(filter=chosen)
        rows.append(
            {
                "Problem": sentence(one.problem_title.item()) if problem != before[0] else "",
                "Right in": quantity if (problem, quantity) != before else "",
                "Scheme": kind,
                **{column(error): cell(row.sel(allowed_error=error), limits) for error in row.allowed_error.values},
                "Beware of": _beware(one),
            }
        )
        before = problem, quantity
    return pd.DataFrame(rows)


def limits_of(spectral: xr.Dataset) -> dict[str, float]:
    """Stability limits of Δt·ω in undamped linear theory, by scheme."""
    return spectral.stability_limit.sel(damping_ratio=0.0).to_series().to_dict()


_REQUIRES = {
    "": contained("runs.schemes", "spectrum.schemes", "structures.schemes", within="spectral.schemes"),
    "spectral.damping_ratios": [0.0],
}


@table("Recommended schemes and steps", requires=_REQUIRES)
def tabulate(decisions: xr.Dataset, spectral: xr.Dataset) -> pd.DataFrame:
    """One row per problem, quantity and kind of scheme; a dash where no scheme keeps the error.

    A cell names the scheme of its kind with the fewest evaluations of the force, or with the shortest computing time
    for 100 and more unknowns. Costs within a tenth tie, and the smallest error then decides. A cell contains the steps
    in a time scale and, in brackets, the forces in a time scale and Δt·ω with the highest ω of the motion, followed by
    the stability limit of linear theory if there is one. Under records, the step in ms replaces the number of steps,
    and the forces are those per second.
    """
    return tabulated(decisions, limits_of(spectral), "all")
