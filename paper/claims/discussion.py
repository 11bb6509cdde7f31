"""Claims of section 4: accidents at large steps."""

import numpy as np

from paper.asks import OF_THE_DRIFT, rising
from paper.claims.comparisons import DISSIPATIVE, claim_period
from paper.claims.ledger import Finding, by_name, claim, errors, listed

UNCONDITIONAL = ["average_acceleration", "newmark_dissipative", "wilson_theta", "houbolt", "hht_alpha"]
EXPLICIT = ["central_difference", "rk4"]
DAMPED = [*DISSIPATIVE, "hht_alpha"]


@claim(
    "4",
    "On the softening spring at T/20 Runge-Kutta is the most accurate of the seven.",
    "errors at T/20, softening",
    reads=["energy_error", "energy_drift"],
    asks=OF_THE_DRIFT,
)
def runge_kutta_is_best(data):
    at = errors(data, "softening").sel(steps_per_period=20)
    resonance = data["energy_drift"].steps_per_oscillation.sel(steps_per_period=20, method="nearest").item()
    return Finding(
        f"{listed(by_name(at))} %",
        at.idxmin("scheme").item() == "rk4",
        f"an accident: the orbit is held at {resonance:.2f} steps per oscillation, a resonance",
    )


@claim("4", "Runge-Kutta's error at T/20.", "error at T/20, softening", "1.0 %", reads=["energy_error"])
def runge_kutta_at_a_twentieth(data):
    value = errors(data, "softening").sel(steps_per_period=20, scheme="rk4").item()
    return Finding(f"{value:.3f} %", abs(value - 1.0) <= 0.06)


@claim(
    "4", "With the smaller step T/25 the error is larger.", "error at T/25, softening", "8.3 %", reads=["energy_error"]
)
def runge_kutta_at_a_twenty_fifth(data):
    at = errors(data, "softening").sel(scheme="rk4")
    value = at.sel(steps_per_period=25).item()
    return Finding(f"{value:.3f} %", abs(value - 8.3) <= 0.06 and value > at.sel(steps_per_period=20).item())


@claim(
    "4",
    "A smaller step often makes a result less accurate.",
    "shares of neighbouring step sizes at which it does: Runge-Kutta from T/10 to T/40, softening",
    reads=["energy_drift"],
    asks=OF_THE_DRIFT,
)
def smaller_may_be_worse(data):
    drift = np.abs(data["energy_drift"].energy_drift.values)
    share = 100 * np.mean(np.diff(drift) > 0)
    return Finding(f"{share:.0f} %", share > 10)


@claim(
    "4",
    "With average acceleration a smaller step may turn a stable solution into an unstable one (after Xie and Steven).",
    "softening spring from u₀ = 10: a larger step with error below 10 %, a smaller one with error above 100 %",
    reads=["large_steps"],
    asks={
        "large_steps.problems": ["softening_large"],
        "large_steps.dt_over_period": rising("large_steps.dt_over_period"),
    },
)
def smaller_may_be_unstable(data):
    error = (
        data["large_steps"]
        .max_energy_error.sel(problem="softening_large", scheme="average_acceleration")
        .dropna("dt_over_period")
    )
    unstable = error.dt_over_period.values[error.values > 100]
    stable = error.dt_over_period.values[error.values < 10]
    pairs = [(small, large) for small in unstable for large in stable if small < large]
    if not pairs:
        return Finding("no such pair of step sizes", False, "no smaller step was less stable on the grid")
    small, large = min(pairs)
    at = by_name(error)
    return Finding(f"{at[large]:.1f} % at Δt/T = {large:g}, {at[small]:.0f} % at {small:g}", True)


@claim(
    "4",
    "Five of the schemes are unconditionally stable for linear systems.",
    "largest spectral radius less one",
    "0",
    reads=["spectral"],
    asks={"spectral.damping_ratios": [0.0]},
)
def five_are_unconditionally_stable(data):
    excess = data["spectral"].spectral_radius.sel(scheme=UNCONDITIONAL, damping_ratio=0).max().item() - 1
    return Finding(f"{excess:.0e}", excess < 1e-10)


@claim(
    "4",
    "The two others are not.",
    "smallest Δt/T at which the spectral radius exceeds one (theory: 1/π and √2/π)",
    reads=["spectral"],
    asks={"spectral.damping_ratios": [0.0]},
)
def two_are_not(data):
    radius = data["spectral"].spectral_radius.sel(scheme=EXPLICIT, damping_ratio=0)
    stable = by_name((radius.dt_over_period.where(radius <= 1 + 1e-6)).max("dt_over_period"))
    unstable = by_name((radius.dt_over_period.where(radius > 1 + 1e-6)).min("dt_over_period"))
    ours = "; ".join(f"{name}: between {stable[name]:.3f} and {unstable[name]:.3f}" for name in EXPLICIT)
    return Finding(ours, all(np.isfinite(list(unstable.values()))))


