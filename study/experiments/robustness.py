"""How many steps a period are enough, at every amplitude and for long: a number for each scheme."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study import datasets
from study.command import main, progress
from study.experiments import labels
from study.problems import problems as registry
from study.runs import run
from study.stability import LEVELS, Excursions, Fate


def _needed(problem: str, scheme: str, lanes: xr.Dataset, candidates: np.ndarray, lengths: Sequence[int]) -> np.ndarray:
    """Fewest steps a period among the candidates from which on all are enough, (levels, lengths); NaN if none is."""
    definition = registry[problem]
    observer = Excursions(Fate.of(definition).rest)
    u0, period = lanes.u0.values, lanes.period.values
    needed = np.full((len(LEVELS), len(lengths)), np.nan)
    open_still = np.ones(needed.shape, bool)
    # from the finest down; what has failed once is settled, and the rest needs no longer runs than it asks for
    for steps in sorted(candidates, reverse=True):
        longest = max(length for k, length in enumerate(lengths) if open_still[:, k].any())
        runs = run(definition, scheme, dt=period / steps, steps=int(steps * longest), u0=u0, observe=[observer])
        failed_at = np.where(runs.status > 0, runs.failed_at_step / steps, np.inf)
        for row, name in enumerate(observer.variables):
            # a run that failed has no times; it was beyond every level by then at the latest
            left = np.fmin(runs[name].values / period, failed_at)
            for k, length in enumerate(lengths):
                if open_still[row, k]:
                    open_still[row, k] = left.min() > length
                    needed[row, k] = steps if open_still[row, k] else needed[row, k]
        if not open_still.any():
            break
    return needed


def robustness(
    problems: Sequence[str], schemes: Sequence[str], steps_per_period: Sequence[int], periods: Sequence[int]
) -> xr.Dataset:
    """Fewest steps a period that keep the energy within 1, 5 and 10 percent at all amplitudes, by length of the run.

    The amplitudes are those of ``results/reference/amplitudes``, the period is the exact one at each amplitude.

    Parameters
    ----------
    steps_per_period
        Among which the answer is looked for.
    periods
        Lengths of the runs.
    """
    exact = datasets.open("reference/amplitudes")
    needed = np.empty((len(problems), len(schemes), len(LEVELS), len(periods)))
    for p, problem in enumerate(problems):
        lanes = exact.sel(problem=problem)
        for s, scheme in enumerate(schemes):
            progress(f"steps that {scheme} needs on {problem}")
            needed[p, s] = _needed(problem, scheme, lanes, np.asarray(steps_per_period), periods)
    return xr.Dataset(
        {
            "steps_needed": (
                ("problem", "scheme", "level", "periods"),
                needed,
                {
                    "long_name": "fewest steps per period from which on all that were tried keep the energy within the "
                    f"level at all amplitudes; NaN where {max(steps_per_period)} do not",
                    "units": "1",
                },
            ),
            "most_steps": ((), max(steps_per_period), {"long_name": "most steps per period tried", "units": "1"}),
        },
        coords={
            **labels.problem_coordinates(problems),
            **labels.scheme_coordinates(schemes),
            "level": ("level", list(LEVELS), {"long_name": "error of the energy over its height", "units": "percent"}),
            "periods": ("periods", list(periods), {"long_name": "length of the run in periods", "units": "1"}),
        },
        attrs={"title": "Steps per period that every scheme needs at all amplitudes"},
    )


if __name__ == "__main__":
    main(robustness)
