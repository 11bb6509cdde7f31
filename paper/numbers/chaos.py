"""Numbers of the text: chaotic motions by scheme and step."""

import numpy as np
import xarray as xr

from paper.claims.chaos import contraction_ratio, fewest_steps, is_second, lost_again, orders_of_means, ueda_of
from paper.products import numbers
from paper.terms import FAITHFUL
from paper.wording import number
from study.words import listed, span

#: Number of standard errors of an interval.
ERRORS = 2
SCHEMES = ["average_acceleration", "central_difference", "rk4", "newmark_dissipative"]


@numbers(requires={"chaos.schemes": SCHEMES})
def of_chaos(chaos: xr.Dataset) -> dict:
    """Exponents, contraction, orders of mean squares, and steps with regular motion."""
    ueda, fewest = ueda_of(chaos), np.array(list(fewest_steps(chaos).values()))
    exact = ueda.sel(scheme="rk4").isel(steps_per_period=-1)
    ratio = contraction_ratio(chaos)
    fine = chaos.sel(scheme="rk4").isel(steps_per_period=-1, place=0)
    most = chaos.steps_per_period.values[chaos.regular.sel(scheme="newmark_dissipative", problem="ueda").values == 1]
    others = [name for name in chaos.problem.values if name != "ueda"]
    lost = lost_again(chaos).stack(case=["problem", "scheme"])

    def regular(problem: str, scheme: str) -> str | None:
        one = chaos.sel(problem=problem, scheme=scheme)
        steps = one.steps_per_period.values[(one.regular == 1).values].tolist()
        return listed(map(str, steps)) if steps else None

    def ordered(problem: str, scheme: str) -> str:
        order, half = orders_of_means(chaos, problem)[scheme]
        return f"{order:.1f} ± {half:.1f}" if np.isfinite(order) else "none"

    def second(problem: str) -> bool:
        return all(is_second(*orders_of_means(chaos, problem)[scheme]) for scheme in FAITHFUL)

    return {
        "ueda_printed": f"{ueda.printed_exponent.item():.4f}",
        "ueda_steps": span(fewest[np.isfinite(fewest)], ".0f") if np.isfinite(fewest).any() else None,
        "ueda_periods": f"{ueda.periods.item():,}",
        "ueda_mean_square": f"{exact.mean_square.item():.4g}",
        "ueda_mean_square_uncertainty": number(exact.mean_square_uncertainty.item(), ".0e"),
        **{f"ueda_order_{name}": ordered("ueda", name) for name in FAITHFUL},
        "ueda_converges": second("ueda"),
        "ueda_regular": "; ".join(
            f"{title} with {regular('ueda', name)} steps"
            for name, title in zip(chaos.scheme.values, chaos.scheme_title.values, strict=True)
            if regular("ueda", name)
        )
        or "none",
        "chaos_exponents": listed(
            f"{one.exponent.item():.3f} ± {ERRORS * one.uncertainty.item():.3f} ({one.problem_title.item()})"
            for one in (fine.sel(problem=name) for name in chaos.problem.values)
        ),
        "chaos_kept_contraction": f"{100 * abs(ratio.sel(scheme='central_difference') - 1).max().item():.1g}",
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
        "chaos_orders": "; ".join(
            f"{chaos.problem_title.sel(problem=name).item()}: " + listed(ordered(name, scheme) for scheme in FAITHFUL)
            for name in others
        ),
    }
