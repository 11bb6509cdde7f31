"""Numbers of the text: chaotic motions by scheme and step."""

import numpy as np
import xarray as xr

from paper.claims.chaos import (
    contraction_ratio,
    fewest_steps,
    fewest_steps_of_mean,
    is_second,
    lost_again,
    orders_of_means,
    ueda_of,
)
from paper.products import numbers
from paper.terms import FAITHFUL
from paper.wording import joined, number
from study.words import at_most, listed, span

#: Number of standard errors of an interval.
ERRORS = 2
#: Relative error of the mean square that is allowed in the answer on chaotic motion.
MEAN_ERROR = 0.01
SCHEMES = ["average_acceleration", "central_difference", "rk4", "newmark_dissipative"]


def _is_below_two(order: float, half: float) -> bool:
    """Whether the interval of an order excludes second order."""
    return bool(order + half < 2)


def windows(steps: np.ndarray, inside: np.ndarray) -> str | None:
    """Ranges of neighbouring steps tried that are inside, such as ``8 to 24 and 40``, or None without any."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int))).reshape(-1, 2)
    words = [f"{steps[a]} to {steps[b - 1]}" if b - a > 1 else f"{steps[a]}" for a, b in ends]
    return listed(words) if words else None


def _largest_exponent(motion: xr.Dataset) -> str:
    return f"{motion.lyapunov_exponent.item():.3f} ± {ERRORS * motion.lyapunov_exponent_uncertainty.item():.3f}"


@numbers(requires={"chaos.schemes": SCHEMES})
def chaos_numbers(chaos: xr.Dataset) -> dict:
    """Exponents, contraction, orders of mean squares, and steps with regular motion."""
    ueda, fewest = ueda_of(chaos), np.array(list(fewest_steps(chaos).values()))
    sufficient = [
        (steps, ueda.scheme_title.values[fewest == steps]) for steps in np.unique(fewest[np.isfinite(fewest)])
    ]
    exact = ueda.sel(scheme="rk4").isel(steps_per_period=-1)
    mean_steps = fewest_steps_of_mean(chaos, MEAN_ERROR)
    ratio = contraction_ratio(chaos)
    fine = chaos.sel(scheme="rk4").isel(steps_per_period=-1, place=0)
    most = chaos.steps_per_period.values[chaos.regular.sel(scheme="newmark_dissipative", problem="ueda").values == 1]
    others = [name for name in chaos.problem.values if name != "ueda"]
    titles = dict(zip(chaos.problem.values, chaos.problem_title.values, strict=True))
    beam = chaos.sel(problem="buckled_beam").isel(steps_per_period=-1)
    spectrum = beam.sel(scheme="rk4")
    differences = beam.lyapunov_exponent - spectrum.lyapunov_exponent
    lost = lost_again(chaos).stack(case=["problem", "scheme"])

    def regular(problem: str, scheme: str) -> str | None:
        is_regular = (chaos.regular.sel(problem=problem, scheme=scheme) == 1).values
        return windows(chaos.steps_per_period.values, is_regular)

    def ordered(problem: str, scheme: str) -> str:
        order, half = orders_of_means(chaos, problem)[scheme]
        return f"{order:.1f} ± {half:.1f}" if half < order else "none"

    def second(problem: str) -> bool:
        return all(is_second(*orders_of_means(chaos, problem)[scheme]) for scheme in FAITHFUL)

    return {
        "ueda_printed": f"{ueda.printed_exponent.item():.4f}",
        "ueda_steps": listed(f"{steps:.0f} with {joined(titles, {})}" for steps, titles in sufficient)
        if sufficient
        else None,
        "ueda_never": listed(ueda.scheme_title.values[~np.isfinite(fewest)]) if not np.isfinite(fewest).all() else None,
        "ueda_periods": f"{ueda.periods.item():,}",
        "ueda_mean_square": f"{exact.mean_square.item():.4g}",
        "ueda_mean_square_uncertainty": number(exact.mean_square_uncertainty.item(), ".0e"),
        **{f"ueda_order_{name}": ordered("ueda", name) for name in FAITHFUL},
        "ueda_mean_error": f"{100 * MEAN_ERROR:g}",
        "ueda_finest": f"{chaos.steps_per_period.values[-1]}",
        **{f"ueda_mean_steps_{name}": number(mean_steps[name], ".0f") for name in FAITHFUL},
        "ueda_converges": second("ueda"),
        "ueda_regular": "; ".join(
            f"by {title} with {regular('ueda', name)} steps"
            for name, title in zip(chaos.scheme.values, chaos.scheme_title.values, strict=True)
            if regular("ueda", name)
        )
        or "none",
        "chaos_exponents": listed(
            f"{_largest_exponent(fine.sel(problem=name))} ({titles[name]})" for name in chaos.problem.values
        ),
        "chaos_beam_spectrum": listed(
            f"{value:.3f} ± {ERRORS * error:.3f}".replace("-", "−")
            for value, error in zip(
                spectrum.lyapunov_exponent.values, spectrum.lyapunov_exponent_uncertainty.values, strict=True
            )
        ),
        **{
            f"chaos_beam_spectrum_{name}": f"{abs(differences.sel(scheme=name)).max().item():.3f}"
            for name in (*FAITHFUL, "newmark_dissipative")
        },
        "chaos_kept_contraction": at_most(100 * abs(ratio.sel(scheme="central_difference") - 1).max().item()),
        "chaos_contraction": span(ratio.sel(scheme="newmark_dissipative", problem="ueda"), ".1f"),
        "chaos_beam_contraction": span(ratio.sel(scheme="newmark_dissipative", problem="buckled_beam"), ".1f"),
        "chaos_beam_regular": regular("buckled_beam", "newmark_dissipative"),
        "chaos_regular_most": f"{most.max()}" if most.size else None,
        "chaos_windows": "; ".join(
            f"{case.scheme_title.item()} on {case.problem_title.item()} with {regular(*case.case.item())} steps"
            for case in lost[lost.values]
        )
        or None,
        "chaos_no_order_elsewhere": not any(map(second, others)),
        "chaos_order_duffing": ordered("duffing_chaotic", "average_acceleration"),
        "chaos_order_is_lower": _is_below_two(*orders_of_means(chaos, "duffing_chaotic")["average_acceleration"]),
        "chaos_orders": listed(
            (f"{listed(ordered(name, scheme) for scheme in FAITHFUL)} ({titles[name]})" for name in others), "; "
        ),
    }
