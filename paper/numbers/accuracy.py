"""Numbers of the text: errors against the reference, their cost, linear theory, and round-off."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import of_the_paper
from paper.products import numbers
from paper.published import SCHEMES
from paper.tables.stability import GAIN, PROBLEMS

#: The error of the displacement at which the fastest are compared.
EXACTING = 1e-10
#: Schemes whose loss of amplitude the text compares with that of linear theory, and whose elongation.
_DAMPED, _FAITHFUL = ["hht_alpha", "bathe", "rk4"], ["average_acceleration", "central_difference", "energy_momentum"]
_COMPARED = [*_DAMPED, *_FAITHFUL]


@numbers(agreement="reference_agreement", asks={"agreement.tolerances": [1e-9], "references.problems": ["hardening"]})
def of_agreement(agreement: xr.Dataset) -> dict:
    """True errors of general solvers at a tolerance."""
    error = agreement.u_error.sel(periods=100, problem="hardening")
    # by a mapping: xarray has an argument of that name
    at_nine = error.sel({"tolerance": 1e-9}, method="nearest")
    at_periods = agreement.u_error_at_periods.sel(periods=100, problem="hardening")
    delivered = {}
    for route in ("cvode_adams", "cvode_bdf", "dopri8", "tsit5", "heyoka"):
        delivered[f"delivered_{route}"] = f"{at_nine.sel(route=route).item():.0e}"
        delivered[f"best_{route}"] = f"{error.sel(route=route).min().item():.0e}"
        delivered[f"best_at_periods_{route}"] = f"{at_periods.sel(route=route).min().item():.0e}"
    return delivered


@numbers(
    accuracy="accuracy",
    asks={
        "accuracy.problems": ["hardening"],
        "accuracy.schemes": ["average_acceleration"],
        "accuracy.periods": [100],
        "accuracy.steps_per_period": [64],
    },
)
def of_accuracy(accuracy: xr.Dataset) -> dict:
    """Errors over a hundred periods."""
    accuracy = accuracy.sel(periods=100)
    run = accuracy.sel(problem="hardening", scheme="average_acceleration").sel(steps_per_period=64)
    flagged = (accuracy.flagged == 1).sum(["problem", "scheme", "steps_per_period"])
    return {
        "misled_energy": f"{run.max_energy_error.item():.2f}",
        "misled_delay": f"{run.phase_error.item():.2f}",
        "misled_trajectory": f"{100 * run.max_trajectory_error.item():.0f}",
        "flagged_trajectories": flagged.sel(measure="max_trajectory_error").item(),
        "flagged_decays": flagged.sel(measure="amplitude_decay").item(),
        "accuracy_runs": accuracy.status.size,
    }


def _heyoka_wins_below(work: xr.Dataset) -> float:
    """The error below which heyoka takes less time than the Runge-Kutta method, on every problem that it was given.

    Zero where it never does.
    """
    wins = []
    given = work.solver_time_per_run.sel(solver="heyoka", periods=100).dropna("problem", how="all").problem
    for problem in given.values:
        one = work.sel(problem=problem, periods=100)
        rk4 = one.sel(scheme="rk4")
        peer = one.sel(solver="heyoka")
        # error of Runge-Kutta at the times of heyoka, interpolated in logarithms
        times, errors = np.log(rk4.time_per_run.values), np.log(rk4.max_trajectory_error.values)
        there = np.exp(np.interp(np.log(peer.solver_time_per_run.values), times, errors))
        wins.append(
            float(peer.solver_max_trajectory_error.values[peer.solver_max_trajectory_error < there].max(initial=0.0))
        )
    return min(wins, default=0.0)


def _cheapest_below(data: xr.Dataset, dimension: str, error: xr.DataArray, time: xr.DataArray) -> tuple[str, float]:
    """The fastest along a dimension that reaches ``EXACTING``, and its milliseconds."""
    error, time = error.sel({dimension: data[dimension]}), time.sel({dimension: data[dimension]})
    enough = time.where(error <= EXACTING).min(set(time.dims) - {dimension})
    return enough.idxmin(dimension).item(), 1e3 * enough.min().item()


@numbers(
    work="work_precision",
    recommendation="recommendation",
    asks={
        "work_precision.schemes.schemes": SCHEMES,
        "work_precision.schemes.problems": ["hardening"],
        "work_precision.solvers.problems": ["hardening"],
        "work_precision.solvers.periods": [100],
        "recommendation.measures": ["max_trajectory_error"],
    },
)
def of_work(work: xr.Dataset, recommendation: xr.Dataset) -> dict:
    """Cost of an error, and the cheapest schemes."""
    spring = work.sel(problem="hardening", periods=100)
    rk4 = spring.sel(scheme="rk4").isel(steps_per_period=-1)
    heyoka = spring.sel(solver="heyoka").isel(tolerance=-1)
    cells = recommendation.cheapest_scheme.sel(measure="max_trajectory_error")
    ranking = pd.Series(cells.values.ravel()).replace("", np.nan).dropna().value_counts()
    of_1996 = of_the_paper(recommendation).time.sel(measure="max_trajectory_error")
    kept = of_1996.notnull().any("scheme")
    fastest = of_1996.fillna(np.inf).idxmin("scheme").where(kept, "")
    count = {scheme: int((fastest == scheme).sum()) for scheme in ("rk4", "central_difference")}
    titles = dict(zip(work.scheme.values, work.scheme_title.values, strict=True))
    implicit = work.scheme.values[work.explicit.values == 0]
    explicit_high = work.scheme.values[(work.explicit.values == 1) & (work.order.values >= 4)]
    best, best_ms = _cheapest_below(spring, "scheme", spring.max_trajectory_error, spring.time_per_run)
    _, peer_ms = _cheapest_below(
        spring.sel(solver=["heyoka"]), "solver", spring.solver_max_trajectory_error, spring.solver_time_per_run
    )
    coarse = spring.newton_iterations_per_step.sel(scheme="average_acceleration").isel(steps_per_period=0)
    return {
        "work_cells": cells.size,
        "work_rk4": count["rk4"],
        "work_central_difference": count["central_difference"],
        "work_others": cells.size - sum(count.values()),
        "work_ranking": ", ".join(f"{titles[name]} ({number})" for name, number in ranking.items()),
        "work_implicit": int(ranking.reindex(implicit).sum()),
        "work_explicit_high": int(ranking.reindex(explicit_high).sum()),
        "work_best": titles.get(best, "none"),
        "work_best_ms": f"{best_ms:.2f}",
        "work_peer_ms": f"{peer_ms:.2f}",
        "work_rk4_finest": f"{rk4.max_trajectory_error.item():.0e}",
        "work_rk4_ms": f"{1e3 * rk4.time_per_run.item():.1f}",
        "work_heyoka_finest": f"{heyoka.solver_max_trajectory_error.item():.0e}",
        "work_heyoka_ms": f"{1e3 * heyoka.solver_time_per_run.item():.1f}",
        "work_loosest": f"{np.log10(spring.tolerance.max().item()):.0f}",
        "work_tightest": f"{np.log10(spring.tolerance.min().item()):.0f}",
        "work_heyoka_from": f"{_heyoka_wins_below(work):.0e}",
        "work_iterations_coarse": f"{coarse.item():.1f}",
        "work_diffrax_step": f"{spring.diffrax_rk4_time_per_step.dropna('steps_per_period')[-1].item():.0f}",
        "work_rk4_step": f"{spring.median_time_per_step.sel(scheme='rk4').isel(steps_per_period=-1).item():.0f}",
    }


@numbers(
    spectral="spectral",
    accuracy="accuracy",
    asks={
        "spectral.schemes": _COMPARED,
        "spectral.damping_ratios": [0.0],
        "accuracy.schemes": _COMPARED,
        "accuracy.problems": ["hardening", "softening"],
        "accuracy.steps_per_period": [64],
        "accuracy.periods": [3],
    },
)
def of_promises(spectral: xr.Dataset, accuracy: xr.Dataset) -> dict:
    """Ratios of measured to linear loss of amplitude and elongation, with damped and undamped schemes."""
    linear = spectral.sel(damping_ratio=0.0).interp(dt_over_period=1 / 64)
    measured = accuracy.sel(steps_per_period=64, periods=3, problem=["hardening", "softening"])
    loss = measured.amplitude_decay / linear.amplitude_decay
    elongation = (measured.period_elongation / linear.period_elongation).sel(scheme=_FAITHFUL)
    return {
        "elongation_least": f"{elongation.min().item():.1f}",
        "elongation_most": f"{elongation.max().item():.1f}",
    } | {
        f"kept_{scheme}_{problem}": f"{loss.sel(scheme=scheme, problem=problem).item():.1f}"
        for scheme in _DAMPED
        for problem in ("hardening", "softening")
    }


@numbers(
    spectral="spectral",
    large_steps="large_steps",
    asks={
        "spectral.schemes": ["wilson_theta", "generalized_alpha"],
        "spectral.damping_ratios": [0.0],
        "large_steps.problems": PROBLEMS,
    },
)
def of_linear_theory(spectral: xr.Dataset, large_steps: xr.Dataset) -> dict:
    """Properties of the schemes by linear theory, and where the springs depart from it."""
    free = spectral.sel(damping_ratio=0.0)
    damped = spectral.sel(damping_ratio=spectral.damping_ratio.max())
    unlimited = free.scheme.values[np.isinf(free.stability_limit.values)]
    tried = large_steps.sel(scheme=[name for name in unlimited if name in large_steps.scheme], problem=PROBLEMS)
    steps = ["problem", "dt_over_period"]
    gained, failed = (tried.max_energy_error > GAIN).any(steps), (tried.status != 0).any(steps)
    wilson = free.displacement_overshoot.sel(scheme="wilson_theta").sel(dt_over_period=10, method="nearest")
    untouched = tried.scheme_title.values[~(gained | failed).values]
    return {
        "schemes": spectral.scheme.size,
        "damping_ratio": f"{damped.damping_ratio.item():g}",
        "carried": f"{free.linear_order.sel(scheme='generalized_alpha').item():.1f}",
        "rederived": f"{free.order_rederived.sel(scheme='generalized_alpha').item():.1f}",
        "rederived_damped": f"{damped.order_rederived.sel(scheme='generalized_alpha').item():.1f}",
        "unlimited": tried.scheme.size,
        "unlimited_gained": int(gained.sum()),
        "unlimited_only_failed": int((failed & ~gained).sum()),
        "unlimited_untouched": ", ".join(untouched) if untouched.size else "none of them",
        "overshoot_wilson": f"{1 + wilson.item():.0f}",
    }


@numbers(round_off="round_off", asks={"round_off.schemes": ["rk4"]})
def of_round_off(round_off: xr.Dataset) -> dict:
    """Floors of the error."""
    finest = round_off.error.sel(scheme="rk4").isel(steps_per_period=slice(-5, None)).max("steps_per_period")
    return {f"floor_{name}": f"{finest.sel(summation=name).item():.0e}" for name in round_off.summation.values}
