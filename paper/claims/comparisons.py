"""Claims of section 3: the two springs."""

import numpy as np

from paper.asks import steps_of_portrait
from paper.claims.introduction import PERIODS
from paper.claims.ledger import Data, Finding, by_name, claim, errors, listed

DISSIPATIVE = ["newmark_dissipative", "wilson_theta", "houbolt"]
FAITHFUL = ["average_acceleration", "central_difference"]


def claim_period(section: str, problem: str, decimals: int) -> None:
    """Enter the claim that the period of a problem is the printed one."""
    statement = f"The period of the {problem.replace('_', ' ')} problem."

    def period(data: Data) -> Finding:
        exact = data[f"reference/{problem}"].period.item()
        return Finding(f"{exact:.6f}", round(exact, decimals) == PERIODS[problem])

    period.__name__ = f"period_of_{problem}"
    claim(section, statement, "exact period", f"{PERIODS[problem]}", reads=[f"reference/{problem}"])(period)


claim_period("3.1", "hardening", 2)


@claim(
    "3.1",
    "At T/20 the results vary greatly with the scheme.",
    "largest over smallest error at T/20, hardening",
    reads=["energy_error"],
)
def results_vary(data):
    at = errors(data, "hardening").sel(steps_per_period=20)
    return Finding(f"{(at.max() / at.min()).item():.0f} times", (at.max() / at.min()).item() > 10)


@claim(
    "3.1",
    "Some results are far from the exact solution.",
    "schemes with an error above 80 % at T/20, hardening",
    reads=["energy_error"],
)
def some_are_far_off(data):
    at = by_name(errors(data, "hardening").sel(steps_per_period=20))
    far = {name: value for name, value in at.items() if value > 80}
    return Finding(f"{listed(far)} %", len(far) > 0)


def _late_over_early(data: Data, problem: str) -> dict[str, float]:
    """Largest energy error in the last tenth of the time over that in the first tenth."""
    error = abs(data[f"phase_portrait/{problem}"].energy_error)
    tenth = error.sizes["t"] // 10
    return by_name(error.isel(t=slice(-tenth, None)).max("t") / error.isel(t=slice(0, tenth)).max("t"))


@claim(
    "3.1",
    "The energy error grows with time, in some cases with small oscillations.",
    "error in the last tenth of the time over that in the first tenth, hardening at T/20",
    reads=["phase_portrait/hardening"],
    asks={"phase_portrait.hardening": steps_of_portrait("phase_portrait.hardening", 10)},
)
def error_grows_with_time(data):
    growth = _late_over_early(data, "hardening")
    steady = [name for name, ratio in growth.items() if ratio < 1.05]
    return Finding(
        listed(growth, ".2f"),
        len(steady) < len(growth),
        f"with {' and '.join(steady)} it oscillates within a period and does not grow" if steady else "",
    )


@claim(
    "3.1",
    "Central difference is almost as accurate as average acceleration.",
    "largest ratio of their errors over the step sizes, hardening",
    reads=["energy_error"],
)
def central_difference_is_as_accurate(data):
    error = errors(data, "hardening")
    ratio = (error.sel(scheme="central_difference") / error.sel(scheme="average_acceleration")).max().item()
    return Finding(f"{ratio:.3f}", ratio < 1.1)


@claim(
    "3.1",
    "Central difference costs much less than average acceleration.",
    "ratio of times, hardening",
    "0.67",
    reads=["cpu_time"],
)
def central_difference_is_cheap(data):
    ratio = data["cpu_time"].ratio.sel(problem="hardening", scheme="central_difference").item()
    holds = ratio < 0.75
    return Finding(
        f"{ratio:.2f}", holds, "" if holds else f"it costs {ratio:.2f} of it here; that depends on the processor"
    )


@claim(
    "3.1",
    "Newmark with β = 0.3025 and γ = 0.6 is the worst of the seven.",
    "step sizes at which it is, hardening",
    "7 of 7",
    reads=["energy_error"],
)
def newmark_is_worst(data):
    error = errors(data, "hardening")
    worst = (error.idxmax("scheme") == "newmark_dissipative").sum().item()
    return Finding(f"{worst} of {error.sizes['steps_per_period']}", worst == error.sizes["steps_per_period"])


@claim("3.1", "Its error is still high at T/1000.", "error at T/1000, hardening", "39.5 %", reads=["energy_error"])
def newmark_at_fine_steps(data):
    value = errors(data, "hardening").sel(steps_per_period=1000, scheme="newmark_dissipative").item()
    return Finding(f"{value:.3f} %", abs(value - 39.5) <= 0.06)


@claim(
    "3.1",
    "With α the same β and γ are much more accurate.",
    "smallest ratio of the errors without and with α from T/50 on, hardening",
    reads=["energy_error"],
)
def alpha_helps(data):
    error = errors(data, "hardening").sel(steps_per_period=slice(50, None))
    ratio = (error.sel(scheme="newmark_dissipative") / error.sel(scheme="hht_alpha")).min().item()
    return Finding(f"{ratio:.0f} times", ratio > 2)


