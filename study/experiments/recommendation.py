"""Steps, time and forces that every scheme needs to keep an error, from the runs of the study."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study import io
from study.analysis.comparison import MEASURES
from study.analysis.recommendation import READS, candidates
from study.declaration.checks import unlisted
from study.declaration.experiment import Options, experiment
from study.declaration.options import Counts, PlainNames, Springs, Tolerances
from study.experiments import coordinates

_NEEDS = {
    "steps_per_period": {"long_name": "steps per period that the scheme needs", "units": "1"},
    "time": {"long_name": "time of the run", "units": "s"},
    "time_spread": {"long_name": "interquartile range of the time of the run", "units": "s"},
    "force_evaluations": {"long_name": "forces evaluated in the run", "units": "1"},
    "ties_with_fastest": {
        "long_name": "1 where the interquartile range of the time meets that of the least",
        "units": "1",
    },
}


def _check(options: Options, configuration: Mapping) -> str | None:
    problems = configuration["work_precision"]["schemes"]["problems"]
    periods = configuration["accuracy"]["periods"]
    return (
        unlisted("problems", options["problems"], "work_precision.schemes.problems", problems)
        or unlisted("measures", options["measures"], "the measures of error", MEASURES)
        or unlisted("periods", options["periods"], "accuracy.periods", periods)
    )


@experiment("recommendation", reads=lambda options: READS, check=_check)
def recommendation(problems: Springs, measures: PlainNames, errors: Tolerances, periods: Counts) -> xr.Dataset:
    """Find the steps, time and forces that every scheme needs to keep each error, and the cheapest scheme.

    The steps are the fewest of those tried in the dataset ``accuracy`` from which on every finer one keeps the error,
    from the start of the problem and, in the dataset ``neighbours``, from starts one percent beside it.
    The needs have the shape (problem, measure, error, periods, scheme) and are NaN for a scheme that does not keep the
    error. ``cheapest_scheme``, of shape (problem, measure, error, periods), is empty if no scheme keeps it.

    Parameters
    ----------
    measures
        Measures of error, variables of the dataset ``accuracy``.
    errors
        Largest errors that may be made, as fractions: 0.01 is 1 percent.
    periods
        Lengths of the runs in exact periods.
    """
    work, accuracy, neighbours = map(io.open_dataset, READS)
    schemes = work.scheme.values.tolist()
    dims = ("problem", "measure", "error", "periods")
    shape = (len(problems), len(measures), len(errors), len(periods))
    cheapest = np.full(shape, "", dtype=object)
    needs = {name: np.full((*shape, len(schemes)), np.nan) for name in _NEEDS}
    for at in np.ndindex(shape):
        p, m, e, n = at
        table = candidates(accuracy, neighbours, work, problems[p], errors[e], measures[m], periods[n])
        if not table.empty:
            cheapest[at] = table.index[0]
        for name, values in needs.items():
            values[at] = table[name].reindex(schemes).astype(float)
    tried = accuracy.steps_per_period.values
    return xr.Dataset(
        {"cheapest_scheme": (dims, cheapest.astype(str), {"long_name": "cheapest scheme, empty where none"})}
        | {name: ((*dims, "scheme"), values, _NEEDS[name]) for name, values in needs.items()}
        | {
            "coarsest": ((), tried[0], {"long_name": "fewest steps per period that were tried", "units": "1"}),
            "finest": ((), tried[-1], {"long_name": "most steps per period that were tried", "units": "1"}),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **{name: one for name, one in work.coords.items() if one.dims == ("scheme",)},
            "measure": ("measure", list(measures), {"long_name": "measure of error"}),
            "measure_title": accuracy.measure_title.sel(measure=list(measures)).variable,
            "error": ("error", list(errors), {"long_name": "largest error that may be made, a fraction", "units": "1"}),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
        },
        attrs={"title": "What every scheme needs to keep an error, and the cheapest of them"},
    )
