"""Numbers of the text: estimators of the error of a step, and controlled steps."""

import numpy as np
import xarray as xr

from paper.measures.step_control import (
    ALLOWED,
    CELL,
    CLEARLY,
    DRIFTS,
    FOOLED,
    KEPT,
    PROBLEM,
    SCHEME,
    STIFF,
    growth,
    ratio_at_equal_steps,
    ratio_of_forces,
    with_control,
)
from paper.products import numbers
from paper.published import PROBLEMS
from paper.requirements import REPRODUCED_TABLES
from study.words import span

#: Relative fall of an error that counts as none.
UNCHANGED = 0.1


@numbers(
    requires={
        "estimates.problems": [PROBLEM],
        "estimates.schemes": [SCHEME],
        "estimates.estimators": ["zienkiewicz_xie", "three_point", "half_step_residual"],
        "step_control.problems": [PROBLEM],
        "step_control.schemes": [SCHEME, "generalized_alpha"],
        "step_control.controllers": ["pi", "dead_band"],
        "controlled_1996.problems": PROBLEMS,
        "controlled_1996.schemes": [SCHEME],
        "controlled_1996.steps_per_period": [CELL],
        **REPRODUCED_TABLES,
    },
)
def step_control_numbers(
    estimates: xr.Dataset, step_control: xr.Dataset, controlled_1996: xr.Dataset, energy_error: xr.Dataset
) -> dict:
    """Ratios of estimates to true errors, drift of the energy, and the tables of 1996 with controlled steps."""
    finest = estimates.sel(problem=PROBLEM, scheme=SCHEME).isel(steps_per_period=-1)
    displacement = finest.estimate / finest.true_displacement_error
    state = finest.estimate / finest.true_error
    grown = growth(step_control).sel(problem=PROBLEM)
    history = 100 * step_control.max_energy_error_of_period.sel(problem=PROBLEM).isel(period_number=-1)
    cell = {"steps_per_period": CELL, "scheme": SCHEME}
    equal = 100 * energy_error.max_energy_error.sel(period_used="exact", **cell)
    controlled = 100 * controlled_1996.max_energy_error.isel(controller=0).sel(cell)
    ratio = ratio_at_equal_steps(controlled_1996, energy_error).sel(scheme=SCHEME)
    gained = 100 * step_control.energy_drift.sel(scheme="generalized_alpha", controller="pi").max("tolerance")
    on_stiff = None
    if STIFF[0] in estimates.problem:
        stiff = estimates.sel(problem=STIFF[0], scheme=SCHEME, estimator="zienkiewicz_xie").isel(steps_per_period=-1)
        on_stiff = (stiff.estimate / stiff.true_error).item()
    controllers = [controller for controller in ("pi", "dead_band") if controller in grown.with_equal]
    return {
        "control_zx_displacement": f"{displacement.sel(estimator='zienkiewicz_xie').item():.2f}",
        "control_zx_state": f"{state.sel(estimator='zienkiewicz_xie').item():.2f}",
        "control_zx_least": f"{finest.ratio.sel(estimator='zienkiewicz_xie').min().item():.2f}",
        "control_zx_stiff": None if on_stiff is None else f"{on_stiff:.2g}",
        "control_zx_is_fooled": on_stiff is not None and bool(on_stiff > FOOLED),
        "control_three_point": f"{state.sel(estimator='three_point').item():.2f}",
        "control_residual": f"{state.sel(estimator='half_step_residual').item():.0f}",
        "control_finest": int(estimates.steps_per_period[-1]),
        "control_periods": step_control.attrs["periods"],
        "control_steps": f"{_steps(step_control):.0f}",
        "control_pi": f"{history.sel(with_equal='pi').item():.2g}",
        "control_dead_band": f"{history.sel(with_equal='dead_band').item():.2g}",
        "control_equal": f"{history.sel(with_equal='equal').item():.2g}",
        "control_reversible": f"{history.sel(with_equal='reversible').item():.2g}",
        "control_drifts": bool(
            (grown.sel(with_equal=controllers) > DRIFTS).all() and grown.sel(with_equal="equal").item() < KEPT
        ),
        "reversible_keeps": bool(grown.sel(with_equal="reversible").item() < KEPT),
        "control_gained": f"{gained.sel(problem=PROBLEM).item():.0f}",
        "control_gained_most": f"{gained.max().item():.0f}",
        "control_gained_on": step_control.problem_title.sel(problem=gained.idxmax("problem").item()).item(),
        "control_gains_energy": bool((gained > 0).all() and gained.idxmax("problem") != PROBLEM),
        "control_cell": CELL,
        "control_cell_equal": span(equal.sel(problem=PROBLEMS), ".2g"),
        "control_cell_controlled": span(controlled.sel(problem=PROBLEMS), ".2g"),
        "control_ratio": span(ratio.where(np.isfinite(ratio), drop=True), ".2g"),
        "control_is_worse": bool((ratio > 1).all()),
    }


