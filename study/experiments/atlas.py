"""Where a scheme can be trusted and how it fails elsewhere: one tile of the maps over step size and amplitude."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study import datasets
from study.command import main, progress
from study.experiments import labels
from study.problem import Problem
from study.problems import problems as registry
from study.runs import run
from study.stability import OUTCOMES, Fate, outcomes

_OUTCOME_ATTRIBUTES = {
    "long_name": "how the run ended",
    "flag_values": np.arange(len(OUTCOMES), dtype=np.int8),
    "flag_meanings": " ".join(OUTCOMES),
}


def _column(problem: Problem, scheme: str, fate: Fate, u0: np.ndarray, dt: np.ndarray, steps: int) -> dict:
    """One step size over all amplitudes."""
    runs = run(problem, scheme, dt=dt, steps=steps, u0=u0, observe=[fate, "lyapunov_exponent"])
    outcome, began = outcomes(runs)
    step = np.where(np.isnan(began), -1, np.rint(began / dt))
    return {
        "outcome": outcome,
        "at_step": np.where(runs.status > 0, runs.failed_at_step, step).astype(np.int32),
        "max_energy_error": runs.max_energy_error.values.astype(np.float32),
        "max_newton_iterations": runs.max_newton_iterations.values.astype(np.float32),
        "lyapunov_exponent": runs.lyapunov_exponent.values.astype(np.float32),
    }


def atlas(
    scheme: str, problems: Sequence[str], dt_over_period: dict[str, float], periods: int, tile: int, tiles: int
) -> xr.Dataset:
    """How the runs of a scheme end, for one of ``tiles`` parts of the amplitudes of ``results/reference/amplitudes``.

    Parameters
    ----------
    dt_over_period
        ``first`` and ``last`` power of ten of Δt/T, with T the period at the amplitude, and the ``count`` of them.
    periods
        Length of the runs in periods.
    """
    exact = datasets.open("reference/amplitudes")
    own = np.array_split(np.arange(exact.sizes["amplitude"]), tiles)[tile]
    exact = exact.isel(amplitude=own)
    parts = np.logspace(dt_over_period["first"], dt_over_period["last"], int(dt_over_period["count"]))
    found: dict[str, list] = {}
    for name in problems:
        progress(f"stability of {scheme} on {name}")
        problem, of_problem = registry[name], exact.sel(problem=name)
        u0, period, fate = of_problem.u0.values, of_problem.period.values, Fate.of(problem)
        columns = [_column(problem, scheme, fate, u0, part * period, round(periods / part)) for part in parts]
        for variable in columns[0]:
            found.setdefault(variable, []).append(np.stack([column[variable] for column in columns], axis=1))
    dims = ("problem", "amplitude", "dt_over_period")
    attributes = {
        "outcome": _OUTCOME_ATTRIBUTES,
        "at_step": {"long_name": "step at which it began, -1 where the run is accurate", "units": "1"},
        "max_energy_error": {
            "long_name": f"largest error of the energy over its height above rest in {periods} periods",
            "units": "percent",
        },
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"},
    }
    return (
        xr.Dataset(
            {name: (dims, np.stack(values), attributes[name]) for name, values in found.items()},
            coords={
                **labels.problem_coordinates(problems),
                "amplitude": exact.amplitude,
                "u0": exact.u0.sel(problem=list(problems)),
                "period": exact.period.sel(problem=list(problems)),
                "highest_frequency": exact.highest_frequency.sel(problem=list(problems)),
                "dt_over_period": ("dt_over_period", parts, {"long_name": "step size over period", "units": "1"}),
            },
            attrs={"title": f"What becomes of {periods} periods with every scheme, over step size and amplitude"},
        )
        .expand_dims("scheme")
        .assign_coords(labels.scheme_coordinates([scheme]))
    )


if __name__ == "__main__":
    main(atlas)
