"""What the paper could not measure: trajectory, phase, period and amplitude of every scheme against the truth."""

import numpy as np
import xarray as xr

from study import datasets
from study.analysis.comparison import against, flagged, uncertainties
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import run
from study.observer.effort import NewtonIterations
from study.observer.energy import EnergyDrift, MaxEnergyError
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Counts, Schemes, Springs


def _steps(o, c) -> int:
    return 2 * len(o["problems"]) * len(o["schemes"]) * sum(o["steps_per_period"]) * sum(o["periods"])


def _unknown_phases(o, c) -> str | None:
    known = c["references"]["steps_per_period"]
    missing = [steps for steps in o["steps_per_period"] if steps not in known]
    return f"steps_per_period {missing[0]} is none of references.steps_per_period, {known}." if missing else None


@experiment(
    "accuracy", reads=lambda o: [f"reference/{name}" for name in o["problems"]], check=_unknown_phases, steps=_steps
)
def accuracy(problems: Springs, schemes: Schemes, steps_per_period: Counts, periods: Counts) -> xr.Dataset:
    """Every measure of error of every scheme on every problem, by steps per exact period and length of the run."""
    dims = ("problem", "scheme", "steps_per_period", "periods")
    shape = tuple(map(len, (problems, schemes, steps_per_period, periods)))
    references = {problem: datasets.open(f"reference/{problem}") for problem in problems}
    measured: dict[str, np.ndarray] = {}
    attributes: dict[str, dict] = {"status": STATUS_ATTRIBUTES, "failed_at_step": FAILED_AT_STEP_ATTRIBUTES}
    for p, (problem, reference) in enumerate(references.items()):
        compared = [against(reference, steps, max(steps_per_period)) for steps in steps_per_period]
        for s, scheme in enumerate(schemes):
            progress(f"accuracy of {scheme} on {problem}")
            for k, (steps, (dt, observers)) in enumerate(zip(steps_per_period, compared, strict=True)):
                observe = [*observers, MaxEnergyError(), EnergyDrift(), NewtonIterations()]
                for n, length in enumerate(periods):
                    ds = run(problem, scheme, dt=dt, steps=steps * length, observe=observe)
                    for name, value in ds.data_vars.items():
                        measured.setdefault(str(name), np.empty(shape, value.dtype))[p, s, k, n] = value
                        attributes[str(name)] = value.attrs
    known = [[uncertainties(reference, length) for length in periods] for reference in references.values()]
    measures = list(known[0][0])
    uncertainty = np.array([[[of_run[measure] for of_run in row] for row in known] for measure in measures])
    values = np.array([measured[measure] for measure in measures])
    return xr.Dataset(
        {name: (dims, values, attributes[name]) for name, values in measured.items()}
        | {
            "uncertainty": (
                ("measure", "problem", "periods"),
                uncertainty,
                {"long_name": "uncertainty of the reference in the units of the measure", "units": "1"},
            ),
            "flagged": flagged(values, uncertainty[:, :, None, None, :], ("measure", *dims)),
        },
        coords={
            **labels.problem_coordinates(problems),
            **labels.scheme_coordinates(schemes),
            **labels.steps_per_period_coordinate(steps_per_period),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
            "measure": ("measure", measures, {"long_name": "measure of error, a variable of this dataset"}),
        },
        attrs={"title": "Accuracy of the schemes against the exact solution"},
    )
