"""Claims of section 5."""

import numpy as np
import xarray as xr

from paper.claims.comparisons import DISSIPATIVE, FAITHFUL
from paper.claims.discussion import EXPLICIT
from paper.claims.ledger import Data, Finding, by_name, claim, errors, listed

IMPLICIT_NEWMARK = ["average_acceleration", "newmark_dissipative"]


def _some_up_to_a_twentieth(dt_over_period: list[float]) -> str | None:
    """A sentence if all steps are larger than T/20."""
    if min(dt_over_period) <= 0.05:
        return None
    return "large_steps.dt_over_period has none up to 0.05, of which the ledger decides a claim."


def _some_above_a_fifth(dt_over_period: list[float]) -> str | None:
    """A sentence if all steps are smaller than T/5."""
    if max(dt_over_period) > 0.2:
        return None
    return "large_steps.dt_over_period has none above 0.2, of which the ledger decides a claim."


def _both(data: Data, steps_per_period: int):
    """The larger of a scheme's errors on the two springs."""
    both = [errors(data, name).sel(steps_per_period=steps_per_period) for name in ("hardening", "softening")]
    return xr.concat(both, "problem", coords="minimal", compat="override").max("problem")


@claim(
    "5",
    "The accuracy varies greatly with scheme, parameters and step size.",
    "range of the errors in Tables 1 and 2",
    "0.0 % to 100.0 %",
    reads=["energy_error"],
)
def accuracy_varies(data):
    both = data["energy_error"].max_energy_error.sel(period_used="printed")
    return Finding(f"{both.min().item():.1e} % to {both.max().item():.1f} %", (both.max() / both.min()).item() > 1e3)


@claim(
    "5",
    "Average acceleration and central difference are reasonable for Δt < T/20.",
    "largest error at Δt ≤ T/20 by problem, in percent",
    "4.1 to 7.3 on the two springs",
    reads=["large_steps"],
    asks={"large_steps.problems": ["hardening", "softening"], "large_steps.dt_over_period": _some_up_to_a_twentieth},
)
def reasonable_below_a_twentieth(data):
    large = data["large_steps"].max_energy_error.sel(scheme=FAITHFUL)
    small = large.where(large.dt_over_period <= 0.05, drop=True)
    worst = by_name(small.max(["scheme", "dt_over_period"]))
    beyond = [name for name, value in worst.items() if value > 10]
    return Finding(
        listed(worst),
        max(worst["hardening"], worst["softening"]) < 10,
        f"not at every amplitude: above 10 % on {', '.join(beyond)}" if beyond else "",
    )


@claim(
    "5",
    "Newmark (γ = 0.6), Houbolt and Wilson damp too strongly for long durations.",
    "larger error of the two springs at T/100 over 100 periods",
    reads=["energy_error"],
)
def damped_schemes_are_unsuitable(data):
    at = by_name(_both(data, 100).sel(scheme=DISSIPATIVE))
    return Finding(f"{listed(at)} %", min(at.values()) > 5)


@claim(
    "5",
    "Newmark with β = 0.3025 and γ = 0.6 should never be used.",
    "smaller error of the two springs at T/1000",
    reads=["energy_error"],
)
def newmark_should_never_be_used(data):
    at = {
        name: errors(data, name).sel(steps_per_period=1000, scheme="newmark_dissipative").item()
        for name in ("hardening", "softening")
    }
    others = data["energy_error"].max_energy_error.sel(period_used="printed", steps_per_period=1000)
    others = others.drop_sel(scheme="newmark_dissipative").max().item()
    return Finding(f"{listed(at)} %, every other scheme below {others:.2f} %", min(at.values()) > 100 * others)


@claim(
    "5",
    "The α-method damps less than these three.",
    "largest ratio of its error to the smallest of theirs at T/25 and finer, both springs",
    reads=["energy_error"],
)
def alpha_damps_less_than_three(data):
    ratios = []
    for name in ("hardening", "softening"):
        error = errors(data, name).sel(steps_per_period=slice(25, None))
        ratios.append((error.sel(scheme="hht_alpha") / error.sel(scheme=DISSIPATIVE).min("scheme")).max().item())
    return Finding(f"{max(ratios):.2f}", max(ratios) < 1)


@claim(
    "5",
    "Central difference is the cheapest scheme.",
    "its time over that of average acceleration",
    "0.67, 0.60",
    reads=["cpu_time"],
)
def central_difference_is_cheapest(data):
    ratio = data["cpu_time"].ratio
    ours = by_name(ratio.sel(scheme="central_difference"))
    cheapest = dict(zip(ratio.problem.values.tolist(), ratio.idxmin("scheme").values.tolist(), strict=True))
    others = [f"{name} on {problem}" for problem, name in cheapest.items() if name != "central_difference"]
    return Finding(
        listed(ours, ".2f"),
        not others,
        f"here the cheapest is {' and '.join(others)}; that depends on the processor" if others else "",
    )


