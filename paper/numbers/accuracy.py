"""Numbers of the text: errors against the reference, linear theory, and round-off."""

import numpy as np
import xarray as xr

from paper.claims.ledger import by_name
from paper.products import numbers
from paper.terms import FAITHFUL
from paper.wording import joined
from study.words import at_most

#: Problems with positive energy; only on these can a gain of energy be distinguished from a loss.
PROBLEMS = ["hardening", "softening", "softening_large"]
#: Excess over the initial energy, divided by this energy, above which the energy in the second half of a run has grown.
GAIN = 1.0
#: General solvers whose errors at one tolerance the text compares.
_SOLVERS = ["cvode_adams", "cvode_bdf", "dopri8", "tsit5", "heyoka"]


@numbers(
    agreement="reference_agreement", requires={"agreement.tolerances": [1e-9], "references.problems": ["hardening"]}
)
def agreement_numbers(agreement: xr.Dataset) -> dict:
    """True errors of general solvers on the hardening spring, at one tolerance and at the best tolerance."""
    error = agreement.displacement_error.sel(periods=100, problem="hardening")
    # a mapping, because `sel` has an argument with the name `tolerance`
    at_nine = error.sel({"tolerance": 1e-9}, method="nearest")
    at_periods = agreement.displacement_error_at_periods.sel(periods=100, problem="hardening", route="cvode_adams")
    at_tolerance = at_nine.sel(route=_SOLVERS)
    return {
        "delivered_least": f"{at_tolerance.min().item():.0e}",
        "delivered_most": f"{at_tolerance.max().item():.0e}",
        "tolerances_exceeded": bool((at_tolerance > at_nine.tolerance).all()),
        "best_tolerance": f"{np.log10(agreement.tolerance.min().item()):.0f}",
        "best_at_periods_cvode_adams": f"{at_periods.min().item():.0e}",
        **{f"best_{route}": f"{error.sel(route=route).min().item():.0e}" for route in _SOLVERS},
    }


@numbers(
    requires={
        "accuracy.problems": ["hardening"],
        "accuracy.schemes": FAITHFUL,
        "accuracy.periods": [100],
        "accuracy.steps_per_period": [32, 64],
    },
)
def accuracy_numbers(accuracy: xr.Dataset) -> dict:
    """Errors of schemes over a hundred periods, and numbers of errors that the reference does not resolve."""
    accuracy = accuracy.sel(periods=100)
    run = accuracy.sel(problem="hardening", scheme="average_acceleration").sel(steps_per_period=64)
    flagged = (accuracy.flagged == 1).sum(["problem", "scheme", "steps_per_period"])
    phase = accuracy.phase_error.sel(problem="hardening", steps_per_period=[32, 64], scheme=FAITHFUL)
    halved = abs(phase.sel(steps_per_period=32) / phase.sel(steps_per_period=64))
    return {
        "phase_of_second_order": bool((abs(np.log2(halved) - 2) < 0.3).all()),
        "energy_hides_phase": bool(run.max_energy_error < 0.01 and run.displacement_error > 0.1),
        "misled_energy": at_most(100 * run.max_energy_error.item(), 2),
        "misled_delay": f"{run.phase_error.item():.2f}",
        "misled_trajectory": f"{100 * run.displacement_error.item():.0f}",
        "flagged_trajectories": flagged.sel(measure="displacement_error").item(),
        "flagged_decays": flagged.sel(measure="amplitude_decay").item(),
        "accuracy_runs": f"{accuracy.status.size:,}",
    }


