"""Claims on the costs of the schemes, in sections 3.1, 3.2 and 5.

Every claim depends on ratios of times per step. For each problem, a repeat of the measurement runs all schemes one
after the other. A ratio has one value per repeat, and the ledger states the median of the values. A ratio counts as
above a bound only if its lower and its upper quartile are above it, and as below a bound only if both are below it.
Otherwise the repeats do not decide about the ratio. A claim is undecided if its verdict depends on such ratios.
"""

import xarray as xr

from paper.claims.ledger import Finding, claim, most
from paper.published import PROBLEMS
from paper.terms import IMPLICIT_NEWMARK, MUCH_LESS, SLIGHTLY_MORE
from paper.wording import joined, listed, title

_ON_THE_PROCESSOR = "this depends on the processor"
Ratios = dict[str, tuple[float, float, float]]


def _quartiles(ratio: xr.DataArray) -> tuple[float, float, float]:
    low, middle, high = ratio.quantile([0.25, 0.5, 0.75], "repeat").values.tolist()
    return low, middle, high


def _to(cpu_time: xr.Dataset, scheme: str, others: list[str], problem: str) -> tuple[float, float, float]:
    """Quartiles, over the repeats, of a scheme's time per step divided by the largest time per step of ``others``."""
    time = cpu_time.seconds_per_step.sel(problem=problem)
    return _quartiles(time.sel(scheme=scheme) / time.sel(scheme=others).max("scheme"))


def _finding(ratios: Ratios, least: float = 0.0, most_of_all: float = float("inf")) -> Finding:
    """The medians of the ratios, whether most ratios lie between two bounds, and a qualification on the exceptions.

    The claim is undecided if it does not hold, but would hold if all ratios left open by the repeats were within the
    bounds.
    """
    cells = {name: least < low and high < most_of_all for name, (low, _, high) in ratios.items()}
    open_ones = [name for name, (low, _, high) in ratios.items() if any(low <= b <= high for b in (least, most_of_all))]
    holds, exceptions = most(cells)
    against = [name for name in exceptions if name not in open_ones]
    parts = [f"not so for {joined(against, {})}"] * bool(against)
    parts += [f"the repeats do not decide for {joined(open_ones, {})}"] * bool(open_ones)
    would_hold, _ = most({name: holds or name in open_ones for name, holds in cells.items()})
    reason = "; ".join([*parts, _ON_THE_PROCESSOR]) if parts else ""
    medians = listed({name: middle for name, (_, middle, _) in ratios.items()}, {}, ".2f")
    return Finding(medians, holds, reason, decided=holds or not would_hold)


@claim(
    "3.1",
    "Central difference costs much less than average acceleration.",
    f"ratio of the times per step, hardening; required: below {MUCH_LESS:g}",
    "0.67",
    words="much lower than that for the implicit average acceleration method",
)
def central_difference_is_cheap(cpu_time):
    ratios = {title("hardening", cpu_time): _to(cpu_time, "central_difference", ["average_acceleration"], "hardening")}
    return _finding(ratios, most_of_all=MUCH_LESS)


@claim(
    "3.2",
    "The softening spring takes more than twice the time of the hardening one.",
    "ratio of the times per step, by scheme; required: most above 2",
    "2.2 to 3.2",
    words="the present example of softening spring requires more than twice the computational time",
)
def softening_costs_twice(cpu_time):
    time = cpu_time.seconds_per_step
    ratio = time.sel(problem="softening") / time.sel(problem="hardening")
    ratios = {title(name, cpu_time): _quartiles(ratio.sel(scheme=name)) for name in time.scheme.values.tolist()}
    return _finding(ratios, least=2.0)


@claim(
    "5",
    "Central difference is the cheapest scheme.",
    "ratio of its time per step to the time of the cheapest other scheme",
    "0.67, 0.60",
    words="the most efficient method is the central difference method",
)
def central_difference_is_cheapest(cpu_time):
    time = cpu_time.seconds_per_step
    ratio = time.sel(scheme="central_difference") / time.drop_sel(scheme="central_difference").min("scheme")
    ratios = {title(name, cpu_time): _quartiles(ratio.sel(problem=name)) for name in PROBLEMS}
    return _finding(ratios, most_of_all=1.0)


@claim(
    "5",
    "Runge-Kutta costs slightly more than the implicit Newmark methods.",
    f"ratio of its time per step to that of the more expensive one; required: between 1 and {SLIGHTLY_MORE:g}",
    "1.32, 1.21",
    words="The Runge–Kutta method costs slightly more than the implicit Newmark methods",
)
def runge_kutta_costs_more(cpu_time):
    ratios = {title(name, cpu_time): _to(cpu_time, "rk4", IMPLICIT_NEWMARK, name) for name in PROBLEMS}
    return _finding(ratios, 1.0, SLIGHTLY_MORE)


@claim(
    "5",
    "Houbolt, Wilson and the α-method cost more than the implicit Newmark methods.",
    "ratios of their times per step to that of the more expensive one; required: most above 1",
    "1.01 to 1.35",
    words="are also more expensive than the implicit Newmark methods",
)
def others_cost_more(cpu_time):
    ratios = {
        f"{title(scheme, cpu_time)} on the {title(problem, cpu_time)}": _to(cpu_time, scheme, IMPLICIT_NEWMARK, problem)
        for problem in PROBLEMS
        for scheme in ("houbolt", "wilson_theta", "hht_alpha_1996")
    }
    return _finding(ratios, least=1.0)
