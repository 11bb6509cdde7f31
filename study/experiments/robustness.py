"""How many steps a period are enough, at every amplitude and for long: a number for each scheme."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study import datasets
from study.marching.run import run
from study.observer.fate import LEVELS, Excursions, Fate
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import MULTI_OUTPUT_FUSION, experiment
from study.pipeline.options import Counts, RisingCounts, Schemes, Springs
from study.problem.named import problems as registry


def _needed(problem: str, scheme: str, lanes: xr.Dataset, candidates: np.ndarray, lengths: Sequence[int]) -> np.ndarray:
    """Fewest steps a period among the candidates from which on all are enough, (levels, lengths); NaN if none is."""
    definition = registry[problem]
    observer = Excursions(Fate.of(definition).rest)
    u0, period = lanes.u0.values, lanes.period.values
    needed = np.full((len(LEVELS), len(lengths)), np.nan)
    open_still = np.ones(needed.shape, bool)
    # from the finest down; what has failed once is settled
    for steps in sorted(candidates, reverse=True):
        for k, length in enumerate(lengths):
            if not open_still[:, k].any():
                continue
            # a run of its own for each length: of a run that fails later nothing is told
            runs = run(definition, scheme, dt=period / steps, steps=int(steps * length), u0=u0, observe=[observer])
            kept = np.array([np.isinf(runs[name]).all() for name in observer.variables])
            open_still[:, k] &= kept
            needed[open_still[:, k], k] = steps
    return needed


def _steps(o, c) -> int:
    return (
        len(o["problems"])
        * len(o["schemes"])
        * sum(o["steps_per_period"])
        * sum(o["periods"])
        * c["atlas"]["amplitudes"]["count"]
    )


def _without_amplitudes(o, c) -> str | None:
    for name in o["problems"]:
        if name not in c["atlas"]["problems"]:
            return f"problems: '{name}' is none of atlas.problems, whose amplitudes it takes."
    return None


@experiment(
    "stability/robustness",
    section="robustness",
    split=lambda o: {problem: {**o, "problems": [problem]} for problem in o["problems"]},
    along="problem",
    reads=lambda o: ["reference/amplitudes"],
    check=_without_amplitudes,
    steps=_steps,
    environment=MULTI_OUTPUT_FUSION,
)
def robustness(problems: Springs, schemes: Schemes, steps_per_period: Counts, periods: RisingCounts) -> xr.Dataset:
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
            needed[p, s] = _needed(problem, scheme, lanes, np.asarray(steps_per_period), sorted(periods))
    return xr.Dataset(
        {
            "steps_needed": (
                ("problem", "scheme", "level", "periods"),
                needed,
                {
                    "long_name": "fewest steps per period from which on all that were tried keep the energy within the "
                    f"level at all amplitudes of reference/amplitudes; NaN where {max(steps_per_period)} do not",
                    "units": "1",
                },
            ),
            "most_steps": ((), max(steps_per_period), {"long_name": "most steps per period tried", "units": "1"}),
        },
        coords={
            **labels.problem_coordinates(problems),
            **labels.scheme_coordinates(schemes),
            "level": ("level", list(LEVELS), {"long_name": "error of the energy over its height", "units": "percent"}),
            "periods": ("periods", sorted(periods), {"long_name": "length of the run in periods", "units": "1"}),
        },
        attrs={"title": "Steps per period that every scheme needs at all amplitudes"},
    )
