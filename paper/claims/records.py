"""Claims on the step under records of ground motion, decided by our runs."""

from paper.claims.ledger import PRACTICE, Finding, claim, when
from paper.measures.record_error import ONE_CURVE, SCHEME, over_period, scatter, square_of_step
from paper.measures.shares import share_of_runs
from paper.measures.what_moves import QUANTITIES, choice_spread, median_changes, without_drift
from paper.wording import share_with
from study.words import listed, number

#: Largest relative distance from one of measured over predicted error in most runs, and share of these runs.
DISTANCE, MOST_RUNS = 0.1, 0.95
#: Largest ratio of the error to that of the period where the mean of the load restores the error of steps that divide.
RESTORED = 3.0
_WITH_AVERAGE = {"record_error.schemes": [SCHEME]}


@claim(
    "structures",
    "The power of a record above 1/(4Δt) decides the error of a step.",
    "scatter of the error of the displacement about a line against that power, in decades, average acceleration",
    whose=PRACTICE,
    requires=_WITH_AVERAGE,
)
def power_above_decides(record_error):
    average = record_error.sel(scheme=SCHEME)
    value, step = scatter(average, average.power_above), scatter(average, square_of_step(average))
    holds = value <= ONE_CURVE
    return Finding(f"{value:.2f}, and {step:.2f} about (ωΔt)²", holds, when(not holds, "power near 1/Δt decides it"))


@claim(
    "structures",
    "The error of a step under a record follows from the error of the period and the part of the record passed over.",
    "share of runs within a tenth of the prediction, linear oscillators, average acceleration",
    requires=_WITH_AVERAGE,
)
def period_and_load_decide(record_error):
    average = record_error.sel(scheme=SCHEME)
    ratio = average.error.sel(load="samples") / average.predicted_error
    share, low, high = share_of_runs((abs(ratio - 1) <= DISTANCE).where(ratio.notnull()))
    holds = share >= MOST_RUNS
    reason = when(not holds, "few steps end at a sample, where the error is measured")
    return Finding(share_with(share, low, high), holds, reason)


@claim(
    "structures",
    "The mean of the load over each step restores the error of steps that divide the spacing of a record.",
    "97.5th percentile of error over error of the period at other steps, with samples and with means",
    requires=_WITH_AVERAGE,
)
def mean_load_restores(record_error):
    plain, mean = (over_period(record_error, load) for load in ("samples", "averages"))
    holds = mean < RESTORED < plain
    reason = when(not holds, "the two loads do not differ enough at the steps tried")
    return Finding(f"{number(plain, 2)}; {number(mean, 2)}", holds, reason)


@claim(
    "structures",
    "The spacing of the records as step moves medians over records less than damping and the choice of records do.",
    "largest ratio, over the periods, of the change of a median by the step to that by a damping of 3.5 %, and to that "
    "by a choice of 40 records",
)
def step_moves_least(what_moves):
    words, holds, uncertain = [], True, False
    for name, title in QUANTITIES.items():
        medians = median_changes(what_moves[name])
        step, damping = (abs(medians.change.sel(variant=variant)) for variant in ("spacing", "damping"))
        ratios = (step / damping).max().item(), (step / choice_spread(what_moves[name], 40)).max().item()
        words.append(f"{title} {ratios[0]:.2g}; {ratios[1]:.2g}")
        holds &= max(ratios) < 1
        ends = medians[["low", "high"]].to_array("end")
        largest = abs(ends.sel(variant="spacing")).max("end")
        signed = ends.sel(variant="damping")
        least = abs(signed).min("end").where(signed.prod("end") > 0, 0.0)
        uncertain |= bool((largest >= least).any())
    collapsed = [f"{period:g} s" for period in without_drift(what_moves)]
    reasons = ["the intervals over the records overlap"] * bool(uncertain)
    if collapsed:
        reasons.append(f"at the period of {listed(collapsed)} most motions collapse, and the drifts have no median")
    return Finding(", ".join(words), holds, "; ".join(reasons))
