"""Claims about estimators of the error of a step and about controlled steps, decided by our runs."""

import numpy as np

from paper.claims.ledger import PRACTICE, Finding, by_name, claim, when
from paper.measures.step_control import CELL, DRIFTS, FOOLED, KEPT, PULSE, STIFF, growth, ratio_at_equal_steps
from paper.published import PROBLEMS
from paper.requirements import REPRODUCED_TABLES
from paper.terms import ALMOST, REASONABLE
from paper.wording import listed, number
from study.sizes import fewest

AVERAGE, GENERALIZED = "average_acceleration", "generalized_alpha"

#: Bounds on the ratio of estimate to true error. For a true estimate the ratio deviates from one by less than ``TRUE``.
#: For a blind estimate the ratio is below ``BLIND``.
TRUE, BLIND = 0.1, 0.1


def _smooth(estimates):
    """The estimates on problems without a stiff mode and without a kink of the load."""
    return estimates.sel(problem=[problem for problem in estimates.problem.values if problem not in (PULSE, *STIFF)])


def _ratio(estimates, estimator, error="true_error"):
    """Largest estimate divided by largest true error, in a period after its first tenth, at the smallest step."""
    finest = estimates.sel(estimator=estimator).isel(steps_per_period=-1)
    return finest.estimate / finest[error]


def _estimates_of(estimator, problems=PROBLEMS):
    return {"estimates.problems": problems, "estimates.schemes": [AVERAGE], "estimates.estimators": [estimator]}


@claim(
    "adaptive",
    "The estimate of Zienkiewicz and Xie equals the error of the step.",
    "estimate over the true error of the displacement, and of displacement and velocity, average acceleration",
    whose="Zienkiewicz and Xie (1991)",
    requires=_estimates_of("zienkiewicz_xie"),
)
def zienkiewicz_xie_is_true(estimates):
    estimates = _smooth(estimates)
    motion = _ratio(estimates, "zienkiewicz_xie", "true_displacement_error").sel(scheme=AVERAGE)
    state = _ratio(estimates, "zienkiewicz_xie").sel(scheme=AVERAGE)
    holds = bool((abs(motion - 1) < TRUE).all())
    misses = bool((state < 1 - TRUE).any())
    ours = f"displacement {listed(by_name(motion), estimates, '.2f')}; state {listed(by_name(state), estimates, '.2f')}"
    return Finding(ours, holds, when(misses, "it ignores the error of the velocity"))


@claim(
    "adaptive",
    "The estimate of Zienkiewicz and Xie detects the error at every time.",
    "smallest ratio of the estimate to the true error along a period, average acceleration",
    whose=PRACTICE,
    requires=_estimates_of("zienkiewicz_xie"),
)
def zienkiewicz_xie_is_never_blind(estimates):
    estimates = _smooth(estimates)
    least = estimates.ratio.sel(estimator="zienkiewicz_xie", scheme=AVERAGE).min("phase")
    sees = bool((least > BLIND).all())
    return Finding(listed(by_name(least), estimates, ".2f"), sees, when(not sees, "it is near zero at turning points"))


@claim(
    "adaptive",
    "An acceleration interpolated through three times gives the error of displacement and velocity.",
    "estimate over the true error, average acceleration",
    whose="Zeng et al. (1992)",
    requires=_estimates_of("three_point"),
)
def three_points_are_true(estimates):
    estimates = _smooth(estimates)
    ratio = _ratio(estimates, "three_point").sel(scheme=AVERAGE)
    return Finding(listed(by_name(ratio), estimates, ".2f"), bool((abs(ratio - 1) < TRUE).all()))


@claim(
    "adaptive",
    "Step doubling gives the error of the step.",
    "estimate over the true error, average acceleration",
    whose=PRACTICE,
    requires=_estimates_of("step_doubling"),
)
def step_doubling_is_true(estimates):
    estimates = _smooth(estimates)
    ratio = _ratio(estimates, "step_doubling").sel(scheme=AVERAGE)
    return Finding(listed(by_name(ratio), estimates, ".2f"), bool((abs(ratio - 1) < TRUE).all()))


