"""Numbers of the text: computing time for an error, and the cheapest schemes."""

from itertools import product

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import ASSESSED, fastest
from paper.products import numbers
from paper.published import SCHEMES, printed_cpu_times
from paper.requirements import OF_THE_ASSESSMENTS
from study.analysis.recommendation import recommend
from study.words import listed, relative_to

#: Error of the displacement at which the fastest schemes and solvers are compared.
EXACTING = 1e-10


def _cheapest_below(data: xr.Dataset, dimension: str, error: xr.DataArray, time: xr.DataArray) -> tuple[str, float]:
    """The fastest scheme or solver with an error up to ``EXACTING``, and its time in milliseconds.

    ``dimension`` is ``scheme`` or ``solver``.
    """
    error, time = error.sel({dimension: data[dimension]}), time.sel({dimension: data[dimension]})
    enough = time.where(error <= EXACTING).min(set(time.dims) - {dimension})
    return enough.idxmin(dimension).item(), 1e3 * enough.min().item()


@numbers(
    work="work_precision",
    requires={
        "work_precision.schemes.schemes": SCHEMES,
        "work_precision.schemes.problems": ["hardening"],
        "work_precision.solvers.problems": ["hardening"],
        "work_precision.solvers.periods": [100],
    },
)
def of_work(work: xr.Dataset) -> dict:
    """Computing times and errors of schemes and of general solvers on the hardening spring."""
    spring = work.sel(problem="hardening", periods=100)
    rk4 = spring.sel(scheme="rk4").isel(steps_per_period=-1)
    heyoka = spring.sel(solver="heyoka").isel(tolerance=-1)
    titles = dict(zip(work.scheme.values, work.scheme_title.values, strict=True))
    best, best_ms = _cheapest_below(spring, "scheme", spring.max_trajectory_error, spring.time_per_run)
    _, peer_ms = _cheapest_below(
        spring.sel(solver=["heyoka"]), "solver", spring.solver_max_trajectory_error, spring.solver_time_per_run
    )
    coarse = spring.newton_iterations_per_step.sel(scheme="average_acceleration").isel(steps_per_period=0)
    return {
        "work_best": titles.get(best),
        "work_best_ms": f"{best_ms:.2f}" if np.isfinite(best_ms) else None,
        "work_peer_ms": f"{peer_ms:.2f}" if np.isfinite(peer_ms) else None,
        "work_rk4_finest": f"{rk4.max_trajectory_error.item():.0e}",
        "work_rk4_ms": f"{1e3 * rk4.time_per_run.item():.1f}",
        "work_heyoka_finest": f"{heyoka.solver_max_trajectory_error.item():.0e}",
        "work_heyoka_ms": f"{1e3 * heyoka.solver_time_per_run.item():.1f}",
        "work_finest_steps": f"{work.steps_per_period.max().item():,}",
        "work_loosest": f"{np.log10(spring.tolerance.max().item()):.0f}",
        "work_tightest": f"{np.log10(spring.tolerance.min().item()):.0f}",
        "work_iterations_coarse": f"{coarse.item():.1f}",
        "work_diffrax_step": f"{spring.diffrax_rk4_time_per_step.dropna('steps_per_period')[-1].item():.0f}",
        "work_rk4_step": f"{spring.median_time_per_step.sel(scheme='rk4').isel(steps_per_period=-1).item():.0f}",
    }


def _fastest(springs: list[xr.Dataset]) -> pd.DataFrame:
    """The fastest scheme for every spring, quantity and error: its name, its title, and whether it is implicit.

    Among schemes that tie, the fastest scheme is the one with the fewest force evaluations. The column ``tied`` has
    the kinds, explicit or implicit, of all schemes that tie.
    """
    rows = []
    for spring in springs:
        titles = spring.scheme_title.to_series()
        for quantity, error in product(spring.quantity.values, spring.allowed_error.values):
            needs = fastest(recommend(spring, error=error, quantity=quantity))
            if not needs.empty:
                best = needs.index[0]
                rows.append((quantity, error, best, titles[best], needs.kind[best], needs.kind.tolist()))
    return pd.DataFrame(rows, columns=["quantity", "error", "scheme", "title", "kind", "tied"])


@numbers(springs=ASSESSED, requires=OF_THE_ASSESSMENTS)
def of_recommendations(springs: list[xr.Dataset]) -> dict:
    """The fastest schemes on the assessed springs, among all schemes and among the schemes of 1996."""
    best = _fastest(springs)
    explicit = best.kind == "explicit"
    there = [name for name in SCHEMES if name in springs[0].scheme.values]
    of_1996 = _fastest([one.sel(scheme=there, quantity=["displacement"]) for one in springs]).scheme
    tried = xr.concat([one.steps_tried.where(one.recommended_dt > 0) for one in springs], "problem", join="outer")
    closest = best[(best.quantity == "energy") & (best.error == best.error.min())]
    return {
        **{
            f"work_explicit_{quantity}": f"{int(of_quantity.sum())} of {len(of_quantity)}"
            for quantity, of_quantity in explicit.groupby(best.quantity)
        },
        "work_of_all": len(best),
        "error_relative_to": relative_to(),
        "work_explicit_tied": sum("implicit" in tied for tied in best.tied[explicit]),
        "explicit_wins_most": bool(explicit.mean() > 0.5),
        "work_ranking_of_all": ", ".join(f"{one} ({count})" for one, count in best.title.value_counts().items()),
        "work_ties": int((best.tied.str.len() > 1).sum()),
        "energy_won_by_conserving": bool((closest.scheme == "energy_momentum").all()),
        "assessed_periods": listed(sorted({f"{one.attrs['periods']:,}" for one in springs})),
        "assessed_steps": f"{tried.min().item():.0f} to {tried.max().item():.0f}",
        "assessed_errors": listed(f"{100 * error:g}" for error in springs[0].allowed_error.values),
        "work_rk4": int((of_1996 == "rk4").sum()),
        "work_central_difference": int((of_1996 == "central_difference").sum()),
        "assessed_of_1996": len(there),
        "assessed_schemes": springs[0].sizes["scheme"],
        "explicit_of_1996_only": set(of_1996) <= {"rk4", "central_difference"},
    }


@numbers(requires={"cpu_time.schemes": ["average_acceleration", "rk4"], "cpu_time.problems": ["hardening"]})
def of_times(cpu_time: xr.Dataset) -> dict:
    """Times of a step, the cost of the Runge-Kutta method in 1996 and now, and the present processor and software."""
    step = cpu_time.median_time_per_step.sel(problem="hardening")
    in_1996 = printed_cpu_times().sel(problem="hardening")
    printed = in_1996.sel(scheme="rk4") / in_1996.sel(scheme="average_acceleration")
    rk4 = cpu_time.sel(problem="hardening", scheme="rk4")
    return {
        **{f"ns_{name}": f"{step.sel(scheme=name).item():.0f}" for name in step.scheme.values},
        "printed_cost_rk4": f"{printed.item():.2f}",
        "cost_rk4": f"{rk4.ratio.item():.2f} ({rk4.ratio_low.item():.2f} to {rk4.ratio_high.item():.2f})",
        "processor": cpu_time.processor,
        "version": cpu_time.version,
        "python": cpu_time.python,
        "packages": cpu_time.packages,
    }
