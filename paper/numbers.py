"""Every number that the text of the manuscript and the README quote, out of the datasets."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from paper.claims.ledger import by_name
from paper.claims.stability import CHAOTIC
from paper.claims.structures import TURNING, kept, sawtooth
from paper.data import load, of_the_paper
from paper.figures.oscillatory_energies import total
from paper.published import printed_energy_errors
from paper.rounding import once, same, twice
from paper.tables.stability import GAIN, PROBLEMS
from paper.tables.structures import STEPS_PER_PERIOD
from paper.tables.verdicts import FAILURES, SPAN, is_outcome, near_1996

#: The error of the displacement at which the fastest are compared.
EXACTING = 1e-10


def _printed_over_exact(energy_error: xr.Dataset, problem: str) -> float:
    period = energy_error.period.sel(problem=problem)
    return (period.sel(period_used="printed") / period.sel(period_used="exact")).item()


def _of_cells(energy_error: xr.Dataset) -> dict:
    printed = printed_energy_errors()
    cells = energy_error.max_energy_error.sel(scheme=printed.scheme)
    ours, exact = cells.sel(period_used="printed"), cells.sel(period_used="exact")
    off = abs(ours - printed)
    unexplained = ~same(twice(ours), printed)
    (odd,) = np.argwhere(unexplained.values)
    odd_cell = {"problem": odd[0], "steps_per_period": odd[1], "scheme": odd[2]}
    return {
        "cells": ours.size,
        "cells_within_tolerance": int((off <= 0.06).sum()),
        "cells_rounded_once": int(same(once(ours), printed).sum()),
        "cells_rounded_twice": int(same(twice(ours), printed).sum()),
        "cells_exact_period": int(same(twice(exact), printed).sum()),
        "odd_cell_printed": f"{printed.isel(odd_cell).item():.1f}",
        "odd_cell": f"{ours.isel(odd_cell).item():.3f}",
        "odd_cell_exact": f"{exact.isel(odd_cell).item():.3f}",
        "printed_rk4_20": f"{printed.sel(problem='softening', scheme='rk4', steps_per_period=20).item():.1f}",
        "printed_rk4_25": f"{printed.sel(problem='softening', scheme='rk4', steps_per_period=25).item():.1f}",
        "count_at_start_20": f"{20 / _printed_over_exact(energy_error, 'softening'):.3f}",
        "period_rounding_hardening": f"{100 * (1 - _printed_over_exact(energy_error, 'hardening')):.1f}",
        "period_rounding_softening": f"{100 * (1 - _printed_over_exact(energy_error, 'softening')):.2f}",
        "largest_effect_of_period": f"{abs(exact - ours).max().item():.1f}",
    }


def _caught(drift: xr.Dataset) -> np.ndarray:
    """Whole number of steps per oscillation that holds each run, 0 where none does.

    A run is held if an oscillation takes that number at the end to one part in a thousand, and it has lost less than
    half of the energy that the runs at neighbouring step sizes have lost.
    """
    count, lost = drift.steps_per_oscillation.values, -drift.energy_drift.values
    whole = np.round(count)
    trend = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(lost, 20, mode="edge"), 41), axis=1)
    return np.where((np.abs(count / whole - 1) < 1e-3) & (lost < trend / 2), whole, 0).astype(int)


def _of_drift(drift: xr.Dataset) -> dict:
    parts, caught = drift.steps_per_period, _caught(drift)
    near_20 = parts.values[caught == 20]
    numbers = {}
    for part in (20, 20.5, 25):
        at = drift.sel(steps_per_period=part, method="nearest")
        numbers[f"drift_{part}"] = f"{at.energy_drift.item():.2f}"
        numbers[f"count_{part}"] = f"{at.steps_per_oscillation.item():.2f}"
    return numbers | {
        "drift_runs": parts.size,
        "resonances": ", ".join(str(number) for number in sorted(set(caught) - {0})),
        "resonances_odd": int((caught % 2 == 1).sum()),
        "resonance_20_from": f"{near_20.min():.2f}",
        "resonance_20_to": f"{near_20.max():.2f}",
    }


def _of_instability(portrait: xr.Dataset) -> dict:
    growth = 1 + portrait.energy_error.max("t") / 100
    shown = ("average_acceleration", "central_difference", "hht_alpha")
    return {f"growth_{name}": f"{growth.sel(scheme=name).item():.1f}" for name in shown}


def _of_double_well(portrait: xr.Dataset, sensitivity: xr.Dataset) -> dict:
    u = portrait.u.sel(scheme="average_acceleration").values
    apart = sensitivity.separation.sel(scheme="average_acceleration").values > 0.1
    return {
        "jumps": int((np.diff(np.sign(u)) != 0).sum()),
        "steps_to_diverge": int(np.argmax(apart)),
        "fails_central_difference": int(portrait.failed_at_step.sel(scheme="central_difference")),
        "fails_rk4": int(portrait.failed_at_step.sel(scheme="rk4")),
    }


def _of_times(cpu_time: xr.Dataset) -> dict:
    return {
        f"ns_{scheme}": f"{cpu_time.median_time_per_step.sel(problem='hardening', scheme=scheme).item():.0f}"
        for scheme in ("average_acceleration", "central_difference", "rk4")
    }


def _of_agreement(agreement: xr.Dataset) -> dict:
    error = agreement.u_error.sel(periods=100, problem="hardening")
    # by a mapping: xarray has an argument of that name
    at_nine = error.sel({"tolerance": 1e-9}, method="nearest")
    at_periods = agreement.u_error_at_periods.sel(periods=100, problem="hardening")
    numbers = {}
    for route in ("cvode_adams", "cvode_bdf", "dopri8", "tsit5", "heyoka"):
        numbers[f"delivered_{route}"] = f"{at_nine.sel(route=route).item():.0e}"
        numbers[f"best_{route}"] = f"{error.sel(route=route).min().item():.0e}"
        numbers[f"best_at_periods_{route}"] = f"{at_periods.sel(route=route).min().item():.0e}"
    return numbers


def _of_accuracy(accuracy: xr.Dataset) -> dict:
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
    """The error below which heyoka takes less time than the Runge-Kutta method, on every problem."""
    wins = []
    for problem in work.problem.values:
        one = work.sel(problem=problem, periods=100)
        rk4 = one.sel(scheme="rk4")
        peer = one.sel(solver="heyoka")
        # Runge-Kutta's error at the time that heyoka takes, log-linear
        times, errors = np.log(rk4.time_per_run.values), np.log(rk4.max_trajectory_error.values)
        there = np.exp(np.interp(np.log(peer.solver_time_per_run.values), times, errors))
        wins.append(float(peer.solver_max_trajectory_error.values[peer.solver_max_trajectory_error < there].max()))
    return min(wins)


def _cheapest_below(data: xr.Dataset, dimension: str, error: xr.DataArray, time: xr.DataArray) -> tuple[str, float]:
    """Who reaches ``EXACTING`` first, and the milliseconds that it takes."""
    error, time = error.sel({dimension: data[dimension]}), time.sel({dimension: data[dimension]})
    enough = time.where(error <= EXACTING).min(set(time.dims) - {dimension})
    return enough.idxmin(dimension).item(), 1e3 * enough.min().item()


def _of_work(work: xr.Dataset, recommendation: xr.Dataset) -> dict:
    spring = work.sel(problem="hardening", periods=100)
    rk4 = spring.sel(scheme="rk4").isel(steps_per_period=-1)
    heyoka = spring.sel(solver="heyoka").isel(tolerance=-1)
    cells = recommendation.cheapest_scheme.sel(measure="max_trajectory_error")
    ranking = pd.Series(cells.values.ravel()).replace("", np.nan).dropna().value_counts()
    of_1996 = of_the_paper(recommendation).time.sel(measure="max_trajectory_error").dropna("scheme", how="all")
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
        "work_best": titles[best],
        "work_best_ms": f"{best_ms:.2f}",
        "work_peer_ms": f"{peer_ms:.2f}",
        "work_rk4_finest": f"{rk4.max_trajectory_error.item():.0e}",
        "work_rk4_ms": f"{1e3 * rk4.time_per_run.item():.1f}",
        "work_heyoka_finest": f"{heyoka.solver_max_trajectory_error.item():.0e}",
        "work_heyoka_ms": f"{1e3 * heyoka.solver_time_per_run.item():.1f}",
        "work_heyoka_from": f"{_heyoka_wins_below(work):.0e}",
        "work_iterations_coarse": f"{coarse.item():.1f}",
        "work_diffrax_step": f"{spring.diffrax_rk4_time_per_step.dropna('steps_per_period')[-1].item():.0f}",
        "work_rk4_step": f"{spring.median_time_per_step.sel(scheme='rk4').isel(steps_per_period=-1).item():.0f}",
    }


def _of_promises(spectral: xr.Dataset, accuracy: xr.Dataset) -> dict:
    """Measured over linear: loss of amplitude of damped schemes, elongation of some that do not damp."""
    linear = spectral.sel(damping_ratio=0.0).interp(dt_over_period=1 / 64)
    measured = accuracy.sel(steps_per_period=64, periods=3, problem=["hardening", "softening"])
    loss = measured.amplitude_decay / linear.amplitude_decay
    faithful = ["average_acceleration", "central_difference", "energy_momentum"]
    elongation = (measured.period_elongation / linear.period_elongation).sel(scheme=faithful)
    return {
        "elongation_least": f"{elongation.min().item():.1f}",
        "elongation_most": f"{elongation.max().item():.1f}",
    } | {
        f"kept_{scheme}_{problem}": f"{loss.sel(scheme=scheme, problem=problem).item():.1f}"
        for scheme in ("hht_alpha", "bathe", "rk4")
        for problem in ("hardening", "softening")
    }


def _of_linear_theory(spectral: xr.Dataset, large_steps: xr.Dataset) -> dict:
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


def _of_round_off(round_off: xr.Dataset) -> dict:
    finest = round_off.error.sel(scheme="rk4").isel(steps_per_period=slice(-5, None)).max("steps_per_period")
    floors = {f"floor_{name}": f"{finest.sel(summation=name).item():.0e}" for name in round_off.summation.values}
    return floors | {"round_off_known": f"{10 * round_off.uncertainty.item():.0e}"}


def _of_long_times(runs: xr.Dataset) -> dict:
    """What the schemes themselves do over the longest runs, and laws and sizes of round-off."""
    last = runs.isel(periods=-1)
    law = runs.exponent.sel(quantity="energy_round_off")
    more = (runs.exponent.sel(quantity="phase_round_off") - law).sel(arithmetic="float64")
    double, single, compensated = (last.sel(arithmetic=name) for name in ("float64", "float32", "float32_compensated"))
    steady = single.energy_round_off.sel(step="short")
    drift = (single.energy_round_off.sel(step="any") / steady).sel(scheme="central_difference")
    bought = (steady / compensated.energy_round_off.sel(step="short")).max()
    numbers = {
        "lasting_periods": f"{last.periods.item():,}",
        "lasting_steps": runs.steps_per_period,
        "lasting_runs": runs.runs,
        "lasting_spread": f"{100 * runs.spread_of_steps:.1f}",
        "lasting_double_from": f"{law.sel(arithmetic='float64').min().item():.2f}",
        "lasting_double_to": f"{law.sel(arithmetic='float64').max().item():.2f}",
        "lasting_double_energy": f"{double.energy_round_off.max().item():.0e}",
        "lasting_double_phase": f"{double.phase_round_off.max().item():.0e}",
        "lasting_phase_more_from": f"{more.min().item():.2f}",
        "lasting_phase_more_to": f"{more.max().item():.2f}",
        "lasting_drift": f"{drift.item():.0f}",
        "lasting_bought": f"{bought.item():.1f}",
    }
    for name in ("central_difference", "energy_momentum", "yoshida4"):
        of = double.sel(scheme=name, step="any")
        numbers[f"lasting_energy_{name}"] = f"{of.max_energy_error.item():.1g}"
        late = of.phase_error.item()
        numbers[f"lasting_delay_{name}"] = f"{abs(late):.0f} periods {'late' if late > 0 else 'early'}"
        for step in runs.step.values:
            one = {"scheme": name, "step": step, "arithmetic": "float32"}
            error = runs.exponent_error.sel(one | {"quantity": "energy_round_off"})
            numbers[f"lasting_law_{step}_{name}"] = f"{law.sel(one).item():.2f} ± {error.item():.2f}"
    return numbers


def _of_structures(structures: xr.Dataset, history: dict[str, xr.Dataset]) -> dict:
    data = {"structures": structures}
    runs = kept(data, TURNING)
    lost = by_name((~runs).sum(["problem", "steps_per_period"]))
    stiff_soft, long_times = history["stiff_soft"], history["long_times"]
    alternating = sawtooth(stiff_soft.v.isel(component=0))
    oscillatory = total(long_times)
    change = by_name(100 * abs(oscillatory / oscillatory.isel(t=0) - 1).max("t"))
    return {
        "turning_runs": runs.sizes["problem"] * runs.sizes["steps_per_period"],
        **{f"lost_{name}": number for name, number in lost.items()},
        **{f"sawtooth_{name}": f"{a:.2f}" for name, a in zip(stiff_soft.scheme.values, alternating, strict=True)},
        "chain_best": f"{100 * structures.displacement_error.sel(problem='fpu_chain').min().item():.0f}",
        "long_time": f"{long_times.t.max().item():,.0f}",
        "long_sample": f"{long_times.t[1].item():.0f}",
        "long_step": f"{long_times.dt.item():.2f}",
        "structures_steps": STEPS_PER_PERIOD,
        **{
            f"{name}_steps": history[name].steps_per_period.item()
            for name in ("stiff_soft", "stiff_bar", "stiff_truss")
        },
        **{f"sum_{name}": f"{value:.0f}" if value > 10 else f"{value:.1f}" for name, value in change.items()},
    }


def _of_stability(data: dict[str, xr.Dataset]) -> dict:
    atlas, roots, bifurcation, robustness, structures = (
        data[name] for name in ("atlas", "roots", "bifurcation", "robustness", "structures")
    )
    chaotic, failed = bifurcation.lyapunov_exponent * bifurcation.dt > CHAOTIC, bifurcation.status != 0
    at = bifurcation.sel(dt=roots.paper_dt.item(), method="nearest")
    a_step = at.lyapunov_exponent.item() * at.dt.item()
    beyond = (roots.dt >= bifurcation.dt.values[chaotic.values.argmax()]) & (
        roots.dt < roots.unique_up_to.sel(scheme="average_acceleration")
    )
    in_chaos = roots.steps_together.sel(start="last_acceleration").isel(dt=beyond)
    a_step_each = (bifurcation.lyapunov_exponent * bifurcation.dt).where(chaotic & (bifurcation.steps_until_apart > 0))
    foretold = np.log(bifurcation.order_one / bifurcation.perturbation) / a_step_each / bifurcation.steps_until_apart
    longest = robustness.steps_needed.isel(periods=-1)
    of_average = longest.sel(scheme="average_acceleration", level=10)
    twenty = longest.sel(problem="hardening", level=10) <= 20
    exponents = structures.lyapunov_exponent.sel(excitation=1)
    finest = exponents.isel(steps_per_period=-1)
    tamed = exponents.sel(problem="duffing_chaotic", scheme="central_difference")
    pendulum = exponents.sel(problem="pendulum", scheme="average_acceleration")
    near = near_1996(atlas)
    by_scheme = {name: is_outcome(near, name).any(["problem", "amplitude", "dt_over_period"]) for name in FAILURES}
    untouched = ~(by_scheme["chaotic"] | by_scheme["growing"] | by_scheme["not_finite"])
    return {
        "maps": atlas.sizes["scheme"] * atlas.sizes["problem"],
        "map_points": atlas.sizes["amplitude"] * atlas.sizes["dt_over_period"],
        "map_periods": re.search(r"in (\d+) periods", atlas.max_energy_error.long_name)[1],  # type: ignore[index]
        "map_schemes": atlas.sizes["scheme"],
        "map_span": f"{SPAN:g}",
        "map_chaotic_schemes": int(by_scheme["chaotic"].sum()),
        "map_untouched": ", ".join(atlas.scheme_title.values[untouched.values]) or "none",
        "chaos_from": f"{bifurcation.dt.values[chaotic.values.argmax()]:.2f}",
        "newton_fails_from": f"{bifurcation.dt.values[failed.values.argmax()]:.2f}",
        "together": f"{in_chaos.median().item():.0f}",
        "together_from": int(in_chaos.min()),
        "together_to": int(in_chaos.max()),
        "exponent_at_paper": f"{a_step:.2f}",
        "apart_from_exponent": f"{np.log(bifurcation.order_one / bifurcation.perturbation).item() / a_step:.0f}",
        "apart_of_two_runs": at.steps_until_apart.item(),
        **{f"unique_{name}": f"{roots.unique_up_to.sel(scheme=name).item():.2f}" for name in roots.scheme.values},
        "foretold": f"{foretold.median().item():.1f}",
        "foretold_from": f"{foretold.quantile(0.05).item():.1f}",
        "foretold_to": f"{foretold.quantile(0.95).item():.1f}",
        "needed_periods": f"{robustness.periods.values[-1]:,}",
        "needed_most": robustness.most_steps.item(),
        **{
            f"needed_{name}": f"{value:.0f}" if np.isfinite(value) else f"more than {robustness.most_steps.item()}"
            for name, value in by_name(of_average).items()
        },
        "needed_twenty": ", ".join(robustness.scheme_title.values[twenty.values]) or "none",
        "duffing_exponent_from": f"{finest.sel(problem='duffing_chaotic').min().item():.2f}",
        "duffing_exponent_to": f"{finest.sel(problem='duffing_chaotic').max().item():.2f}",
        "duffing_tamed": f"{tamed.min().item():.1f}",
        "duffing_tamed_steps": int(tamed.idxmin()),
        "pendulum_exponent": f"{pendulum.max().item():.1f}",
        "pendulum_steps": int(pendulum.idxmax()),
    }


def _of_claims(claims: pd.DataFrame) -> dict:
    def counted(part, prefix):
        count = part["verdict"].value_counts()
        return {
            prefix: len(part),
            f"{prefix}_reproduced": int(count.get("reproduced", 0)),
            f"{prefix}_qualified": int(count.get("reproduced with a qualification", 0)),
            f"{prefix}_not_reproduced": int(count.get("not reproduced", 0)),
        }

    ours = claims["section"].isin(["structures", "stability"])
    return counted(claims[~ours], "claims") | {
        name: number
        for section, prefix in (("structures", "structure_claims"), ("stability", "stability_claims"))
        for name, number in counted(claims[claims["section"] == section], prefix).items()
    }


def numbers(results: Path) -> dict:
    """All numbers by name, those with decimals formatted."""

    def dataset(name):
        return load(results / f"{name}.nc")

    claims = pd.read_csv(results / "claims.csv", dtype=str, keep_default_na=False)
    return {
        **_of_cells(dataset("energy_error")),
        **_of_drift(dataset("energy_drift")),
        **_of_instability(dataset("phase_portrait/softening_large")),
        **_of_double_well(dataset("phase_portrait/double_well"), dataset("sensitivity")),
        **_of_times(dataset("cpu_time")),
        **_of_agreement(dataset("reference_agreement")),
        **_of_accuracy(dataset("accuracy")),
        **_of_work(dataset("work_precision"), dataset("recommendation")),
        **_of_linear_theory(dataset("spectral"), dataset("large_steps")),
        **_of_promises(dataset("spectral"), dataset("accuracy")),
        **_of_round_off(dataset("round_off")),
        **_of_long_times(dataset("long_times")),
        **_of_structures(
            dataset("structures"),
            {
                name: dataset(f"structure_history/{name}")
                for name in ("stiff_soft", "long_times", "stiff_bar", "stiff_truss")
            },
        ),
        **_of_stability(
            {
                name: dataset(f"stability/{name}")
                for name in ("atlas", "roots", "bifurcation", "robustness", "structures")
            }
        ),
        **_of_claims(claims),
    }


if __name__ == "__main__":
    results, output = map(Path, sys.argv[1:])
    # a minus before a number, and no hyphen of a name
    texts = {name: re.sub(r"(?<![^\W\de])-(?=\d)", "−", str(value)) for name, value in numbers(results).items()}
    output.write_text(json.dumps(texts, indent=1, ensure_ascii=False) + "\n")