@claim(
    "adaptive",
    "The residual in the middle of the step measures the error of the step.",
    "power of the step with which the ratio of residual to true error falls, average acceleration",
    whose="Hibbitt and Karlsson (1979)",
    requires=_estimates_of("half_step_residual"),
)
def residual_measures_the_error(estimates):
    estimates = _smooth(estimates)
    residual = estimates.sel(estimator="half_step_residual", scheme=AVERAGE)
    ratio = (residual.estimate / residual.true_error).isel(steps_per_period=[-2, -1])
    first, last = estimates.steps_per_period.values[-2:]
    power = -np.log(ratio.isel(steps_per_period=1) / ratio.isel(steps_per_period=0)) / np.log(last / first)
    holds = bool((abs(power) < TRUE).all())
    reason = when(not holds, "the residual is of second order in the step, and the error is of third order")
    return Finding(listed(by_name(power), estimates, ".1f"), holds, reason)


@claim(
    "adaptive",
    "The estimate of Zienkiewicz and Xie also equals the error of the step on a structure with a stiff mode.",
    "estimate over the true error of displacement and velocity, average acceleration on stiff and soft springs",
    whose=PRACTICE,
    requires=_estimates_of("zienkiewicz_xie", problems=STIFF),
)
def zienkiewicz_xie_is_true_of_a_stiff_mode(estimates):
    ratio = _ratio(estimates, "zienkiewicz_xie").sel(problem=STIFF[0], scheme=AVERAGE).item()
    true = abs(ratio - 1) < TRUE
    reason = when(not true, "the acceleration of the scheme oscillates with that mode")
    return Finding(number(ratio, ".2g"), true, reason)


@claim(
    "adaptive",
    "An acceleration interpolated through three times also gives the error after a kink of the load.",
    "estimate over the true error, average acceleration under a pulse, from the largest to the smallest step",
    whose=PRACTICE,
    requires=_estimates_of("three_point", problems=[PULSE]),
)
def three_points_are_true_after_a_kink(estimates):
    parabola = estimates.sel(estimator="three_point", scheme=AVERAGE, problem=PULSE)
    ratio = parabola.estimate / parabola.true_error
    true = bool((ratio < FOOLED).all())
    ours = "; ".join(number(value, ".1f") for value in ratio.values)
    return Finding(ours, true, when(not true, "its parabola spans the kink"))


def _control_by(*controllers, scheme=AVERAGE):
    return {
        "step_control.problems": PROBLEMS,
        "step_control.schemes": [scheme],
        "step_control.controllers": list(controllers),
    }


@claim(
    "adaptive",
    "Controlled steps of average acceleration keep the energy as well as equal steps.",
    "ratio of the energy error of the last period to that of the first: steps controlled by PI; equal steps",
    whose=PRACTICE,
    requires=_control_by("pi"),
)
def control_keeps_the_energy(step_control):
    grown = growth(step_control)
    controlled, equal = (by_name(grown.sel(with_equal=controller)) for controller in ("pi", "equal"))
    keeps = max(controlled.values()) < KEPT
    reason = when(not keeps, "the energy drifts from period to period")
    return Finding(f"{listed(controlled, step_control)}; {listed(equal, step_control)}", keeps, reason)


@claim(
    "adaptive",
    "A dead band, which keeps the step constant for long, avoids the drift.",
    "ratio of the energy error of the last period to that of the first",
    whose=PRACTICE,
    requires=_control_by("dead_band"),
)
def a_dead_band_avoids_the_drift(step_control):
    grown = by_name(growth(step_control).sel(with_equal="dead_band"))
    avoids = max(grown.values()) < DRIFTS
    return Finding(listed(grown, step_control), avoids, when(not avoids, "the steps still follow the motion"))