@numbers(
    requires={
        "spectral.schemes": ["hht_alpha_1996"],
        "spectral.damping_ratios": [0.0],
        "accuracy.schemes": ["hht_alpha_1996"],
        "accuracy.problems": ["hardening", "softening"],
        "accuracy.steps_per_period": [64],
        "accuracy.periods": [3],
    },
)
def promise_numbers(spectral: xr.Dataset, accuracy: xr.Dataset) -> dict:
    """Loss of amplitude of the α-method on the springs over the loss by linear theory."""
    linear = spectral.sel(damping_ratio=0.0, scheme="hht_alpha_1996").interp(step_size_over_period=1 / 64)
    measured = accuracy.sel(steps_per_period=64, periods=3, scheme="hht_alpha_1996", problem=["hardening", "softening"])
    loss = measured.amplitude_decay / linear.amplitude_decay
    return {"damping_is_larger": bool((loss > 1).all())} | {
        f"kept_hht_alpha_1996_{name}": f"{ratio:.2f}" for name, ratio in by_name(loss).items()
    }


def _meaning(runs: xr.Dataset, name: str) -> int:
    """Number that stands for the named status."""
    return runs.status.flag_meanings.split().index(name)


@numbers(
    requires={
        "spectral.schemes": ["wilson_theta", "generalized_alpha"],
        "spectral.damping_ratios": [0.0],
        "large_steps.problems": PROBLEMS,
    },
)
def linear_theory_numbers(spectral: xr.Dataset, large_steps: xr.Dataset) -> dict:
    """Properties of the schemes by linear theory, and the schemes that depart from linear theory on the springs."""
    free = spectral.sel(damping_ratio=0.0)
    damped = spectral.sel(damping_ratio=spectral.damping_ratio.max())
    unlimited = free.scheme.values[np.isinf(free.stability_limit.values)]
    tried = large_steps.sel(scheme=[name for name in unlimited if name in large_steps.scheme], problem=PROBLEMS)
    steps = ["problem", "step_size_over_period"]
    gains = ((tried.late_energy_gain > GAIN) | (tried.status == _meaning(tried, "unbounded"))).sum(steps)
    gained, once = gains > 1, gains == 1  # a single one may be a matter of round-off, where runs are chaotic
    overshoots = (tried.max_energy_error > GAIN + 0.01).any(steps) & (gains == 0)  # a loss of energy is at most one
    unsolved = (tried.status == _meaning(tried, "no_solution_found")).any(steps)
    wilson = free.displacement_overshoot.sel(scheme="wilson_theta").sel(step_size_over_period=10, method="nearest")
    return {
        "schemes": spectral.scheme.size,
        "damping_ratio": f"{damped.damping_ratio.item():g}",
        "carried": f"{free.linear_order.sel(scheme='generalized_alpha').item():.1f}",
        "rederived": f"{free.order_rederived.sel(scheme='generalized_alpha').item():.1f}",
        "rederived_damped": f"{damped.order_rederived.sel(scheme='generalized_alpha').item():.1f}",
        "unlimited": tried.scheme.size,
        "unlimited_steps": tried.step_size_over_period.size,
        "unlimited_springs": joined(tried.problem_title.values, {}),
        "unlimited_gained": int(gained.sum()),
        "unlimited_gained_titles": joined(tried.scheme_title.values[gained.values], {}),
        "unlimited_once": joined(tried.scheme_title.values[once.values], {}),
        "unlimited_gain": bool(gained.any()),
        "unlimited_overshoot": joined(tried.scheme_title.values[overshoots.values], {}),
        "unlimited_untouched": joined(tried.scheme_title.values[((gains == 0) & ~overshoots).values], {}),
        "unlimited_all_solved": not unsolved.any(),
        "overshoot_wilson": f"{1 + wilson.item():.0f}",
    }


@numbers(
    references=["reference/hardening", "reference/softening", "reference/softening_large", "reference/double_well"]
)
def reference_numbers(references: list[xr.Dataset]) -> dict:
    """Largest relative uncertainties of the exact periods and motions of the springs."""
    period = max((reference.period_certified / reference.period).item() for reference in references)
    motion = max((reference.u_certified / abs(reference.u).max()).item() for reference in references)
    return {"period_doubt": at_most(period), "motion_doubt": at_most(motion)}
