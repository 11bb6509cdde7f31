"""Numbers of the text on how well the tables and figures of the paper are reproduced."""

import numpy as np
import xarray as xr

from paper.data import cells_of_tables
from paper.products import numbers
from paper.published import SCHEMES, once, printed_energy_errors, same, twice
from paper.requirements import REPRODUCED_TABLES, RESONANCE, spans
from paper.terms import DISSIPATIVE, FAITHFUL, UNSTABLE
from study.words import number, span

#: Schemes whose energies grow on the softening spring from its large amplitude.
_GROWING = ["average_acceleration", "central_difference", "hht_alpha_1996"]


def _printed_over_exact(energy_error: xr.Dataset, problem: str) -> float:
    period = energy_error.period.sel(problem=problem)
    return (period.sel(period_used="printed") / period.sel(period_used="exact")).item()


@numbers(requires=REPRODUCED_TABLES)
def table_cell_numbers(energy_error: xr.Dataset) -> dict:
    """Computed and printed errors of Tables 1 and 2, compared cell by cell."""
    printed = printed_energy_errors()
    cells = 100 * cells_of_tables(energy_error).max_energy_error
    ours, exact = cells.sel(period_used="printed"), cells.sel(period_used="exact")
    off = abs(ours - printed)
    unexplained = ~same(twice(ours), printed)
    odd_cell = abs(twice(ours) - printed).argmax(...)
    return {
        "cells": ours.size,
        "cells_within_tolerance": int((off <= 0.06).sum()),
        "cells_rounded_once": int(same(once(ours), printed).sum()),
        "cells_rounded_twice": int(same(twice(ours), printed).sum()),
        "all_digits_but_one": int(unexplained.sum()) == 1,
        "cells_exact_period": int(same(twice(exact), printed).sum()),
        "odd_cell_printed": f"{printed.isel(odd_cell).item():.1f}",
        "odd_cell": f"{ours.isel(odd_cell).item():.2f}",
        "odd_cell_exact": f"{exact.isel(odd_cell).item():.2f}",
        "printed_rk4_20": f"{printed.sel(problem='softening', scheme='rk4', steps_per_period=20).item():.1f}",
        "printed_rk4_25": f"{printed.sel(problem='softening', scheme='rk4', steps_per_period=25).item():.1f}",
        "count_at_start_20": f"{20 / _printed_over_exact(energy_error, 'softening'):.3f}",
        "period_rounding_hardening": f"{100 * (1 - _printed_over_exact(energy_error, 'hardening')):.1f}",
        "period_rounding_softening": f"{100 * (1 - _printed_over_exact(energy_error, 'softening')):.2f}",
        **{
            f"printed_period_{name}": f"{energy_error.period.sel(problem=name, period_used='printed').item():g}"
            for name in ("hardening", "softening")
        },
        "largest_effect_of_period": f"{abs(exact - ours).max().item():.1f}",
    }


def _caught(drift: xr.Dataset) -> np.ndarray:
    """Whole number of steps per oscillation at which a resonance holds each run; zero for other runs.

    A run is held if its final steps per oscillation equal that number to one part in a thousand, and if it has lost
    less than half of the energy that the runs at neighbouring step sizes have lost in the median.
    """
    count, lost = drift.steps_per_oscillation.values, -drift.energy_drift.values
    whole = np.round(count)
    trend = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(lost, 20, mode="edge"), 41), axis=1)
    return np.where((np.abs(count / whole - 1) < 1e-3) & (lost < trend / 2), whole, 0).astype(int)


@numbers(drift="energy_drift", requires=RESONANCE)
def drift_numbers(drift: xr.Dataset) -> dict:
    """Energy drift of the Runge-Kutta method over step size, with its resonances."""
    parts, caught = drift.steps_per_period, _caught(drift)
    # steps per period of the runs that are held at twenty steps per oscillation, NaN for other runs
    near_20 = parts.where(caught == 20)
    around = {}
    for part in (20, 20.5, 25):
        at = drift.sel(steps_per_period=part, method="nearest")
        around[f"drift_{part}"] = f"{100 * at.energy_drift.item():.2f}"
        around[f"count_{part}"] = f"{at.steps_per_oscillation.item():.2f}"
    return around | {
        "drift_runs": parts.size,
        "resonances": ", ".join(str(number) for number in sorted(set(caught) - {0})) or None,
        "resonances_even": bool((caught % 2 == 0).all()),
        "rk4_held_at_20": bool(caught[int(np.argmin(np.abs(parts.values - 20)))] == 20)
        and not caught[int(np.argmin(np.abs(parts.values - 25)))],
        "resonance_20_from": f"{near_20.min().item():.2f}",
        "resonance_20_to": f"{near_20.max().item():.2f}",
    }


