"""Numbers of the text: maps of stability, several roots, chaos, and long times."""

import numpy as np
import xarray as xr

from paper.claims.ledger import by_name
from paper.measures.outcomes import FAILURES, SPAN, is_outcome, near_1996
from paper.products import numbers
from paper.published import PROBLEMS
from paper.requirements import contained, rising
from paper.terms import CHAOTIC, DAMPED, DISSIPATIVE, FAITHFUL
from study.words import span


@numbers(runs="long_times", requires={"long_times.schemes": ["central_difference", "energy_momentum", "yoshida4"]})
def of_long_times(runs: xr.Dataset) -> dict:
    """Errors of the schemes over the longest runs, and growth laws and sizes of round-off."""
    last = runs.isel(periods=-1)
    law = runs.exponent.sel(quantity="energy_round_off")
    more = (runs.exponent.sel(quantity="phase_round_off") - law).sel(arithmetic="float64")
    double, single, compensated = (last.sel(arithmetic=name) for name in ("float64", "float32", "float32_compensated"))
    steady = single.energy_round_off.sel(step="short")
    drift = (single.energy_round_off.sel(step="any") / steady).sel(scheme="central_difference")
    bought = (steady / compensated.energy_round_off.sel(step="short")).max()
    lasting = {
        "lasting_periods": f"{last.periods.item():,}",
        "lasting_steps": runs.steps_per_period.item(),
        "lasting_runs": runs.runs.item(),
        "lasting_spread": f"{100 * runs.spread_of_steps.item():.1f}",
        "lasting_double": span(law.sel(arithmetic="float64")),
        "lasting_double_energy": f"{100 * double.energy_round_off.max().item():.0e}",
        "lasting_double_phase": f"{double.phase_round_off.max().item():.0e}",
        "lasting_phase_more": span(more),
        "lasting_drift": f"{drift.item():.0f}",
        "lasting_bought": f"{bought.item():.1f}",
    }
    for name in ("central_difference", "energy_momentum", "yoshida4"):
        of = double.sel(scheme=name, step="any")
        lasting[f"lasting_energy_{name}"] = f"{of.max_energy_error.item():.1g}"
        late = of.phase_error.item()
        whole = f"{abs(late):.0f}"
        periods = f"{whole} {'period' if whole == '1' else 'periods'}"
        lasting[f"lasting_delay_{name}"] = f"{periods} {'late' if late > 0 else 'early'}"
        for step in runs.step.values:
            one = {"scheme": name, "step": step, "arithmetic": "float32"}
            error = runs.exponent_error.sel(one | {"quantity": "energy_round_off"})
            lasting[f"lasting_law_{step}_{name}"] = f"{law.sel(one).item():.2f} ± {error.item():.2f}"
    return lasting


def _lost_left_of_the_limit(atlas: xr.Dataset, spectral: xr.Dataset) -> dict[str, float]:
    """Share of failed runs among the runs of explicit schemes with ωΔt below a finite linear limit, by problem.

    Here ω is the highest frequency along the motion.
    """
    limits = spectral.stability_limit.sel(damping_ratio=0.0, scheme=atlas.scheme)
    explicit = atlas.isel(scheme=np.flatnonzero((atlas.explicit.values == 1) & np.isfinite(limits.values)))
    limit = limits.sel(scheme=explicit.scheme)
    left = explicit.dt_over_period * explicit.period * explicit.highest_frequency < limit
    lost = sum(is_outcome(explicit, name) for name in FAILURES) > 0
    dims = ["scheme", "amplitude", "dt_over_period"]
    return by_name((lost & left).sum(dims) / left.sum(dims))