@claim(
    "5",
    "Runge-Kutta costs slightly more than the implicit Newmark methods.",
    "its time over that of average acceleration",
    "1.35, 1.21",
    reads=["cpu_time"],
)
def runge_kutta_costs_more(data):
    ours = by_name(data["cpu_time"].ratio.sel(scheme="rk4"))
    return Finding(
        listed(ours, ".2f"),
        min(ours.values()) > 1,
        ""
        if min(ours.values()) > 1
        else "here its step costs less than that of an implicit scheme; that depends on the processor",
    )


@claim(
    "5",
    "Houbolt, Wilson and the α-method cost more than the implicit Newmark methods.",
    "their times over that of the dearer Newmark method",
    "1.01 to 1.35",
    reads=["cpu_time"],
)
def others_cost_more(data):
    time = data["cpu_time"].median_time_per_step
    ratio = time.sel(scheme=["houbolt", "wilson_theta", "hht_alpha"]) / time.sel(scheme=IMPLICIT_NEWMARK).max("scheme")
    ours = {
        f"{problem} {scheme}": ratio.sel(problem=problem, scheme=scheme).item()
        for problem in ratio.problem.values
        for scheme in ratio.scheme.values
    }
    not_dearer = [name for name, value in ours.items() if value <= 1.02]
    return Finding(
        listed(ours, ".2f"),
        len(not_dearer) < len(ours) / 2,
        f"not by more than 2 %: {', '.join(not_dearer)}" if not_dearer else "",
    )


@claim(
    "5",
    "Runge-Kutta is far more accurate than the others at small steps, Δt < T/50.",
    "smallest ratio of the next best error to its own at T/100 and finer, both springs",
    reads=["energy_error"],
)
def runge_kutta_at_small_steps(data):
    ratios = []
    for name in ("hardening", "softening"):
        error = errors(data, name).sel(steps_per_period=slice(100, None))
        ratios.append((error.drop_sel(scheme="rk4").min("scheme") / error.sel(scheme="rk4")).min().item())
    return Finding(f"{min(ratios):.0f} times", min(ratios) > 10)


@claim(
    "5",
    "At Δt > T/5 central difference and Runge-Kutta may find no converged solution.",
    "smallest Δt/T at which a run failed, by problem",
    reads=["large_steps"],
)
def explicit_schemes_at_large_steps(data):
    large = data["large_steps"].sel(scheme=EXPLICIT)
    parts = large.dt_over_period.where(large.status != 0).min("dt_over_period")
    failed = {
        f"{problem} {scheme}": parts.sel(problem=problem, scheme=scheme).item()
        for problem in parts.problem.values
        for scheme in parts.scheme.values
    }
    never = sorted({name.split()[0] for name, value in failed.items() if np.isnan(value)})
    met = {name: value for name, value in failed.items() if not np.isnan(value)}
    return Finding(
        listed(met, ".2f"),
        len(met) > 0,
        f"central difference fails before T/5 already where the force is cubic; with the bounded force of "
        f"{' and '.join(never)} neither fails at all, but the error is large"
        if never
        else "",
    )


@claim(
    "5",
    "At such large steps the results of the other schemes are often meaningless.",
    "shares of the runs of the five implicit schemes at Δt > T/5 by what became of them",
    reads=["large_steps"],
    asks={"large_steps.dt_over_period": _some_above_a_fifth},
)
def other_schemes_at_large_steps(data):
    large = data["large_steps"].drop_sel(scheme=EXPLICIT)
    large = large.where(large.dt_over_period > 0.2, drop=True)
    shares = {
        "Newton failed": 100 * (large.status != 0).mean().item(),
        "error above 50 %": 100 * (large.max_energy_error > 50).mean().item(),
    }
    return Finding(f"{listed(shares, '.0f')} %", sum(shares.values()) > 50)


@claim(
    "5",
    "At such large steps they are sometimes chaotic.",
    "distance of two runs that start 1e-10 apart in the double well at Δt = 2.5, the larger of its last two values",
    reads=["sensitivity"],
    asks={"sensitivity.problem": "double_well"},
)
def other_schemes_may_be_chaotic(data):
    separation = data["sensitivity"].separation.drop_sel(scheme=EXPLICIT).isel(t=slice(-2, None)).max("t")
    chaotic = [name for name, value in by_name(separation).items() if value > 1e-3]
    return Finding(listed(by_name(separation), ".0e"), len(chaotic) > 0)
