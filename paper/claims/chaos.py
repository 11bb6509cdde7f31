"""Claims on chaotic motions under a periodic load."""

import numpy as np
import xarray as xr
from scipy import optimize, stats

from paper.claims.ledger import PRACTICE, STUDY, Finding, claim, when
from paper.terms import FAITHFUL, REASONABLE, RULE
from paper.wording import listed, number
from study.sizes import least_number

#: Largest difference from two of an observed order that counts as second order.
NEARLY_TWO = 0.3
#: Number of repeated fits, each with the errors relative to the one before.
FITS = 5


def ueda_of(chaos: xr.Dataset) -> xr.Dataset:
    """The dataset of Ueda's oscillator, with its largest exponents."""
    return chaos.sel(problem="ueda").isel(place=0)


def fewest_steps(chaos: xr.Dataset) -> dict[str, float]:
    """Fewest steps per period, by scheme, from which on the exponent of Ueda's oscillator is close to the printed one.

    The value is NaN if the exponent with the most steps is not close.
    """
    ueda = ueda_of(chaos)
    close = 100 * abs(ueda.lyapunov_exponent / ueda.printed_exponent - 1) <= REASONABLE
    return least_number(close, "steps_per_period").to_series().to_dict()


@claim(
    "structures",
    "Twenty steps per period of the load preserve the chaos of an oscillator.",
    "fewest steps at and above which the Lyapunov exponent of Ueda's oscillator is within "
    f"{REASONABLE:g} % of the printed one",
    whose=PRACTICE,
)
def twenty_steps_keep_chaos(chaos):
    steps, ueda = fewest_steps(chaos), ueda_of(chaos)
    holds = all(value <= RULE for value in steps.values())
    regular = (ueda.regular == 1).any()
    reason = "at long steps the motion is regular" if regular else "some schemes need more"
    return Finding(listed(steps, {"chaos": chaos}, ".0f", "none"), holds, when(not holds, reason))


def _power(steps: np.ndarray, difference: np.ndarray, variance: np.ndarray, shared: float) -> tuple[float, float]:
    """The power p of difference ~ steps^-p, and half of its 95 % interval.

    The differences are from one value of variance ``shared``, so that their errors are correlated. A mean of a chaotic
    motion is no smooth function of the step; where the differences scatter about a power by more than their errors, all
    have the relative scatter that explains it. Errors are relative to the fitted power, because a difference that is
    too small by chance would count too much.
    """
    free = len(steps) - 2
    powers = np.stack([np.log(steps), np.ones(len(steps))], axis=1)
    errors, fitted = np.diag(variance) + shared, difference

    def fit(scatter: float) -> tuple[np.ndarray, float, float]:
        root = np.linalg.cholesky(errors / np.outer(fitted, fitted) + scatter**2 * np.eye(len(steps)))
        matrix, values = (np.linalg.solve(root, columns) for columns in (powers, np.log(abs(difference))))
        coefficients, (squares,), *_ = np.linalg.lstsq(matrix, values)
        return coefficients, squares, float(np.sqrt(np.linalg.inv(matrix.T @ matrix)[0, 0]))

    for _ in range(FITS):
        more = fit(0.0)[1] > free
        scatter = optimize.brentq(lambda scatter: fit(scatter)[1] - free, 0.0, 100.0) if more else 0.0
        coefficients, _, error = fit(scatter)
        fitted = np.sign(difference) * np.exp(powers @ coefficients)
    return float(-coefficients[0]), float(stats.t.ppf(0.975, free) * error)


def orders_of_means(chaos: xr.Dataset, problem: str = "ueda") -> dict[str, tuple[float, float]]:
    """Order with which the mean square of a problem converges, and half of its 95 % interval, by scheme.

    The exact mean square is that of the Runge-Kutta method at the finest step. The order is fitted to the steps from
    which on all runs are chaotic, where the mean differs by more than two standard errors; NaN for fewer than three
    such steps.
    """
    runs = chaos.sel(problem=problem)
    exact = runs.sel(scheme="rk4").isel(steps_per_period=-1)
    shared = exact.mean_square_uncertainty.item() ** 2
    difference, variance = runs.mean_square - exact.mean_square, runs.mean_square_uncertainty**2
    chaotic = runs.steps_per_period >= least_number(runs.regular == 0, "steps_per_period")
    known = chaotic & (difference**2 > 4 * (variance + shared))
    orders = {}
    for name in runs.scheme.values:
        at = known.sel(scheme=name).values
        if at.sum() > 2:
            differences, variances = (part.sel(scheme=name).values[at] for part in (difference, variance))
            orders[name] = _power(runs.steps_per_period.values[at], differences, variances, shared)
        else:
            orders[name] = (np.nan, np.nan)
    return orders