@numbers(
    atlas="stability/atlas",
    roots="stability/roots",
    bifurcation="stability/bifurcation",
    robustness="stability/robustness",
    structures="stability/structures",
    requires={
        "": contained("atlas.schemes", within="spectral.schemes"),
        "atlas.schemes": DAMPED,
        "energy_error.problems": PROBLEMS,
        "energy_error.schemes": FAITHFUL,
        "energy_error.steps_per_period": [20],
        "spectral.damping_ratios": [0.0],
        "atlas.problems": ["double_well"],
        "stability.roots.problem": "double_well",
        "stability.roots.schemes": ["average_acceleration", "wilson_theta", "houbolt"],
        "stability.bifurcation.problem": "double_well",
        "stability.bifurcation.scheme": "average_acceleration",
        "robustness.problems": ["hardening", "softening", "double_well"],
        "robustness.schemes": ["average_acceleration"],
        "robustness.periods": rising,
        "stability.structures.lengths.problem": ["pendulum", "duffing_chaotic"],
        "stability.structures.schemes": ["average_acceleration", "central_difference"],
        "stability.structures.excitations": [1],
    },
)
def of_stability(
    atlas: xr.Dataset,
    roots: xr.Dataset,
    bifurcation: xr.Dataset,
    robustness: xr.Dataset,
    structures: xr.Dataset,
    spectral: xr.Dataset,
    energy_error: xr.Dataset,
) -> dict:
    """Outcomes on the maps, several roots of a step, onset of chaos, and steps that suffice at all amplitudes."""
    chaotic, failed = bifurcation.lyapunov_exponent * bifurcation.dt > CHAOTIC, bifurcation.status != 0
    bracketed = bifurcation.newton_restarts > 0
    at = bifurcation.sel(dt=roots.paper_dt.item(), method="nearest")
    a_step = at.lyapunov_exponent.item() * at.dt.item()
    beyond = (roots.dt >= bifurcation.dt.values[chaotic.values.argmax()]) & (
        roots.dt < roots.unique_up_to.sel(scheme="average_acceleration")
    )
    # NaN for step sizes that are not between the onset of chaos and the onset of several roots
    in_chaos = roots.steps_together.sel(start="last_acceleration").where(beyond)
    observed = chaotic & ~failed & (bifurcation.steps_until_apart > 0)
    a_step_each = (bifurcation.lyapunov_exponent * bifurcation.dt).where(observed)
    predicted = np.log(bifurcation.order_one / bifurcation.perturbation) / a_step_each / bifurcation.steps_until_apart
    lost_left = _lost_left_of_the_limit(atlas, spectral)
    longest = robustness.steps_needed.isel(periods=-1)
    of_average = longest.sel(scheme="average_acceleration", level=0.1)
    tables = energy_error.max_energy_error.sel(period_used="printed", steps_per_period=20)
    of_both = tables.sel(problem=PROBLEMS, scheme=FAITHFUL)
    at_all_amplitudes = of_average.fillna(np.inf)
    twenty = longest.sel(problem="hardening", level=0.1) <= 20
    exponents = structures.lyapunov_exponent.sel(excitation=1).sortby("steps_per_period")
    finest = exponents.isel(steps_per_period=-1)
    tamed = exponents.sel(problem="duffing_chaotic", scheme="central_difference")
    pendulum = exponents.sel(problem="pendulum", scheme="average_acceleration")
    near = near_1996(atlas)
    by_scheme = {name: is_outcome(near, name).any(["problem", "amplitude", "dt_over_period"]) for name in FAILURES}
    at_rest = by_scheme["damped_to_rest"]
    untouched = ~(by_scheme["chaotic"] | by_scheme["growing"] | by_scheme["unbounded"])
    return {
        "maps": atlas.sizes["scheme"] * atlas.sizes["problem"],
        "map_points": atlas.sizes["amplitude"] * atlas.sizes["dt_over_period"],
        "map_periods": atlas.periods.item(),
        "map_schemes": atlas.sizes["scheme"],
        "map_span": f"{SPAN:g}",
        "map_chaotic_schemes": int(by_scheme["chaotic"].sum()),
        "map_untouched": ", ".join(atlas.scheme_title.values[untouched.values]) or "none",
        "damped_end_at_rest": bool(
            (at_rest & ~by_scheme["chaotic"] & ~by_scheme["growing"]).sel(scheme=DISSIPATIVE).all()
        ),
        "robust_schemes": robustness.sizes["scheme"],
        "twenty_not_everywhere": bool((of_both <= 10).all() and (at_all_amplitudes > 20).any()),
        "chaos_before_roots": bool(
            bifurcation.dt.values[chaotic.values.argmax()] < roots.unique_up_to.sel(scheme="average_acceleration")
        ),
        "chaos_from": f"{bifurcation.dt.values[chaotic.values.argmax()]:.2f}",
        "bracket_from": f"{bifurcation.dt.values[bracketed.values.argmax()]:.2f}",
        "together": f"{in_chaos.median().item():.0f}",
        "together_span": span(in_chaos, ".0f"),
        "exponent_at_paper": f"{a_step:.2f}",
        "apart_from_exponent": f"{np.log(bifurcation.order_one / bifurcation.perturbation).item() / a_step:.0f}",
        **{f"unique_{name}": f"{roots.unique_up_to.sel(scheme=name).item():.2f}" for name in roots.scheme.values},
        "predicted": f"{predicted.median().item():.1f}",
        "predicted_span": span(predicted.quantile([0.05, 0.95]), ".1f"),
        **{f"lost_left_{name}": f"{100 * part:.0f}" for name, part in lost_left.items()},
        "softening_needs_more": bool(
            at_all_amplitudes.sel(problem="softening") > at_all_amplitudes.sel(problem="hardening")
        ),
        "needed_periods": f"{robustness.periods.values[-1]:,}",
        "bracket_in": f"{100 * bracketed.values[bracketed.values.argmax() :].mean():.0f}",
        "bracket_used": bool(bracketed.any()),
        # a start at rest from √2 has the energy of the hill between the wells
        "needed_nearest_hill": f"{100 * abs(atlas.u0.sel(problem='double_well') / 2**0.5 - 1).min().item():.1g}",
        **{
            f"needed_{name}": f"{value:.0f}" if np.isfinite(value) else f"more than {robustness.most_steps.item()}"
            for name, value in by_name(of_average).items()
        },
        "needed_twenty": ", ".join(robustness.scheme_title.values[twenty.values]) or "none",
        "duffing_exponent": span(finest.sel(problem="duffing_chaotic")),
        "duffing_tamed": f"{tamed.min().item():.1f}",
        "duffing_tamed_steps": f"{tamed.idxmin().item():.0f}",
        "pendulum_exponent": f"{pendulum.max().item():.1f}",
        "pendulum_steps": f"{pendulum.idxmax().item():.0f}",
    }
