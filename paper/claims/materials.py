"""Claims of practice on yielding and memory, on records of ground motion, and on the α-method with damping."""

import numpy as np

from paper.claims.ledger import PRACTICE, Finding, by_name, claim, when
from paper.measures.kinks import GAINED, LOST, REMEMBER, at_equal_forces
from paper.measures.shares import with_interval
from paper.measures.spectrum import LONG, beyond_at_the_spacing, beyond_between
from paper.requirements import fourfold
from paper.terms import MATTERS, RULE, SECOND_ORDER, UNNOTICED
from paper.wording import listed, number


@claim(
    "materials",
    "Once materials are non-linear, the order of a scheme does not matter.",
    "smallest ratio, over all steps tried, of the error of average acceleration to that of Runge-Kutta at equal steps; "
    "the same of central difference at equal numbers of forces; order of Runge-Kutta",
    whose=PRACTICE,
    requires={
        "kinks.problems": REMEMBER,
        "kinks.schemes": ["average_acceleration", "central_difference", "rk4"],
        "kinks.steps_per_period": fourfold,
    },
)
def order_does_not_matter(kinks):
    kinks = kinks.sel(problem=REMEMBER)
    at_equal_steps = kinks.sampled_error.sel(scheme="average_acceleration") / kinks.sampled_error.sel(scheme="rk4")
    gain = by_name(at_equal_steps.min("steps_per_period"))
    equal = by_name(at_equal_forces(kinks).min("steps_per_period"))
    order = kinks.observed_order.sel(scheme="rk4")
    low, high = float(order.min()), float(order.max())
    lost, gains = high < LOST, max(gain.values()) > GAINED
    parts = ["the order is kept"] * (not lost) + ["at equal steps the error is smaller"] * gains
    ours = f"{listed(gain, kinks, '.2g')}; {listed(equal, kinks, '.2g')}; order {low:.0f} to {high:.0f}"
    return Finding(ours, lost and min(equal.values()) < GAINED, "; ".join(parts))


@claim(
    "materials",
    "The balance of energies shows whether the motion of a yielding structure is right.",
    "error of the displacement and of the balance of average acceleration at the coarsest steps, in percent",
    whose=PRACTICE,
    requires={"kinks.problems": ["yielding"], "kinks.schemes": ["average_acceleration"]},
)
def balance_is_a_verdict(kinks):
    run = kinks.sel(problem="yielding", scheme="average_acceleration").isel(steps_per_period=0)
    error, imbalance = 100 * float(run.sampled_error), 100 * float(run.max_energy_imbalance)
    blind = error > MATTERS and imbalance < UNNOTICED
    reason = when(blind, "its formulas keep the balance for any forces")
    return Finding(f"{number(error, '.2g')}; {number(imbalance, '.0e')}", not blind, reason)


@claim(
    "materials",
    "Twenty steps in a period are enough for the peak drift.",
    "steps in a period that average acceleration needs, among all steps tried, for the peak drift within the allowed "
    "error, by period",
    whose=PRACTICE,
    requires={"spectrum.schemes": ["average_acceleration"]},
)
def twenty_steps_for_the_peak(spectrum):
    needed = spectrum.largest_step_size.sel(scheme="average_acceleration")
    steps = (needed.period / needed.sel(condition="any_step")).max(["record", "reduction"], skipna=False)
    values = {f"{period:g} s": value for period, value in zip(steps.period.values, steps.values, strict=True)}
    enough = all(value <= RULE for value in values.values())  # false for NaN, which means that no step is enough
    reason = "" if enough else "a step must resolve the record too"
    return Finding(listed(values, spectrum, ".0f", "none of those tried"), enough, reason)


@claim(
    "materials",
    "Under a record, a finer step gives a smaller error.",
    "runs of average acceleration at long periods whose peak drift is beyond the allowed error: with the "
    "spacing as step; with finer steps that do not divide it, down to half of it",
    whose=PRACTICE,
    requires={"spectrum.schemes": ["average_acceleration"], "spectrum.periods": [LONG]},
)
def finer_is_better_under_a_record(spectrum):
    at_the_spacing, finer = (
        beyond(spectrum, "average_acceleration") for beyond in (beyond_at_the_spacing, beyond_between)
    )
    better = bool(finer.mean() <= at_the_spacing.mean())
    reason = when(not better, "steps that do not divide the spacing miss samples")
    return Finding(f"{with_interval(at_the_spacing)}; {with_interval(finer)}", better, reason)


@claim(
    "materials",
    "The α-method of 1996 is of second order with damping too.",
    "its order by linear theory, by damping ratio",
    whose=PRACTICE,
    requires={"spectral.schemes": ["hht_alpha_1996"]},
)
def order_of_the_alpha_method(spectral):
    order = spectral.linear_order.sel(scheme="hht_alpha_1996")
    damped = order.where(order.damping_ratio > 0, drop=True)
    values = {f"{ratio:g}": value for ratio, value in zip(order.damping_ratio.values, order.values, strict=True)}
    second = bool(np.all(damped > SECOND_ORDER))
    reason = when(not second, "it weights the internal force but not the damping")
    return Finding(listed(values, spectral), second, reason)
