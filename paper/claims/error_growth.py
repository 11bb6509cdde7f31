"""Claims on the growth of errors with the length of a run."""

import numpy as np
import xarray as xr

from paper.claims.ledger import STUDY, Finding, claim, when
from paper.wording import number
from study.words import span

#: Smallest relative error above round-off, and largest errors of displacement and of the energy of a motion that is not
#: lost.
FLOOR, SATURATED, LOST = 1e-9, 0.5, 0.5
#: Length in periods from which on errors follow a law; the last crossing of a shorter run comes well before its end.
FROM = 10
#: Largest difference of an exponent from one that counts as linear growth.
NEARLY_ONE = 0.05


def exponents(error_growth: xr.Dataset, measure: str) -> xr.DataArray:
    """Exponent k of error ~ periods^k at the finest step, between the last two lengths before the motion is lost.

    The measure ``amplitude_decay`` is per period; its exponent is that of the loss over the whole run. The result is
    over (problem, scheme), and NaN for fewer than two lengths.
    """
    error_growth = error_growth.isel(steps_per_period=-1)
    error = abs(error_growth[measure])
    error = error * error.periods if measure == "amplitude_decay" else error
    known = (error_growth.flagged.sel(measure=measure) == 0) & (error > FLOOR) & (error_growth.max_energy_error < LOST)
    if measure == "displacement_error":
        known &= error < SATURATED
    error = error.where(known & (error.periods >= FROM))
    size, length = (xr.apply_ufunc(np.log, values).diff("periods") for values in (error, error.periods.astype(float)))
    slopes = size / length
    last = xr.where(slopes.notnull(), slopes.periods, 0).argmax("periods")
    return slopes.isel(periods=last).drop_vars("periods")


@claim(
    "stability",
    "The phase error grows with the number of periods if a scheme keeps the energy, and faster if it dissipates.",
    "exponent of growth of the phase error, of schemes that keep the energy and of dissipative ones",
    whose=STUDY,
)
def phase_error_grows(error_growth):
    growth, keeps = exponents(error_growth, "phase_error"), np.isinf(error_growth.order_of_loss)
    conserving, dissipative = (growth.isel(scheme=np.flatnonzero(keeps == value)) for value in (True, False))
    if not conserving.notnull().any() or not dissipative.notnull().any():
        return Finding("no growth was measured", False, "the runs are too short, or one kind of scheme is missing")
    ours = " and ".join(span(part.values[part.notnull().values]) for part in (conserving, dissipative))
    linear = bool((abs(conserving - 1) < NEARLY_ONE).where(conserving.notnull(), True).all())
    mean = float(dissipative.mean())
    holds = linear and mean > 1 + NEARLY_ONE
    exceptions = conserving.stack(case=["problem", "scheme"])
    exceptions = exceptions[(abs(exceptions - 1) >= NEARLY_ONE).values]
    cases = "; ".join(f"{case.scheme_title.item()} on {case.problem_title.item()}" for case in exceptions)
    reason = (
        f"a step that divides the period may resonate with the motion: {cases}" if cases else "the losses are small"
    )
    return Finding(ours, holds, when(not holds, reason))


@claim(
    "stability",
    "A step extrapolated to a longer duration by the order of the scheme keeps the error of the displacement.",
    "number of cases, of springs and schemes, in which it does, and the largest error over the allowed one",
    whose=STUDY,
)
def extrapolated_steps_keep(error_growth):
    ratio = (error_growth.extrapolated_error / error_growth.allowed_error).stack(case=["problem", "scheme"])
    ratio = ratio[error_growth.extrapolated_steps_per_period.stack(case=["problem", "scheme"]).notnull().values].fillna(
        np.inf
    )
    beyond = ratio[ratio.values > 1]
    ours = f"{int((ratio <= 1).sum())} of {ratio.size}; {number(ratio.max().item(), '.2f') if ratio.size else 'none'}"
    cases = "; ".join(f"{case.scheme_title.item()} on {case.problem_title.item()}" for case in beyond)
    holds = bool(ratio.size) and not cases
    reason = f"in the known run parts of the phase error cancel, or the step resonates with the motion: {cases}"
    return Finding(ours, holds, when(not holds, reason))
