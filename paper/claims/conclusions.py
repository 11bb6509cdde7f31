"""Claims of section 5, except those on costs."""

import xarray as xr

from paper.claims.comparisons import at_step
from paper.claims.ledger import Finding, by_name, claim, when
from paper.published import PROBLEMS
from paper.terms import (
    APART,
    DISSIPATIVE,
    EXPLICIT,
    FAITHFUL,
    FAR_OFF,
    GREATLY,
    IMPLICIT_NEWMARK,
    MOST,
    REASONABLE,
)
from paper.wording import joined, listed, number, title
from study.words import span


def _some_below_a_twentieth(step_size_over_period: list[float]) -> str:
    return "" if min(step_size_over_period) < 0.05 else "needs a step below 0.05: the ledger has a claim on such steps"


def _some_above_a_fifth(step_size_over_period: list[float]) -> str:
    return "" if max(step_size_over_period) > 0.2 else "needs a step above 0.2: the ledger has a claim on such steps"


def _cells(energy_error: xr.Dataset) -> xr.DataArray:
    """Computed energy errors in percent of the cells of Tables 1 and 2, over (problem, steps_per_period, scheme)."""
    return 100 * energy_error.max_energy_error.sel(period_used="printed", problem=PROBLEMS)


@claim(
    "5",
    "The accuracy varies greatly with scheme, parameters and step size.",
    "smallest ratio of the largest to the smallest error of Tables 1 and 2 if only one factor varies: the scheme; "
    "β and γ of the implicit Newmark method; the step size",
    words="varies greatly depending on the scheme, the parameters and the time step sizes",
)
def accuracy_varies(energy_error):
    error = _cells(energy_error)
    newmark = error.sel(scheme=IMPLICIT_NEWMARK)
    ratios = [part.max(along) / part.min(along) for part, along in ((error, "scheme"), (newmark, "scheme"))]
    with_step = error.max("steps_per_period") / error.min("steps_per_period")
    little = with_step.scheme.values[(with_step <= GREATLY).any("problem").values].tolist()
    holds = min(ratio.min().item() for ratio in ratios) > GREATLY and bool((with_step > GREATLY).mean() > MOST)
    least = "; ".join(number(ratio.min().item()) for ratio in (*ratios, with_step))
    return Finding(
        least, holds, when(little, f"with the step size it varies little for {joined(little, energy_error)}")
    )


@claim(
    "5",
    "Average acceleration and central difference are reasonable for Δt < T/20.",
    "largest error of the two schemes at these steps, by problem, in percent",
    words="give reasonable results when Δt < T/20",
    requires={
        "large_steps.problems": ["hardening", "softening"],
        "large_steps.step_size_over_period": _some_below_a_twentieth,
    },
)
def reasonable_below_a_twentieth(large_steps):
    large = 100 * large_steps.max_energy_error.sel(scheme=FAITHFUL)
    small = large.where(large.step_size_over_period < 0.05, drop=True)
    worst = by_name(small.max(["scheme", "step_size_over_period"], skipna=False))
    beyond = [name for name, value in worst.items() if not value <= REASONABLE]
    reason = when(
        beyond, f"not at every amplitude: the error exceeds {REASONABLE:g} % on {joined(beyond, large_steps)}"
    )
    return Finding(listed(worst, large_steps), not {"hardening", "softening"} & set(beyond), reason)


@claim(
    "5",
    "Newmark (γ = 0.6), Houbolt and Wilson damp too strongly for long durations.",
    f"step sizes of Tables 1 and 2, on both springs, at which the error over 100 periods exceeds {REASONABLE:g} %",
    words="possess strong numerical damping, which makes them unsuitable for any practical applications involving "
    "integration over a long time duration",
)
def damped_schemes_are_unsuitable(energy_error):
    error = _cells(energy_error).sel(scheme=DISSIPATIVE)
    unsuitable = error > REASONABLE
    along = ["problem", "steps_per_period"]
    count = by_name(unsuitable.sum(along))
    total = error.problem.size * error.steps_per_period.size
    suited = (~unsuitable).all("problem")
    steps = {name: suited.steps_per_period.values[suited.sel(scheme=name).values].tolist() for name in DISSIPATIVE}
    exceptions = [f"{title(name, energy_error)} at {joined(map(at_step, at), {})}" for name, at in steps.items() if at]
    holds = bool(unsuitable.mean() > MOST) and min(count.values()) > 0
    reason = when(exceptions, f"not so for {', and for '.join(exceptions)}")
    return Finding(f"{listed(count, energy_error, '.0f')}, of {total}", holds, reason)