@numbers(requires={"control_cost.problems": STIFF, "control_cost.schemes": [SCHEME]})
def control_cost_numbers(control_cost: xr.Dataset, control_of_codes: xr.Dataset) -> dict:
    """Numbers of cases (problem and scheme) in which step control saves force evaluations, and the steps of Abaqus."""
    ratio = ratio_of_forces(control_cost, ALLOWED)
    known = ratio.stack(case=ratio.dims).dropna("case")
    pairs = [(known.sel(case=case).item(), case) for case in known.case.values]
    titles = {
        name: dict(zip(control_cost[name].values, control_cost[f"{name}_title"].values, strict=True))
        for name in ratio.dims
    }
    best, (problem, scheme) = min(pairs)
    stiff = ratio.sel(problem=STIFF[0], scheme=SCHEME).item()
    fewest, _ = with_control(control_cost, ALLOWED)
    loosest = control_cost.force_evaluations.sortby("tolerance").isel(tolerance=-1)
    abaqus = control_of_codes.sel(problem=PROBLEM, code="Abaqus")
    return {
        "cost_allowed": f"{100 * ALLOWED:g}",
        "cost_cases": len(pairs),
        "cost_saving": sum(value < 1 / CLEARLY for value, _ in pairs),
        "cost_dearer": sum(value > CLEARLY for value, _ in pairs),
        "cost_dearer_at_loosest": int(((ratio > CLEARLY) & (fewest == loosest)).sum()),
        "cost_clearly": f"{100 * (CLEARLY - 1):.0f}",
        "cost_best": f"{1 / best:.1f}",
        "cost_best_scheme": str(titles["scheme"][scheme]),
        "cost_best_problem": str(titles["problem"][problem]),
        "cost_stiff": f"{stiff:.2g}",
        **_stiff_mode(control_cost.sel(problem=STIFF[0], scheme=SCHEME)),
        "cost_stiff_at_loosest": bool((fewest == loosest).sel(problem=STIFF[0], scheme=SCHEME)),
        "codes_abaqus_steps": span(abaqus.steps_per_period.values, ".1f"),
        "codes_abaqus_energy": f"{100 * abaqus.max_energy_error.sel({'class': 'tight'}).item():.0f}",
    }


def _stiff_mode(runs: xr.Dataset) -> dict[str, str | None]:
    """Growth of the evaluations over the loosest tolerances at which the error hardly falls; None without a growth."""
    runs = runs.sortby("tolerance", ascending=False)
    error, forces = runs.sampled_error.values, runs.force_evaluations.values
    last = int(np.argmin(np.append(error >= (1 - UNCHANGED) * error[0], False))) - 1
    return {
        "cost_stiff_from": f"{runs.tolerance[0].item():g}",
        "cost_stiff_to": f"{runs.tolerance[last].item():g}",
        "cost_stiff_error": f"{100 * error[0]:.1g}",
        "cost_stiff_unchanged": f"{100 * UNCHANGED:g}",
        "cost_stiff_grows": f"{forces[last] / forces[0]:.2g}"
        if last > 0 and forces[last] > CLEARLY * forces[0]
        else None,
    }


def _steps(step_control: xr.Dataset) -> float:
    """Mean number of steps in a period with the controller ``pi`` at the middle tolerance."""
    middle = step_control.sizes["tolerance"] // 2
    steps = step_control.steps.sel(problem=PROBLEM, scheme=SCHEME, controller="pi").isel(tolerance=middle)
    return steps.item() / step_control.attrs["periods"]
