"""Numbers of the text: computing time for an error, and the cheapest schemes."""

import numpy as np
import xarray as xr

from paper.products import numbers
from paper.published import PROBLEMS, SCHEMES, printed_cpu_times
from paper.tables.models import ERROR, FILTER, MODELS, USUAL, answers
from paper.tables.whole_motion import ERROR as WHOLE
from paper.wording import joined
from study.runs.needs import FILTERS, WHOLE_MOTION, cheapest, keeps_part, needs
from study.sizes import fewest
from study.words import listed

#: Error of the displacement at which the fastest schemes and solvers are compared.
EXACTING = 1e-10
#: Problems of the short table whose displacement is measured.
DISPLACED = [problem for problem, quantity in MODELS.values() if quantity == "displacement"]
#: Relative distances of a number of steps in a period from a whole number: those up to the first are round-off, and
#: those up to the second are next to it.
ROUND_OFF, NEXT_TO_WHOLE = 1e-9, 2e-4


def fastest(error: xr.DataArray, time: xr.DataArray, dimension: str, along: str) -> tuple[str, float]:
    """The fastest scheme or solver with an error up to ``EXACTING``, and its time in milliseconds.

    ``dimension`` is ``scheme`` or ``solver``. All slower runs of the scheme along a dimension must keep the error too.
    """
    times = fewest(error, time, EXACTING, along)
    return times.idxmin(dimension).item(), 1e3 * times.min().item()


@numbers(
    work="work_precision",
    requires={
        "work_precision.schemes.schemes": SCHEMES,
        "work_precision.schemes.problems": ["hardening"],
        "work_precision.solvers.problems": ["hardening"],
        "work_precision.solvers.periods": [100],
    },
)
def work_numbers(work: xr.Dataset) -> dict:
    """Computing times and errors of schemes and of general solvers on the hardening spring."""
    spring = work.sel(problem="hardening", periods=100)
    titles = dict(zip(work.scheme.values, work.scheme_title.values, strict=True))
    best, best_ms = fastest(spring.displacement_error, spring.median_seconds, "scheme", "steps_per_period")
    peer = spring.sel(solver=["heyoka"])
    _, peer_ms = fastest(peer.solver_last_period_error, peer.median_solver_seconds, "solver", "tolerance")
    return {
        "work_best": titles.get(best),
        "work_best_ms": f"{best_ms:.2f}" if np.isfinite(best_ms) else None,
        "work_peer_ms": f"{peer_ms:.2f}" if np.isfinite(peer_ms) else None,
        "work_loosest": f"{np.log10(spring.tolerance.max().item()):.0f}",
        "work_tightest": f"{np.log10(spring.tolerance.min().item()):.0f}",
    }


def _partly(decisions: xr.Dataset, needs: xr.Dataset) -> list[str]:
    """Kinds of models for which the step of a scheme in the short table does not keep the whole motion."""
    models = list[str]()
    for model, decided in answers(decisions).items():
        here = needs.sel(problem=decided.problem.item(), quantity=decided.quantity.item())
        here = here.sel(allowed_error=ERROR, method="nearest").sel(scheme=[*filter(None, decided.scheme.values)])
        if keeps_part(here).any():
            models.append(model)
    return models


def _momentum_steps(implicit: xr.Dataset) -> str | None:
    """The steps in a period of the energy-momentum method if it is the cheapest implicit scheme in all cases."""
    steps = np.unique(implicit.steps_per_period)
    alone = (implicit.scheme == "energy_momentum").all() and steps.size == 1
    return f"{steps.item():g}" if alone else None


def _starts(decisions: xr.Dataset) -> dict[str, str | None]:
    """Numbers of the further starts of problems whose force has kinks, and of the other ones without a record."""
    started = decisions.sel(problem=~(decisions.spacing > 0))
    kinked, smooth = (started.sel(problem=started.has_kinks == flag) for flag in (1, 0))
    titled = zip(kinked.starts.values, kinked.problem_title.values, strict=True)
    with_kinks = [f"{starts - 1} of the {title}" for starts, title in titled]
    without_kinks = [f"{starts - 1}" for starts in np.unique(smooth.starts.values)]
    return {
        "kinked_starts": listed(with_kinks) if with_kinks else None,
        "other_starts": listed(without_kinks) if without_kinks else None,
    }