@numbers(portrait="phase_portrait/softening", requires={"phase_portrait.softening.schemes": SCHEMES})
def softening_spring_numbers(portrait: xr.Dataset) -> dict:
    """Energy that schemes have lost by the end of their runs on the softening spring."""
    lost = -100 * portrait.energy_error.isel(t=-1)
    damped, faithful = lost.sel(scheme=DISSIPATIVE), abs(lost.sel(scheme=FAITHFUL))
    return {
        "three_damp_away": bool(damped.min() > 50 and faithful.max() < 10),
        "alpha_loses": f"{lost.sel(scheme='hht_alpha_1996').item():.0f}",
    }


@numbers(
    portrait="phase_portrait/softening_large",
    window="step_window",
    requires={
        "phase_portrait.softening_large.schemes": _GROWING,
        "step_window.problem": "softening_large",
        "step_window.schemes": _GROWING,
        "step_window.step_size_over_period": spans(1 / 8),
    },
)
def instability_numbers(portrait: xr.Dataset, window: xr.Dataset) -> dict:
    """Largest energy over the initial one, in the run of 1996 and at steps and starts close to those of this run."""
    close = 1 + window.largest_gain
    alpha = window.largest_gain.sel(scheme="hht_alpha_1996")
    growth = 1 + portrait.energy_error.max("t")
    others = growth.sel(scheme=[name for name in _GROWING if name != "hht_alpha_1996"])
    return {
        "others_grow_too": bool((others > 2).all()),
        # the run of 1996 has a step of an eighth of the printed period
        "printed_period_softening_large": f"{8 * portrait.step_size.item():g}",
        "growth_periods": f"{portrait.t.max().item() / (8 * portrait.step_size.item()):.0f}",
        "near_steps": window.sizes["step_size_over_period"],
        "near_within": number(100 * abs(8 * window.step_size_over_period - 1).max().item(), 2),
        "near_starts": window.sizes["start"],
        "near_starts_within": number(window.perturbation.item() * np.ptp(window.start.values), 2),
        "near_grown": f"{100 * (100 * alpha > UNSTABLE).mean().item():.0f}",
    } | {
        key: value
        for name in _GROWING
        for key, value in {
            f"growth_{name}": f"{growth.sel(scheme=name).item():.1f}",
            f"growth_near_{name}": span(close.sel(scheme=name), ".1f"),
        }.items()
    }


@numbers(
    portrait="phase_portrait/double_well",
    requires={
        "phase_portrait.double_well.schemes": ["average_acceleration", "central_difference", "rk4"],
        "sensitivity.schemes": ["average_acceleration"],
        "sensitivity.problem": "double_well",
    },
)
def double_well_numbers(portrait: xr.Dataset, sensitivity: xr.Dataset) -> dict:
    """Chaos in the double well from neighbouring starts, and the steps at which explicit schemes fail."""
    runs = sensitivity.sel(scheme="average_acceleration")
    parted = runs.parted_at_step.drop_sel(start=0)
    return {
        "jumps": f"{runs.changes_of_sign.median().item():.0f}",
        "jumps_mostly": span(runs.changes_of_sign.quantile([0.05, 0.95]), ".0f"),
        "starts": runs.sizes["start"],
        "further_starts": parted.sizes["start"],
        "starts_within": number(sensitivity.perturbation.item() * np.ptp(sensitivity.start.values), 2),
        "steps_to_diverge": span(parted, ".0f") if parted.min() > 0 else None,
        "fails_central_difference": int(portrait.failed_at_step.sel(scheme="central_difference")),
        "fails_rk4": int(portrait.failed_at_step.sel(scheme="rk4")),
    }