@claim(
    "3.1",
    "At large steps Runge-Kutta is less accurate than average acceleration and central difference.",
    "steps per period at which it is, hardening",
    "15, 20, 25",
    reads=["energy_error"],
)
def runge_kutta_at_large_steps(data):
    error = errors(data, "hardening")
    worse = error.sel(scheme="rk4") > error.sel(scheme=FAITHFUL).max("scheme")
    at = error.steps_per_period.values[worse.values].tolist()
    return Finding(", ".join(map(str, at)), at == [15, 20, 25])


@claim(
    "3.1",
    "The errors of Runge-Kutta converge faster than those of any other scheme.",
    "observed order of the energy error from T/100 to T/200, hardening",
    reads=["energy_error"],
)
def runge_kutta_converges_fastest(data):
    error = errors(data, "hardening").sel(steps_per_period=[100, 200])
    ratio = error.isel(steps_per_period=0) / error.isel(steps_per_period=1)
    order = by_name(ratio.copy(data=np.log2(ratio.values)))
    others = max(value for name, value in order.items() if name != "rk4")
    return Finding(listed(order, ".2f"), order["rk4"] > others + 1)


def _lost_energy(data: Data, problem: str) -> dict[str, float]:
    """Mean signed energy error over the last tenth of the time, in percent."""
    error = data[f"phase_portrait/{problem}"].energy_error.sel(scheme=DISSIPATIVE)
    return by_name(error.isel(t=slice(-(error.sizes["t"] // 10), None)).mean("t"))


@claim(
    "3.1",
    "The grave errors of Newmark (γ = 0.6), Houbolt and Wilson come from numerical damping.",
    "signed energy error at the end, hardening at T/20: all energy lost, none gained",
    reads=["phase_portrait/hardening"],
)
def grave_errors_are_damping(data):
    lost = _lost_energy(data, "hardening")
    return Finding(f"{listed(lost)} %", max(lost.values()) < -80)


@claim(
    "3.1",
    "Newmark (γ = 0.6) is damped rapidly towards rest.",
    "energy that is left after 100 periods at T/20, hardening",
    reads=["phase_portrait/hardening"],
)
def newmark_goes_to_rest(data):
    left = 100 + _lost_energy(data, "hardening")["newmark_dissipative"]
    return Finding(f"{left:.2f} %", left < 1)


@claim(
    "3.1",
    "The damping of the α-method is less severe than that of Houbolt's and Wilson's.",
    "largest ratio of its error to the smaller of theirs, hardening",
    reads=["energy_error"],
)
def alpha_damps_less(data):
    error = errors(data, "hardening")
    ratio = (error.sel(scheme="hht_alpha") / error.sel(scheme=["houbolt", "wilson_theta"]).min("scheme")).max().item()
    return Finding(f"{ratio:.2f}", ratio < 1)


claim_period("3.2", "softening", 2)


@claim(
    "3.2",
    "On the softening spring the schemes behave as on the hardening one.",
    "rank correlation of the errors of the schemes on both springs at T/50",
    reads=["energy_error"],
)
def springs_agree(data):
    hardening, softening = (
        errors(data, name).sel(steps_per_period=50).to_series().rank() for name in ("hardening", "softening")
    )
    correlation = hardening.corr(softening)
    return Finding(f"{correlation:.2f}", correlation > 0.9)


@claim(
    "3.2",
    "The same three schemes damp strongly.",
    "signed energy error at the end, softening at T/20",
    reads=["phase_portrait/softening"],
)
def softening_is_damped(data):
    lost = _lost_energy(data, "softening")
    return Finding(f"{listed(lost)} %", max(lost.values()) < -80)


@claim(
    "3.2",
    "Average acceleration and central difference are fairly accurate at T/20.",
    "errors at T/20, softening",
    "4.7 %, 7.3 %",
    reads=["energy_error"],
)
def faithful_at_a_twentieth(data):
    at = by_name(errors(data, "softening").sel(steps_per_period=20, scheme=FAITHFUL))
    return Finding(f"{listed(at)} %", max(at.values()) < 10)


@claim(
    "3.2",
    "Newmark (γ = 0.6) is extremely inaccurate even at T/1000.",
    "error at T/1000, softening",
    "32.4 %",
    reads=["energy_error"],
)
def newmark_at_fine_steps_softening(data):
    value = errors(data, "softening").sel(steps_per_period=1000, scheme="newmark_dissipative").item()
    return Finding(f"{value:.3f} %", abs(value - 32.4) <= 0.06)


@claim(
    "3.2",
    "The softening spring takes more than twice the time of the hardening one.",
    "ratio of times by scheme",
    "2.2 to 3.2",
    reads=["cpu_time"],
)
def softening_costs_twice(data):
    time = data["cpu_time"].median_time_per_step
    ratio = by_name(time.sel(problem="softening") / time.sel(problem="hardening"))
    holding = sum(value > 2 for value in ratio.values())
    reason = f"{holding} of {len(ratio)} schemes take more than twice the time here; the ratio depends on the processor"
    return Finding(listed(ratio, ".2f"), min(ratio.values()) > 1.5, "" if holding == len(ratio) else reason)
