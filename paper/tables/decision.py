"""Recommended explicit and implicit schemes, with their steps, for each problem, quantity and error."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from paper.products import table
from paper.requirements import contained
from study.runs.needs import DECIDED, NO_VALUE
from study.words import number, step_size, up_to

NO_BREAK = "\u00a0"
#: Mark of the coarsest step that was tried, before a number of steps, and of the finest, after it.
AT_MOST, FINEST = f"≤{NO_BREAK}", "\u00a0†"
#: Columns of an answer.
COLUMNS = ("Scheme", "Ties", "Steps", "Forces", "Time [ms]", "ωΔt", "Limit")
#: Verdict of a search that ended at the coarsest step.
COARSEST = 1


def column(error: float) -> str:
    """The name of the column of an allowed error."""
    return f"{100 * error:g} %"


def sentence(title: str) -> str:
    """A title with a capital first letter, as at the beginning of a sentence."""
    return title[0].upper() + title[1:]


def duration_of(decision: xr.Dataset) -> str:
    """The duration for which the steps of a decision hold, in words, such as ``10 periods`` or ``1 turn``."""
    periods, (first, *others) = decision.decided.item(), decision.time_scale_name.item().split()
    return " ".join([number(periods), f"{first}{'s' * (periods != 1)}", *others])


def steps_of(need: xr.Dataset) -> str:
    """The step of a need or decision: steps in a time scale, or its size in ms under records."""
    if need.problem.item() == "records":
        steps = f"{step_size(1e3 * need.step_size.item(), 1e3 * need.spacing.item())} ms"
    else:  # a multiple of the spacing of a record need not be a whole part of the time scale
        steps = f"{need.steps_per_period.item():,.1f}".removesuffix(".0")
    at_most = AT_MOST if need.verdict.item() == COARSEST else ""
    return f"{at_most}{steps}{FINEST if need.smaller_steps.item() == 0 else ''}"


def forces_of(need: xr.Dataset) -> str:
    """The number of forces in a time scale, or in a second under records."""
    times = need.duration if need.problem.item() == "records" else need.decided
    return f"{(need.force_evaluations / times).item():,.0f}"


def omega_step_of(need: xr.Dataset, limits: Mapping[str, float]) -> str:
    """Δt·ω with two digits, or with more if a value just below the limit would be printed as the limit."""
    omega_step, limit = need.omega_step.item(), limits.get(need.scheme.item(), np.inf)
    digits = next((digits for digits in range(2, 7) if f"{omega_step:.{digits}g}" != f"{limit:.{digits}g}"), 2)
    return number(omega_step, digits)


def answer(need: xr.Dataset, limits: Mapping[str, float]) -> dict[str, str]:
    """A decision as words and numbers, by column; the scheme is a dash if none keeps the error.

    ``limits`` has the limits of Δt·ω by scheme. The computing time is stated if it decides. A column is empty if it
    does not apply.
    """
    if not need.step_size > 0:
        return {name: "–" if name == "Scheme" else "" for name in COLUMNS}
    times = number(1e3 * (need.seconds / need.decided).item(), 2) if need.cost.item() == "seconds" else ""
    limit = limits.get(need.scheme.item(), np.inf)
    cells = (
        need.scheme_title.item(),
        "…" if need.ties > 1 else "",
        steps_of(need),
        forces_of(need),
        times,
        omega_step_of(need, limits),
        up_to(limit) if np.isfinite(limit) else "",
    )
    return dict(zip(COLUMNS, cells, strict=True))


def rows_of(decisions: xr.Dataset) -> list[tuple[str, str, str]]:
    """Problem, quantity and kind of each row: those for which some scheme has the quantity on the problem."""
    has = (decisions.verdict != decisions.verdict.attrs["flag_values"][-1]).any(["allowed_error", "filter", "kind"])
    quantities = [name for name in DECIDED if name in decisions.quantity.values]
    return [
        (problem, quantity, kind)
        for problem in decisions.problem.values
        for quantity in quantities
        if has.sel(problem=problem, quantity=quantity)
        for kind in decisions.kind.values
    ]


def beware(decided: xr.Dataset) -> str:
    """Remark if other schemes or steps are chosen where the whole motion must be right."""
    row, whole = decided.sel(filter="all"), decided.sel(filter="whole_motion")
    same = (row.scheme == whole.scheme) & ((row.step_size == whole.step_size) | row.step_size.isnull())
    return "" if (same | (whole.verdict == NO_VALUE)).all() else "the whole motion needs other steps at some error"


def limits_of(spectral: xr.Dataset) -> dict[str, float]:
    """Stability limits of Δt·ω in undamped linear theory, by scheme."""
    return spectral.stability_limit.sel(damping_ratio=0.0).to_series().to_dict()


#: Requirements on the configuration of tables with limits of stability.
REQUIRES = {
    "": contained("runs.schemes", "spectrum.schemes", "structures.schemes", within="spectral.schemes"),
    "spectral.damping_ratios": [0.0],
}


@table("Recommended schemes and steps", requires=REQUIRES)
def tabulate(decisions: xr.Dataset, spectral: xr.Dataset) -> pd.DataFrame:
    """One row per problem, quantity, kind of scheme and error; a dash where no scheme keeps the error.

    The scheme is that of its kind with the fewest evaluations of the force, or with the shortest computing time for 100
    and more unknowns. Costs within a tenth tie, and the smallest error then decides. Steps, forces and time are those
    in a time scale, ω is the highest frequency of the motion, and the limit is that of linear theory. Under records,
    the step in ms replaces the number of steps, and the forces are those per second.
    """
    limits, rows = limits_of(spectral), []
    for problem, quantity, kind in rows_of(decisions):
        answers = decisions.sel(problem=problem, quantity=quantity, kind=kind)
        title, remark = sentence(answers.problem_title.item()), beware(answers)
        for error in answers.allowed_error.values:
            cells = answer(answers.sel(filter="all", allowed_error=error), limits)
            row = {"Problem": title, "Right in": quantity, "Kind": kind, "Error": column(error)}
            rows.append(row | cells | {"Beware of": remark})
    return pd.DataFrame(rows)