@claim(
    "4",
    "On non-linear systems unconditional stability is lost.",
    "which of these five gain more energy than they started with on the softening spring, from either u₀",
    reads=["large_steps"],
    asks={"large_steps.problems": ["softening", "softening_large"]},
)
def stability_is_lost(data):
    large = data["large_steps"].sel(problem=["softening", "softening_large"], scheme=UNCONDITIONAL)
    # no run that only loses energy has an error above 100 %
    gaining = (large.max_energy_error > 101).any(["problem", "dt_over_period"])
    failing = (large.status != 0).any(["problem", "dt_over_period"]) & ~gaining
    grow, fail = (large.scheme.values[which.values].tolist() for which in (gaining, failing))
    qualification = (
        f"{', '.join(fail)} gain none; there it is Newton's iteration that fails at large steps" if fail else ""
    )
    return Finding(", ".join(grow), len(grow) > 0, qualification)


claim_period("4", "softening_large", 1)


@claim(
    "4",
    "The α-method is unstable on the softening spring from u₀ = 10 at T/8.",
    "largest energy over the initial one",
    reads=["phase_portrait/softening_large"],
)
def alpha_is_unstable(data):
    growth = by_name(1 + data["phase_portrait/softening_large"].energy_error.max("t") / 100)
    others = [name for name, value in growth.items() if value > 2 and name != "hht_alpha"]
    return Finding(
        listed(growth), growth["hht_alpha"] > 2, f"so are {' and '.join(others)} at the same step" if others else ""
    )


@claim(
    "4",
    "The α-method has moderate numerical damping.",
    "1 − spectral radius at T/20",
    reads=["spectral"],
    asks={"spectral.damping_ratios": [0.0]},
)
def alpha_is_moderate(data):
    radius = data["spectral"].spectral_radius.sel(scheme=UNCONDITIONAL, damping_ratio=0)
    damping = by_name(1 - radius.sel(dt_over_period=0.05, method="nearest"))
    order = sorted(damping, key=damping.__getitem__)
    return Finding(listed(damping, ".1e"), order.index("hht_alpha") == 1)


claim_period("4", "double_well", 1)


@claim(
    "4",
    "A step of 2.5 in the double well is about a third of its period.",
    "Δt/T",
    "1/3",
    reads=["phase_portrait/double_well", "reference/double_well"],
)
def step_is_a_third(data):
    ratio = (data["phase_portrait/double_well"].dt / data["reference/double_well"].period).item()
    return Finding(f"{ratio:.3f}", round(ratio, 1) == 0.3)


@claim(
    "4",
    "At this step average acceleration becomes chaotic.",
    "distance of two runs that start 1e-10 apart: steps until it exceeds 0.1",
    reads=["sensitivity"],
    asks={"sensitivity.problem": "double_well"},
)
def average_acceleration_is_chaotic(data):
    separation = data["sensitivity"].separation.sel(scheme="average_acceleration").values
    apart = np.flatnonzero(separation > 0.1)
    return Finding(f"{apart[0]} steps" if len(apart) else "never", len(apart) > 0)


@claim(
    "4",
    "It jumps irregularly between u = 1 and u = −1.",
    "changes of the well in 1,000 steps",
    reads=["phase_portrait/double_well"],
)
def jumps_between_wells(data):
    u = data["phase_portrait/double_well"].u.sel(scheme="average_acceleration").values
    jumps = np.flatnonzero(np.diff(np.sign(u)) != 0)
    return Finding(f"{len(jumps)}, {len(set(np.diff(jumps)))} different stays", len(set(np.diff(jumps))) > 5)


@claim(
    "4",
    "The double well rests at u = 1 and u = −1.",
    "largest distance from ±1 of the damped schemes at the end",
    reads=["phase_portrait/double_well"],
)
def rest_is_at_one(data):
    end = data["phase_portrait/double_well"].u.sel(scheme=DAMPED).isel(t=-1)
    worst = abs(abs(end) - 1).max().item()
    return Finding(f"{worst:.0e}", worst < 1e-9)


@claim(
    "4",
    "For the two explicit schemes no converged solution is found at this step.",
    "step at which the run failed, and how",
    reads=["phase_portrait/double_well"],
)
def explicit_schemes_fail(data):
    portrait = data["phase_portrait/double_well"].sel(scheme=EXPLICIT)
    meanings = portrait.status.attrs["flag_meanings"].split()
    ours = ", ".join(
        f"{name} {meanings[int(run.status)].replace('_', ' ')} at step {run.failed_at_step.item()}"
        for name, run in ((name, portrait.sel(scheme=name)) for name in EXPLICIT)
    )
    return Finding(
        ours,
        bool((portrait.status != 0).all()),
        "no iteration is involved, as both are explicit: the displacement itself grows beyond all bounds",
    )


@claim(
    "4",
    "The four damped schemes bear no resemblance to the exact solution.",
    "range of u over the last tenth of the time (exact: 0.82)",
    reads=["phase_portrait/double_well"],
)
def no_resemblance(data):
    u = data["phase_portrait/double_well"].u.sel(scheme=DAMPED)
    late = u.isel(t=slice(-(u.sizes["t"] // 10), None))
    width = by_name(late.max("t") - late.min("t"))
    return Finding(listed(width, ".0e"), max(width.values()) < 0.01)