def fewest_steps_of_mean(chaos: xr.Dataset, error: float) -> dict[str, float]:
    """Fewest steps per period, by scheme, from which on the mean square of Ueda's oscillator keeps a relative error.

    The exact mean square is that of the Runge-Kutta method at the finest step. Two standard errors of the difference
    count as error. The value is NaN if the most steps do not keep the error.
    """
    ueda = ueda_of(chaos)
    exact = ueda.sel(scheme="rk4").isel(steps_per_period=-1)
    spread = 2 * np.hypot(ueda.mean_square_uncertainty, exact.mean_square_uncertainty)
    kept = abs(ueda.mean_square - exact.mean_square) + spread <= error * exact.mean_square
    return least_number(kept, "steps_per_period").to_series().to_dict()


def is_second(order: float, half: float) -> bool:
    """Whether an order is two: nearly, or within its interval, which excludes first and third order."""
    return abs(order - 2) < max(NEARLY_TWO, half) and abs(order - 2) + half < 1


@claim(
    "structures",
    "Statistics of Ueda's chaotic oscillator converge with the order of the scheme, although its orbits are lost.",
    "order of the mean square, with its 95 % interval",
    whose=STUDY,
    requires={"chaos.schemes": ["rk4", *FAITHFUL]},
)
def statistics_converge(chaos):
    orders = {name: orders_of_means(chaos)[name] for name in FAITHFUL}
    holds = all(is_second(*estimate) for estimate in orders.values())
    reason = "too few steps keep the chaos, or the errors scatter about a power of the step"
    return Finding(_orders(orders, chaos), holds, when(not holds, reason))


def _orders(orders: dict[str, tuple[float, float]], chaos: xr.Dataset) -> str:
    """Orders with their intervals, by title of the scheme; none where the interval has zero."""
    titles = dict(zip(chaos.scheme.values, chaos.scheme_title.values, strict=True))
    return "; ".join(
        f"{titles[name]}: " + (f"{order:.1f} ± {half:.1f}" if half < order else "none")
        for name, (order, half) in orders.items()
    )


@claim(
    "structures",
    "Statistics of other chaotic motions converge with the order of the scheme too.",
    "order of the mean square, with its 95 % interval, on each of them",
    whose=STUDY,
    requires={"chaos.schemes": ["rk4", *FAITHFUL]},
)
def other_statistics_converge(chaos):
    words, second = [], []
    for name in chaos.problem.values[chaos.problem.values != "ueda"]:
        orders = {scheme: orders_of_means(chaos, name)[scheme] for scheme in FAITHFUL}
        words.append(f"{chaos.problem_title.sel(problem=name).item()}, {_orders(orders, chaos)}")
        second += [is_second(*estimate) for estimate in orders.values()]
    holds = bool(second) and all(second)
    reason = "their means are no smooth function of the step, or too uncertain to show an order"
    return Finding("; ".join(words) or "none", holds, when(not holds, reason))


def contraction_ratio(chaos: xr.Dataset) -> xr.DataArray:
    """Rate at which volumes of states contract, over that of the motion, (problem, scheme, steps_per_period)."""
    return chaos.contraction / chaos.damping


@claim(
    "structures",
    "The Lyapunov exponents of a scheme add up to minus the damping of the motion, as those of the motion do.",
    f"largest ratio of their sum to the sum of the motion at the finest step; {REASONABLE:g} % are reasonable",
    whose=STUDY,
)
def exponents_add_up(chaos):
    ratio = contraction_ratio(chaos).isel(steps_per_period=-1)
    far = ratio.isel(problem=abs(ratio - 1).max("scheme").argmax("problem").item())
    wrong = far.scheme_title.values[(abs(far - 1) > REASONABLE / 100).values]
    ours = "; ".join(f"{entry.scheme_title.item()}: {number(entry.item(), '.2f')}" for entry in far)
    holds = not len(wrong)
    return Finding(ours, holds, when(not holds, f"numerical damping adds to it with {', '.join(wrong)}"))


def lost_again(chaos: xr.Dataset) -> xr.DataArray:
    """Whether all runs are chaotic at some step and all are regular at a finer one, (problem, scheme)."""
    chaotic_at_coarser = (chaos.regular == 0).cumsum("steps_per_period") > 0
    return ((chaos.regular == 1) & chaotic_at_coarser).any("steps_per_period")


@claim(
    "structures",
    "A scheme that keeps a chaotic motion chaotic at one step keeps it so at all finer steps.",
    "schemes and problems with regular motion at a finer step than one with chaotic motion",
    whose=PRACTICE,
)
def finer_steps_keep_chaos(chaos):
    lost = lost_again(chaos).stack(case=["problem", "scheme"])
    cases = [f"{case.scheme_title.item()} on {case.problem_title.item()}" for case in lost[lost.values]]
    holds = not cases
    return Finding("; ".join(cases) or "none", holds, when(not holds, "windows of regular motion lie between"))