def _further_runs(runs: xr.Dataset) -> dict[str, str | None]:
    """Median distance in percent of the steps next to whole parts of the period, None without them, and durations.

    The durations, in periods, are those beyond the one for which steps are decided.
    """
    confirming = runs.steps_per_period.values[runs.proposed.values == 0]
    distance = abs(confirming / np.rint(confirming) - 1)
    beside = distance[(distance > ROUND_OFF) & (distance < NEXT_TO_WHOLE)]
    longer = runs.periods.values[runs.periods.values > runs.decided.item()]
    return {
        "beside": f"{100 * np.median(beside):.2g}" if beside.size else None,
        "longer_durations": listed(f"{periods:g}" for periods in longer),
    }


@numbers(softening="runs/softening")
def decision_numbers(decisions: xr.Dataset, needs: xr.Dataset, softening: xr.Dataset) -> dict:
    """Schemes and kinds that need the fewest forces on the springs, and the conditions of the decisions."""
    springs = decisions.sel(problem=[name for name in PROBLEMS if name in decisions.problem.values], filter="all")
    first = springs.isel(kind=cheapest(springs, "kind"))
    explicit = (first.kind == "explicit") & first.step_size.notnull()
    counted = {
        f"fewer_explicit_{quantity}": f"{int(fewer.sum())} of {fewer.size}"
        for quantity, fewer in explicit.groupby("quantity")
    }
    least = first.scheme_title.sel(quantity="displacement").to_series()
    return {
        **counted,
        "fewest_of_displacement": joined((f"{title} in {count}" for title, count in least.value_counts().items()), {}),
        "momentum_keeps_energy": _momentum_steps(springs.sel(quantity="energy", kind="implicit")),
        **_starts(decisions),
        "decided_errors": listed(f"{100 * error:g}" for error in decisions.allowed_error.values),
        "decided_periods": listed(sorted({f"{periods:,.0f}" for periods in springs.decided.values})),
        **_further_runs(softening),
        "whole_bounds": listed(
            f"{100 * WHOLE_MOTION[quantity]:g}" for quantity in ("velocity", "acceleration", "energy")
        ),
        "whole_error": f"{100 * WHOLE:g}",
        "models_kinds": len(answers(decisions)),
        "models_error": f"{100 * ERROR:g}",
        "models_partly": listed(partly) if (partly := _partly(decisions, needs)) else None,
        "candidates": needs.sizes["scheme"],
        "models_candidates": int(needs.in_codes.sum()),
    }


@numbers(runs=[f"runs/{problem}" for problem in DISPLACED])
def longer_run_numbers(decisions: xr.Dataset, runs: list[xr.Dataset]) -> dict:
    """Kinds of models with a step, also of average acceleration, that only the longer runs require."""
    shorter, finer = dict(zip(DISPLACED, runs, strict=True)), list[str]()
    for model, decided in answers(decisions).items():
        if ds := shorter.get(decided.problem.item()):
            place = {"quantity": decided.quantity.item(), "condition": FILTERS[FILTER][0], "allowed_error": ERROR}
            alone, longer = (
                needs(part, [ERROR]).sel(place).step_size.to_series()
                for part in (ds.sel(periods=[ds.decided.item()]), ds)
            )
            schemes = {*alone.index[~(longer >= alone * (1 - ROUND_OFF)) & alone.notna()]}
            finer += [model] * bool(schemes & {*decided.scheme.values, USUAL})
    return {"models_longer": listed(finer) if finer else None}


@numbers(requires={"cpu_time.schemes": ["average_acceleration", "rk4"], "cpu_time.problems": ["hardening"]})
def computing_time_numbers(cpu_time: xr.Dataset) -> dict:
    """Times of a step, the cost of the Runge-Kutta method in 1996 and now, and the present processor and software."""
    step = 1e9 * cpu_time.median_seconds_per_step.sel(problem="hardening")
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
