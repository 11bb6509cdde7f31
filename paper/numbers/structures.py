"""Numbers of the text: structures."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.claims.ledger import by_name
from paper.claims.structures import SAMPLES_OF_SAWTOOTH, balanced, sawtooth
from paper.data import TURNING
from paper.figures.energy_growth import CEILING, FLOOR, sizes
from paper.products import numbers
from paper.requirements import samples_of_history
from paper.tables.models import answers
from paper.terms import REASONABLE
from paper.wording import joined
from study.words import number, printed, span

#: Schemes without numerical damping with which the text compares the energy-momentum method.
UNDAMPED = ["average_acceleration", "central_difference", "implicit_midpoint", "gauss4"]
#: Relative change of an error from the second finest step to the finest. Below this change, still finer steps do not
#: reduce the error.
LEVEL = 0.3
#: Structure whose runs also have steps between the doubled ones.
PENDULUM = "elastic_pendulum"


def _periods(number: xr.DataArray) -> str:
    """Durations of runs in a sentence, such as "one period" or "1 to 2 periods"."""
    counts = span(number, ".0f")
    return "one period" if counts == "1" else f"{counts} periods"


def _kept(pendulum: xr.Dataset, periods: float) -> pd.DataFrame:
    """Schemes, steps in a period, and whether the runs of a constrained mass over a number of periods succeeded."""
    selection = pendulum.sel(periods=periods)
    kept = (selection.status == 0) & (100 * selection.error.sel(quantity="energy") <= REASONABLE)
    runs = xr.Dataset({"kept": kept, "steps": selection.steps_per_period, "tried": pendulum.tried == 1})
    return runs.to_dataframe().reset_index().query("tried")[["scheme", "steps", "kept"]]


def _limit(runs: pd.DataFrame) -> tuple[float, float]:
    """Most steps in a period at which a run fails, NaN if none does, and the next number of steps that was tried."""
    most = runs.steps[~runs.kept].max()
    return most, runs.steps[runs.steps > most].min()


def _limits(structures: xr.Dataset, pendulum: xr.Dataset) -> dict[str, tuple[float, float]]:
    """By scheme, the limit on the turning structure that needs the most steps."""
    kept = balanced(structures, TURNING)
    runs = kept.rename("kept").to_dataframe().reset_index().rename(columns={"steps_per_period": "steps"})
    duration = structures.periods.sel(problem=PENDULUM).item()
    if duration in pendulum.periods:
        finer = _kept(pendulum, duration).assign(problem=PENDULUM)
        runs = pd.concat([runs, finer[finer.scheme.isin(kept.scheme.values)]])
    limits = runs.groupby(["scheme", "problem"])[["steps", "kept"]].apply(_limit)
    return {
        scheme: max(problem_limits, key=lambda limit: np.nan_to_num(limit[0]))
        for scheme, problem_limits in limits.groupby("scheme")
    }


def _between(limit: tuple[float, float]) -> str | None:
    """A limit in a sentence; None if no run fails."""
    most, following = limit
    if np.isnan(most):
        return None
    return f"above {most:.0f}" if np.isnan(following) else f"between {most:.0f} and {following:.0f}"


def _fails_in_longer_runs(pendulum: xr.Dataset) -> dict[str, str | None]:
    """Limit of average acceleration in the longest runs of a constrained mass, and most steps that fail there."""
    longest = pendulum.periods.values[-1]
    runs = _kept(pendulum, longest)
    limit = _limit(runs[runs.scheme == "average_acceleration"])
    return {
        "fails_longer_to": f"{limit[0]:.0f}",
        "fails_longer_limit": _between(limit),
        "fails_longer_periods": f"{longest:g}",
    }


def _accurate_unbalanced(decisions: xr.Dataset, limits: dict[str, tuple[float, float]]) -> dict[str, str | None]:
    """The scheme of the article for a stiff constraint, and the limit of its balance; None if its own steps keep."""
    constrained = answers(decisions).get("stiff constraint")
    if constrained is not None:
        chosen = constrained.sel(kind="implicit")
        limit = limits.get(chosen.scheme.item(), (np.nan, np.nan))
        if chosen.steps_per_period <= limit[0]:
            return {"accurate_unbalanced": chosen.scheme_title.item(), "accurate_unbalanced_limit": _between(limit)}
    return {"accurate_unbalanced": None, "accurate_unbalanced_limit": None}


def _in_a_sentence(title: str) -> str:
    """The title of a structure within a sentence, such as "the stiff bar" or "Duffing's oscillator, chaotic"."""
    return f"the {title}".replace("the Duffing,", "Duffing's oscillator,")


def _plateaus(structures: xr.Dataset) -> dict[str, str | None]:
    """Errors of two schemes on the stiff and soft spring at the finer half of the steps, in percent.

    None if the schemes were not run, or if the finest step reduces the errors.
    """
    names = "gauss4", "bathe"
    nothing: dict[str, str | None] = {f"plateau_{name}": None for name in (*names, "from", "to")}
    if "stiff_soft" not in structures.problem or not set(names) <= set(structures.scheme.values):
        return nothing
    error = structures.sampled_displacement_error.sel(problem="stiff_soft", scheme=list(names))
    finer = error.isel(steps_per_period=slice(error.sizes["steps_per_period"] // 2, None))
    *_, before, last = finer.transpose("steps_per_period", "scheme").values
    if not (abs(before / last - 1) < LEVEL).all():
        return nothing
    steps = finer.steps_per_period.values
    return {
        **{f"plateau_{name}": span(100 * finer.sel(scheme=name), ".2g") for name in names},
        "plateau_from": f"{steps[0]}",
        "plateau_to": f"{steps[-1]}",
    }


@numbers(
    reference="reference/elastic_pendulum",
    stiff_soft="structure_history/stiff_soft",
    long_times="structure_history/long_times",
    pendulum="runs/elastic_pendulum",
    stiff_bar="structure_history/stiff_bar",
    stiff_truss="structure_history/stiff_truss",
    requires={
        "structures.lengths.problem": ["elastic_pendulum", "fpu_chain"],
        "structures.schemes": [*UNDAMPED, "energy_momentum"],
        "structure_history.stiff_soft.schemes": ["average_acceleration", "bathe"],
        "structure_history.stiff_soft": samples_of_history(SAMPLES_OF_SAWTOOTH),
        "structure_history.long_times.problem": "fpu_chain",
        "structure_history.long_times.schemes": [
            "central_difference",
            "implicit_midpoint",
            "energy_momentum",
            "bathe",
            "kahan_li8",
        ],
        "structure_history.long_times": samples_of_history(1),
    },
)
def structure_numbers(
    structures: xr.Dataset,
    decisions: xr.Dataset,
    reference: xr.Dataset,
    stiff_soft: xr.Dataset,
    long_times: xr.Dataset,
    pendulum: xr.Dataset,
    stiff_bar: xr.Dataset,
    stiff_truss: xr.Dataset,
) -> dict:
    """Energies of stiff and rotating structures, and the tolerance of a reference."""
    runs = balanced(structures, TURNING)
    limits = _limits(structures, pendulum)
    alternating = sawtooth(stiff_soft.v.isel(component=0))
    change = by_name(100 * long_times.max_sum_change)
    turning = [stiff_bar, stiff_truss]
    return {
        "most_unknowns": int(structures.unknowns.max()),
        "structure_titles": joined(map(_in_a_sentence, structures.problem_title.values), {}),
        "turning_titles": joined(map(_in_a_sentence, runs.problem_title.values), {}),
        "trapezoidal_fails_turning": bool(limits["average_acceleration"][0] > 0),
        "momentum_method_stable": bool(np.isnan(limits["energy_momentum"][0]))
        and all(limits[name][0] > 0 for name in UNDAMPED),
        "balance_allowed": f"{REASONABLE:g}",
        "structure_tolerance": f"{np.log10(reference.rtol):.0f}",
        "turning_limit": _between(limits["average_acceleration"]),
        "turning_periods": _periods(structures.periods.sel(problem=runs.problem)),
        **{f"limit_of_{name}": _between(limit) for name, limit in limits.items()},
        **{f"sawtooth_{name}": number(a, 2) for name, a in zip(stiff_soft.scheme.values, alternating, strict=True)},
        "structure_samples": int(reference.samples_per_period),
        "chain_best": f"{100 * structures.sampled_displacement_error.sel(problem='fpu_chain').min().item():.2g}",
        "long_time": f"{long_times.t.max().item():,.0f}",
        "long_step": number(long_times.step_size.item()),
        **_plateaus(structures),
        **_fails_in_longer_runs(pendulum),
        **_accurate_unbalanced(decisions, limits),
        "stiff_soft_steps": stiff_soft.steps_per_period.item(),
        "stiff_bar_steps": stiff_bar.steps_per_period.item(),
        "stiff_truss_steps": stiff_truss.steps_per_period.item(),
        "growth_ceiling": printed(f"{CEILING:.0e}") if any((sizes(run) > CEILING).any() for run in turning) else None,
        "growth_floor": printed(f"{FLOOR:.0e}") if any((sizes(run) < FLOOR).any() for run in turning) else None,
        "growth_fails": any((run.status != 0).any() for run in turning),
        # whole percents, as round-off changes even their last digit over this time
        **{f"sum_{name}": f"{value:.0f}" for name, value in change.items()},
    }
