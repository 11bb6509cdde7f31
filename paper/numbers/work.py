"""Numbers of the text: time against error, and the cheapest schemes."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import of_the_paper
from paper.products import numbers
from paper.published import SCHEMES, printed_cpu_times

#: The error of the displacement at which the fastest are compared.
EXACTING = 1e-10


def _cheapest_below(data: xr.Dataset, dimension: str, error: xr.DataArray, time: xr.DataArray) -> tuple[str, float]:
    """The fastest along a dimension that reaches ``EXACTING``, and its milliseconds."""
    error, time = error.sel({dimension: data[dimension]}), time.sel({dimension: data[dimension]})
    enough = time.where(error <= EXACTING).min(set(time.dims) - {dimension})
    return enough.idxmin(dimension).item(), 1e3 * enough.min().item()


@numbers(
    work="work_precision",
    asks={
        "work_precision.schemes.schemes": SCHEMES,
        "work_precision.schemes.problems": ["hardening"],
        "work_precision.solvers.problems": ["hardening"],
        "work_precision.solvers.periods": [100],
        "recommendation.measures": ["max_trajectory_error"],
    },
)
def of_work(work: xr.Dataset, recommendation: xr.Dataset) -> dict:
    """Cost of an error, and the cheapest schemes."""
    spring = work.sel(problem="hardening", periods=100)
    rk4 = spring.sel(scheme="rk4").isel(steps_per_period=-1)
    heyoka = spring.sel(solver="heyoka").isel(tolerance=-1)
    of_1996 = of_the_paper(recommendation).time.sel(measure="max_trajectory_error")
    kept = of_1996.notnull().any("scheme")
    fastest = of_1996.fillna(np.inf).idxmin("scheme").where(kept, "")
    count = {scheme: int((fastest == scheme).sum()) for scheme in ("rk4", "central_difference")}
    titles = dict(zip(work.scheme.values, work.scheme_title.values, strict=True))
    best, best_ms = _cheapest_below(spring, "scheme", spring.max_trajectory_error, spring.time_per_run)
    _, peer_ms = _cheapest_below(
        spring.sel(solver=["heyoka"]), "solver", spring.solver_max_trajectory_error, spring.solver_time_per_run
    )
    coarse = spring.newton_iterations_per_step.sel(scheme="average_acceleration").isel(steps_per_period=0)
    return {
        "work_rk4": count["rk4"],
        "work_central_difference": count["central_difference"],
        "seven_explicit_only": sum(count.values()) == int(kept.sum()),
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


def _counted(names: np.ndarray, titles: dict[str, str]) -> str:
    """Schemes with the number of times that each is named, the most frequent first."""
    ranking = pd.Series(names).value_counts()
    return ", ".join(f"{titles[name]} ({number})" for name, number in ranking.items())


@numbers(asks={"recommendation.measures": ["max_energy_error"]})
def of_all_measures(recommendation: xr.Dataset) -> dict:
    """The fastest schemes over all problems, errors, lengths and measures of error."""
    titles = dict(zip(recommendation.scheme.values, recommendation.scheme_title.values, strict=True))
    explicit = dict(zip(recommendation.scheme.values, recommendation.explicit.values == 1, strict=True))
    fastest = recommendation.cheapest_scheme.values.ravel()
    fastest = fastest[fastest != ""]
    implicit = recommendation.scheme.values[recommendation.explicit.values == 0]
    ties = (recommendation.ties_with_fastest.sel(scheme=implicit) == 1).any("scheme").values.ravel()
    names = recommendation.cheapest_scheme.values.ravel()
    tied_by_implicit = [bool(tie) and explicit[name] for name, tie in zip(names, ties, strict=True) if name]
    won = sum(explicit[name] for name in fastest)
    by_measure = {
        measure: [name for name in recommendation.cheapest_scheme.sel(measure=measure).values.ravel() if name]
        for measure in recommendation.measure.values
    }
    *shorter, longest = (f"{length:,}" for length in recommendation.periods.values)
    close = recommendation.cheapest_scheme.sel(measure="max_energy_error", error=recommendation.error.min()).values
    tied = (recommendation.ties_with_fastest.sum("scheme") > 1).sum()
    return {
        **{
            f"work_explicit_{measure}": f"{sum(explicit[name] for name in cells)} of {len(cells)}"
            for measure, cells in by_measure.items()
        },
        "work_of_all": fastest.size,
        "work_explicit_tied": sum(tied_by_implicit),
        "explicit_wins_most": won > fastest.size / 2,
        "work_ranking_of_all": _counted(fastest, titles),
        "work_ties": int(tied),
        "energy_won_by_conserving": bool((close == "energy_momentum").all()),
        "recommended_periods": " and ".join(filter(None, (", ".join(shorter), longest))),
    }


@numbers(asks={"cpu_time.schemes": ["average_acceleration", "rk4"], "cpu_time.problems": ["hardening"]})
def of_times(cpu_time: xr.Dataset) -> dict:
    """Times of a step, the cost of the Runge-Kutta method in 1996 and now, and the processor of now."""
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
