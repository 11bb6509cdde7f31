"""Claims of sections 3 and 3.1: how errors are measured, and the hardening spring."""

import numpy as np
import xarray as xr

from paper.claims.introduction import PERIODS
from paper.claims.ledger import Finding, by_name, claim, errors, most, when
from paper.published import PROBLEMS, same, twice
from paper.requirements import steps_of_portrait
from paper.terms import (
    ALMOST,
    DISSIPATIVE,
    FAITHFUL,
    FAR_OFF,
    GREATLY,
    MOST,
    RAPIDLY,
    REASONABLE,
    SIGNIFICANTLY,
)
from paper.wording import joined, listed, number

#: Name of each problem of the paper, as the claims write it.
_SPRINGS = {
    "hardening": "the hardening spring",
    "softening": "the softening spring",
    "softening_large": "the softening spring from u₀ = 10",
    "double_well": "equation (2) with S₁ = −0.5 and S₂ = −1",
}
OVER_BOTH_SPRINGS = {"accuracy.problems": PROBLEMS, "accuracy.periods": [100]}


def claim_period(section: str, problem: str, decimals: int, words: str) -> None:
    """Enter the claim that the exact period of a problem rounds to the printed period."""

    def period(reference: xr.Dataset) -> Finding:
        exact = reference.period.item()
        return Finding(f"{exact:.6f}", round(exact, decimals) == PERIODS[problem])

    statement, printed = f"The period of {_SPRINGS[problem]} is {PERIODS[problem]}.", f"{PERIODS[problem]}"
    claim(section, statement, "exact period", printed, words=words, reference=f"reference/{problem}")(period)


def at_step(steps: object) -> str:
    """Text for a step size as a fraction of the period: T/20 for 20 steps per period."""
    return f"T/{steps}"


@claim(
    "3",
    "The deviation of the total energy is a convenient measure of the inaccuracy of a solution.",
    f"runs on both springs with both errors, of energy and displacement, up to {REASONABLE:g} % or both above",
    words="can be conveniently measured by the deviation of the total energy from its initial value",
    requires=OVER_BOTH_SPRINGS,
)
def energy_measures_inaccuracy(accuracy):
    runs = accuracy.sel(problem=PROBLEMS, periods=100)
    by_energy, right = 100 * runs.max_energy_error <= REASONABLE, 100 * runs.displacement_error <= REASONABLE
    agree = by_energy == right
    wrong, passed = (by_energy & ~right).sum().item(), by_energy.sum().item()
    unseen = f"of {passed} runs with an energy error up to that bound, {wrong} have a larger displacement error"
    reason = when(wrong, f"the energy does not measure the phase: {unseen}")
    return Finding(f"{agree.sum().item()} of {agree.size}", bool(agree.mean() > MOST), reason)


claim_period("3.1", "hardening", 2, "The period of this oscillator T is equal to 0·15")


@claim(
    "3.1",
    "At T/20 the results vary greatly with the scheme.",
    "ratio of the largest to the smallest error at T/20, hardening",
    words="the results vary greatly with different schemes",
)
def results_vary(energy_error):
    at = errors(energy_error, "hardening").sel(steps_per_period=20)
    return Finding(f"{(at.max() / at.min()).item():.0f} times", (at.max() / at.min()).item() > GREATLY)


@claim(
    "3.1",
    "Some results are far from the exact solution.",
    f"schemes with an error above {FAR_OFF:g} % at T/20, hardening",
    words="Some of the results have deviated far from the exact solution",
)
def some_are_far_off(energy_error):
    at = by_name(errors(energy_error, "hardening").sel(steps_per_period=20))
    far = {name: value for name, value in at.items() if value > FAR_OFF}
    return Finding(f"{listed(far, energy_error)} %" if far else "none", len(far) > 0)


@claim(
    "3.1",
    "The energy error grows with time, in some cases with small oscillations.",
    "ratio of the error in the last tenth of the time to the error in the first tenth, hardening at T/20",
    words="is increasing with time, with small oscillations in some cases",
    requires={"phase_portrait.hardening": steps_of_portrait(10)},
    portrait="phase_portrait/hardening",
)
def error_grows_with_time(portrait):
    error = abs(portrait.energy_error)
    tenth = error.sizes["t"] // 10
    growth = by_name(error.isel(t=slice(-tenth, None)).max("t") / error.isel(t=slice(0, tenth)).max("t"))
    holds, steady = most({name: ratio > ALMOST for name, ratio in growth.items()})
    reason = when(steady, f"with {joined(steady, portrait)} it oscillates and does not grow")
    return Finding(listed(growth, portrait, ".2f"), holds, reason)


@claim(
    "3.1",
    "Central difference is almost as accurate as average acceleration.",
    "largest ratio of their errors over the step sizes, hardening",
    words="almost as accurate as those of the average acceleration method",
)
def central_difference_is_as_accurate(energy_error):
    error = errors(energy_error, "hardening")
    ratio = (error.sel(scheme="central_difference") / error.sel(scheme="average_acceleration")).max().item()
    return Finding(f"{ratio:.3f}", ratio < ALMOST)


@claim(
    "3.1",
    "Newmark with β = 0.3025 and γ = 0.6 is the worst of the seven.",
    "step sizes at which it has the largest error, hardening",
    "7 of 7",
    words="The worst scheme among the seven is obviously the Newmark method",
)
def newmark_is_worst(energy_error):
    error = errors(energy_error, "hardening")
    worst = (error.idxmax("scheme") == "newmark_dissipative").sum().item()
    return Finding(f"{worst} of {error.sizes['steps_per_period']}", worst == error.sizes["steps_per_period"])


