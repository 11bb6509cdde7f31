"""Computing time of a step, as in the last rows of Tables 1 and 2 of Xie (1996)."""

from collections.abc import Mapping

import jax
import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, Repeats, Schemes, Springs
from study.experiments import coordinates
from study.marching.timing import Timed
from study.observer.energy import MaxEnergyError
from study.problem.named import approximate_periods
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name

#: Scheme whose time of a step is the unit of ``ratio``.
BASELINE = "average_acceleration"


def _check(options: Options, configuration: Mapping) -> str | None:
    if BASELINE not in options["schemes"]:
        return f"schemes lacks '{BASELINE}', with which times are compared."
    return None


@experiment("cpu_time", check=_check, timed=True)
def cpu_time(
    problems: Springs, schemes: Schemes, steps_per_period: Count, steps: Count, repeats: Repeats
) -> xr.Dataset:
    """Measure the time of a step of every scheme with the energy observed, and the compile time of every scheme.

    The schemes are timed in turns, so that a slow moment of the machine affects all of them. The step size is T/N, with
    T the period printed by Xie (1996) and N = ``steps_per_period``. Times of a step have the shape
    (problem, scheme, repeat).
    """
    # no program may come from the cache of an earlier process, because the compile time is measured too
    jax.config.update("jax_enable_compilation_cache", False)
    shape = (len(problems), len(schemes))
    seconds_to_compile, elapsed = np.empty(shape), np.empty((*shape, repeats))
    for p, problem in enumerate(problems):
        progress(f"timing on {problem}")
        timed = [Timed(problems_by_name[problem], schemes_by_name[scheme], (MaxEnergyError(),)) for scheme in schemes]
        seconds_to_compile[p] = [timer.seconds_to_compile for timer in timed]
        for repeat in range(repeats):
            for s, timer in enumerate(timed):
                elapsed[p, s, repeat], _ = timer.run(approximate_periods[problem] / steps_per_period, steps)
    per_step = elapsed / steps
    quartiles = np.quantile(per_step, [0.25, 0.5, 0.75], axis=-1)
    ratio = np.quantile(per_step / per_step[:, [list(schemes).index(BASELINE)]], [0.25, 0.5, 0.75], axis=-1)
    dims = ("problem", "scheme")
    return xr.Dataset(
        {
            "seconds_per_step": (
                (*dims, "repeat"),
                per_step,
                {"long_name": "time of one step, by repeat", "units": "s"},
            ),
            "median_seconds_per_step": (dims, quartiles[1], {"long_name": "median time of one step", "units": "s"}),
            "spread_of_seconds_per_step": (
                dims,
                quartiles[2] - quartiles[0],
                {"long_name": "interquartile range of the time of one step", "units": "s"},
            ),
            "ratio": (
                dims,
                ratio[1],
                {"long_name": f"median ratio of the time to the time of {BASELINE} in the same repeat", "units": "1"},
            ),
            "ratio_low": (dims, ratio[0], {"long_name": "lower quartile of these ratios", "units": "1"}),
            "ratio_high": (dims, ratio[2], {"long_name": "upper quartile of these ratios", "units": "1"}),
            "seconds_to_compile": (dims, seconds_to_compile, {"long_name": "time to trace and compile", "units": "s"}),
        },
        coords={
            "repeat": ("repeat", np.arange(repeats), {"long_name": "repeat", "units": "1"}),
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
        },
        attrs={
            "title": f"Time of {steps} steps at T/{steps_per_period} with the energy observed",
            "steps": steps,
            "processor": io.processor(),
        },
    )
