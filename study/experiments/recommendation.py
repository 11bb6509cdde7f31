"""What every scheme needs by target error and length of the run, from the work-precision dataset."""

import numpy as np
import xarray as xr

from study import datasets
from study.analysis.comparison import MEASURES
from study.analysis.recommendation import candidates
from study.pipeline import labels
from study.pipeline.experiment import experiment
from study.pipeline.options import Counts, Names, Springs, Tolerances

_NEEDS = {
    "steps_per_period": {"long_name": "steps per period that the scheme needs", "units": "1"},
    "time": {"long_name": "time of the run", "units": "s"},
    "force_evaluations": {"long_name": "forces evaluated in the run", "units": "1"},
}


def _not_there(o, c) -> str | None:
    work, accuracy = c["work_precision"]["schemes"], c["accuracy"]
    for key, there in (("problems", work["problems"]), ("measures", MEASURES), ("periods", accuracy["periods"])):
        strange = [one for one in o[key] if one not in there]
        if strange:
            return f"{key}: there is no {strange[0]} among {', '.join(map(str, there))}."
    return None


@experiment("recommendation", reads=lambda o: ["work_precision"], check=_not_there)
def recommendation(problems: Springs, measures: Names, errors: Tolerances, periods: Counts) -> xr.Dataset:
    """What every scheme needs to keep an error, and the cheapest of them; NaN and empty where none keeps it."""
    data = datasets.open("work_precision")
    schemes = data.scheme.values.tolist()
    dims = ("problem", "measure", "error", "periods")
    shape = tuple(map(len, (problems, measures, errors, periods)))
    cheapest = np.full(shape, "", dtype=object)
    needs = {name: np.full((*shape, len(schemes)), np.nan) for name in _NEEDS}
    for at in np.ndindex(shape):
        problem, measure, error, length = (
            values[i] for values, i in zip((problems, measures, errors, periods), at, strict=True)
        )
        table = candidates(data, problem, error, measure, length)
        if not table.empty:
            cheapest[at] = table.index[0]
        for name, values in needs.items():
            values[at] = table[name].reindex(schemes)
    return xr.Dataset(
        {"cheapest_scheme": (dims, cheapest.astype(str), {"long_name": "cheapest scheme, empty where none"})}
        | {name: ((*dims, "scheme"), values, _NEEDS[name]) for name, values in needs.items()},
        coords={
            **labels.problem_coordinates(problems),
            **labels.scheme_coordinates(schemes),
            "measure": ("measure", list(measures), {"long_name": "measure of error"}),
            "error": ("error", list(errors), {"long_name": "largest error that may be made, a fraction", "units": "1"}),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
        },
        attrs={"title": "What every scheme needs to keep an error, and the cheapest of them"},
    )