@claim(
    "5",
    "Newmark with β = 0.3025 and γ = 0.6 should never be used.",
    "smallest of its errors in Tables 1 and 2, by spring; largest error of any other scheme at T/1000",
    "39.5 %, 32.4 %",
    words="should never be used for practical purposes",
)
def newmark_should_never_be_used(energy_error, decisions):
    error = _cells(energy_error)
    smallest = by_name(error.sel(scheme="newmark_dissipative").min("steps_per_period"))
    others = error.sel(steps_per_period=error.steps_per_period.max()).drop_sel(scheme="newmark_dissipative").max()
    ours = f"{listed(smallest, energy_error)} %; {number(others.item(), '.2f')} %"
    chosen = decisions.sel(filter="all", quantity="displacement", kind="implicit").scheme == "newmark_dissipative"
    cases = [
        f"{100 * error:g} % on the {title(problem, {'': decisions})}"
        for problem in decisions.problem.values
        for error in decisions.allowed_error.values
        if chosen.sel(problem=problem, allowed_error=error)
    ]
    reason = when(cases, f"of implicit schemes it needs the fewest forces for an error of {', '.join(cases)}")
    return Finding(ours, min(smallest.values()) > REASONABLE, reason)


@claim(
    "5",
    "The α-method damps less than Newmark (γ = 0.6), Houbolt and Wilson.",
    "largest ratio of its error to the smallest error of the three, over all step sizes of both springs",
    words="The numerical damping of the α-method is not as strong as that of the Newmark method",
)
def alpha_damps_less_than_three(energy_error):
    error = _cells(energy_error)
    ratio = (error.sel(scheme="hht_alpha_1996") / error.sel(scheme=DISSIPATIVE).min("scheme")).max().item()
    return Finding(f"{ratio:.2f}", ratio < 1)


@claim(
    "5",
    "Runge-Kutta is far more accurate than the others at small steps, Δt < T/50.",
    "smallest ratio of the next smallest error to its error at T/100 and finer, both springs",
    words="it is far more accurate than other schemes when the time step is small (Δt < T/50)",
)
def runge_kutta_at_small_steps(energy_error):
    error = _cells(energy_error)
    error = error.where(error.steps_per_period > 50, drop=True)
    ratio = (error.drop_sel(scheme="rk4").min("scheme") / error.sel(scheme="rk4")).min().item()
    return Finding(f"{number(ratio, '.0f')} times", ratio > GREATLY)


@claim(
    "5",
    "At Δt > T/5 central difference and Runge-Kutta may find no converged solution.",
    "smallest Δt/T at which a run failed, by scheme and problem",
    words="a converged solution of the non-linear equilibrium equation may not be found by the method of central "
    "difference and the Runge–Kutta method",
    requires={"large_steps.step_size_over_period": _some_above_a_fifth},
)
def explicit_schemes_at_large_steps(large_steps):
    large = large_steps.sel(scheme=EXPLICIT)
    failed = large.step_size_over_period.where(large.status != 0)
    first = failed.min("step_size_over_period").transpose("scheme", "problem")
    by_scheme = {name: listed(by_name(first.sel(scheme=name)), large_steps, ".2f", "none") for name in EXPLICIT}
    beyond = (failed > 0.2).any("step_size_over_period")
    never = large.problem.values[(~beyond).all("scheme").values].tolist()
    early = [name for name in EXPLICIT if bool((first.sel(scheme=name) <= 0.2).any())]
    reasons = [f"runs of {joined(early, large_steps)} already fail below T/5"] * bool(early)
    reasons += [f"neither fails on {joined(never, large_steps)}"] * bool(never)
    ours = ". ".join(f"{title(name, large_steps)}: {steps}" for name, steps in by_scheme.items())
    return Finding(ours, bool(beyond.any("problem").all()), "; ".join(reasons))


@claim(
    "5",
    "At such large steps the results of the other schemes are often meaningless.",
    f"shares of the runs of the five implicit schemes at Δt > T/5 that fail, and with an error above {FAR_OFF:g} %",
    words="numerical results obtained when using such a large time step are often meaningless",
    requires={"large_steps.step_size_over_period": _some_above_a_fifth},
)
def other_schemes_at_large_steps(large_steps):
    large = large_steps.drop_sel(scheme=EXPLICIT)
    large = large.where(large.step_size_over_period > 0.2, drop=True)
    failed = large.status != 0
    off = ~failed & (100 * large.max_energy_error > FAR_OFF)
    shares = {
        "no solution or unbounded": failed.mean().item(),
        "energy error above the bound": off.mean().item(),
    }
    ours = listed({name: 100 * share for name, share in shares.items()}, {}, ".0f")
    return Finding(f"{ours} % of {failed.size} runs", sum(shares.values()) > MOST)


@claim(
    "5",
    "At such large steps the other schemes are sometimes chaotic.",
    "steps until two runs in the double well at Δt = 2.5 that start 10⁻¹⁰ to 2·10⁻⁹ apart are "
    f"{APART:g} apart, from 40 starts above and below",
    words="and sometimes chaotic",
    requires={"sensitivity.problem": "double_well"},
)
def other_schemes_may_be_chaotic(sensitivity):
    parted = sensitivity.parted_at_step.drop_sel(scheme=EXPLICIT, start=0)
    chaotic = (parted > 0).all("start")
    steps = [span(row, ".0f") if row.min() > 0 else "never" for row in parted.transpose("scheme", "start")]
    ours = "; ".join(f"{name}: {n}" for name, n in zip(parted.scheme_title.values, steps, strict=True))
    return Finding(ours, bool(chaotic.any()))