def claim_printed_error(
    section: str, statement: str, problem: str, steps: int, scheme: str, printed: float, words: str
) -> None:
    """Enter the claim that the error of one run, rounded to two decimals and then to one, is the printed value."""

    def error_of_run(energy_error: xr.Dataset) -> Finding:
        value = errors(energy_error, problem).sel(steps_per_period=steps, scheme=scheme)
        return Finding(f"{value.item():.3f} %", bool(same(twice(value), printed)))

    claim(section, statement, f"error at {at_step(steps)}, {problem}", f"{printed} %", words=words)(error_of_run)


claim_printed_error(
    "3.1",
    "The error of Newmark (γ = 0.6) is still high at T/1000.",
    "hardening",
    1000,
    "newmark_dissipative",
    39.5,
    "it gives an error as high as 39·5%",
)


@claim(
    "3.1",
    "The parameter α makes Newmark with the same β and γ significantly more accurate.",
    "ratio of the errors without and with α, smallest and largest over the step sizes, hardening",
    words="the introduction of the extra parameter α has improved the accuracy significantly",
)
def alpha_helps(energy_error):
    error = errors(energy_error, "hardening")
    ratio = by_name(error.sel(scheme="newmark_dissipative") / error.sel(scheme="hht_alpha_1996"))
    holds, exceptions = most({at_step(steps): value > SIGNIFICANTLY for steps, value in ratio.items()})
    reason = f"at {joined(exceptions, energy_error)} by a factor of less than {SIGNIFICANTLY:g}" if exceptions else ""
    return Finding(f"{min(ratio.values()):.1f} to {max(ratio.values()):,.0f} times", holds, reason)


@claim(
    "3.1",
    "At large steps Runge-Kutta is less accurate than average acceleration and central difference.",
    "step sizes at which it is less accurate, hardening",
    "T/15, T/20, T/25",
    words="when the time step is large it is not as accurate as the average acceleration method or the method of "
    "central difference",
)
def runge_kutta_at_large_steps(energy_error):
    error = errors(energy_error, "hardening")
    worse = error.sel(scheme="rk4") > error.sel(scheme=FAITHFUL).max("scheme")
    at = error.steps_per_period.values[worse.values].tolist()
    return Finding(", ".join(map(at_step, at)) or "none", at == [15, 20, 25])


@claim(
    "3.1",
    "As the step is reduced, the errors of Runge-Kutta converge faster than those of any other scheme.",
    "order of the energy error between neighbouring step sizes, hardening",
    words="the convergence rate of the Runge–Kutta method is higher than those of any other schemes",
)
def runge_kutta_converges_fastest(energy_error):
    error = errors(energy_error, "hardening").to_series().unstack("scheme")
    steps = error.index.to_series()
    order = np.log(error.shift() / error).div(np.log(steps / steps.shift()), axis="index").dropna()
    rk4, others = order["rk4"], order.drop(columns="rk4").max(axis="columns")
    return Finding(
        f"Runge-Kutta: {number(rk4.min())} to {number(rk4.max())}; others: at most {number(others.max())}; "
        f"smallest difference: {number((rk4 - others).min())}",
        bool((rk4 > others).all()),
    )


def lost_energy(portrait: xr.Dataset) -> dict[str, float]:
    """Mean signed energy error of each strongly damped scheme over the last tenth of the run, in percent."""
    error = 100 * portrait.energy_error.sel(scheme=DISSIPATIVE)
    return by_name(error.isel(t=slice(-(error.sizes["t"] // 10), None)).mean("t"))


@claim(
    "3.1",
    "The grave errors of Newmark (γ = 0.6), Houbolt and Wilson come from strong numerical damping.",
    f"runs with an energy error above {FAR_OFF:g} % that lose as much energy by the end of 100 periods, hardening",
    words="are caused by the strong numerical damping possessed by these schemes",
    requires=OVER_BOTH_SPRINGS,
)
def grave_errors_are_damping(accuracy):
    runs = accuracy.sel(problem="hardening", scheme=DISSIPATIVE, periods=100)
    grave = 100 * runs.max_energy_error > FAR_OFF
    damped = grave & (100 * runs.energy_drift < -FAR_OFF)
    number_of_grave = grave.sum().item()
    return Finding(f"{damped.sum().item()} of {number_of_grave}", number_of_grave > 0 and bool((damped == grave).all()))


@claim(
    "3.1",
    "Newmark (γ = 0.6) is rapidly damped towards rest.",
    "periods until half of the energy is lost, and energy left after 100 periods, hardening at T/20",
    words="is rapidly damped towards the static equilibrium point",
    portrait="phase_portrait/hardening",
)
def newmark_goes_to_rest(portrait):
    energy = 100 * portrait.energy_error.sel(scheme="newmark_dissipative")
    lost = energy.t.values[energy.values < -FAR_OFF]
    periods = lost[0] / PERIODS["hardening"] if len(lost) else np.nan
    remainder = 100 + lost_energy(portrait)["newmark_dissipative"]
    return Finding(f"{number(periods, missing='never')}; {number(remainder, '.2f')} %", bool(periods < RAPIDLY))


@claim(
    "3.1",
    "The α-method damps less severely than the Houbolt and Wilson methods.",
    "largest ratio over the step sizes of its error to the smaller error of the two, hardening",
    words="it is not as severe as that of the Houbolt method or the Wilson method",
)
def alpha_damps_less(energy_error):
    error = errors(energy_error, "hardening")
    ratio = (
        (error.sel(scheme="hht_alpha_1996") / error.sel(scheme=["houbolt", "wilson_theta"]).min("scheme")).max().item()
    )
    return Finding(f"{ratio:.2f}", ratio < 1)