@claim(
    "adaptive",
    "Reversible control of a symmetric scheme shows no drift.",
    "ratio of the energy error of the last period to that of the first",
    whose="Hairer and Söderlind (2005)",
    requires=_control_by("pi"),
)
def reversible_control_has_no_drift(step_control):
    grown = by_name(growth(step_control).sel(with_equal="reversible"))
    return Finding(listed(grown, step_control, ".2f"), max(grown.values()) < KEPT)


@claim(
    "adaptive",
    "With numerical damping, controlled steps never gain energy.",
    "signed energy error of generalized-α at the end in percent, the largest over tolerances, controlled by PI",
    whose=PRACTICE,
    requires=_control_by("pi", scheme=GENERALIZED),
)
def damping_prevents_gain(step_control):
    drift = 100 * step_control.energy_drift.sel(scheme=GENERALIZED, controller="pi").max("tolerance")
    holds = bool((drift < REASONABLE).all())
    reason = when(not holds, "changes of the step add more energy than the damping removes")
    return Finding(listed(by_name(drift), step_control, ".3g"), holds, reason)


@claim(
    "adaptive",
    "Controlled steps keep the energy better than nearly as many equal steps.",
    "smallest ratio, over the cells of Tables 1 and 2, of the energy error with steps controlled by the estimator of "
    "1991 to that with equal steps, average acceleration",
    whose=PRACTICE,
    requires={
        "controlled_1996.problems": PROBLEMS,
        "controlled_1996.schemes": [AVERAGE],
        "controlled_1996.steps_per_period": [CELL],
        **REPRODUCED_TABLES,
    },
)
def control_improves_the_tables(controlled_1996, energy_error):
    ratio = ratio_at_equal_steps(controlled_1996, energy_error).sel(scheme=AVERAGE).min("steps_per_period")
    better = bool((ratio < 1 / ALMOST).all())
    return Finding(listed(by_name(ratio), energy_error), better, when(not better, "the energy drifts"))


@claim(
    "adaptive",
    "The error at the end is proportional to the tolerance.",
    "power of the tolerance with which the largest energy error falls between the two smallest tolerances, "
    "average acceleration, PI",
    whose=PRACTICE,
    requires=_control_by("pi"),
)
def proportional_to_the_tolerance(step_control):
    size = step_control.max_energy_error.sel(scheme=AVERAGE, controller="pi").sortby("tolerance").isel(tolerance=[0, 1])
    logs, tolerances = np.log(size), np.log(size.tolerance)
    power = logs.diff("tolerance").isel(tolerance=0, drop=True) / tolerances.diff("tolerance").item()
    holds = bool((abs(power - 1) < TRUE).all())
    return Finding(
        listed(by_name(power), step_control, ".2f"), holds, when(not holds, "the errors of the steps add up")
    )


@claim(
    "adaptive",
    "A fourth-order scheme that controls its steps keeps the energy within ten percent with fewer steps than average "
    "acceleration.",
    "fewest steps per period from which on all tolerances keep the energy within ten percent: Runge-Kutta; average "
    "acceleration",
    whose=PRACTICE,
    requires={
        "step_control.problems": PROBLEMS,
        "step_control.schemes": [AVERAGE, "rk4"],
        "step_control.controllers": ["pi"],
    },
)
def fourth_order_needs_fewer_steps(step_control):
    controlled = step_control.sel(controller="pi")
    steps = fewest(100 * controlled.max_energy_error, controlled.steps, REASONABLE, "tolerance")
    per_period = steps / step_control.attrs["periods"]
    fourth, second = (per_period.sel(scheme=scheme) for scheme in ("rk4", AVERAGE))
    ours = f"{listed(by_name(fourth), step_control, '.0f')}; {listed(by_name(second), step_control, '.0f')}"
    return Finding(ours, bool((fourth < second).all()))
