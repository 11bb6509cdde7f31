"""Accuracy of the schemes: errors of trajectory, phase, period, amplitude and energy against exact solutions."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study import io
from study.analysis.comparison import against, flagged, uncertainties
from study.declaration.checks import unlisted
from study.declaration.experiment import Options, experiment, progress, references
from study.declaration.options import RisingCounts, Schemes, Springs
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.observer.diagnostics import Evaluations, NewtonIterations
from study.observer.energy import EnergyDrift, MaxEnergyError
from study.problem.named import problems as problems_by_name


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse numbers of steps per period whose phases the references do not contain."""
    sampled = configuration["references"]["steps_per_period"]
    return unlisted("steps_per_period", options["steps_per_period"], "references.steps_per_period", sampled)


@experiment(
    "accuracy",
    split=lambda options: {problem: {**options, "problems": [problem]} for problem in options["problems"]},
    along="problem",
    reads=references,
    check=_check,
)
def accuracy(problems: Springs, schemes: Schemes, steps_per_period: RisingCounts, periods: RisingCounts) -> xr.Dataset:
    """Measure the errors of every scheme against the exact solution, by step size and length of the run.

    :mod:`study.analysis.comparison` defines the measures. The step size is Δt = T/N, with T the exact period and
    N the number of steps per period. Each measure has the shape (problem, scheme, steps_per_period, periods).

    Raises
    ------
    FileNotFoundError
        If the reference of a problem has not been made.
    ValueError
        If a reference does not contain the phases of a number of steps per period.
    """
    motions = [(problems_by_name[problem], io.open_dataset(f"reference/{problem}")) for problem in problems]
    dims = ("problem", "scheme", "steps_per_period", "periods")
    shape = (len(motions), len(schemes), len(steps_per_period), len(periods))
    measured: dict[str, np.ndarray] = {}
    attributes: dict[str, dict] = {"status": STATUS_ATTRIBUTES, "failed_at_step": FAILED_AT_STEP_ATTRIBUTES}
    for p, (problem, reference) in enumerate(motions):
        compared = [against(reference, steps, max(steps_per_period)) for steps in steps_per_period]
        for s, scheme in enumerate(schemes):
            progress(f"accuracy of {scheme} on {problem.title}")
            for k, (steps, (dt, observers)) in enumerate(zip(steps_per_period, compared, strict=True)):
                observe = [*observers, MaxEnergyError(), EnergyDrift(), NewtonIterations(), Evaluations()]
                for n, length in enumerate(periods):
                    ds = sweep(problem, scheme, dt=dt, steps=steps * length, observe=observe)
                    for name, value in ds.data_vars.items():
                        measured.setdefault(str(name), np.empty(shape, value.dtype))[p, s, k, n] = value
                        attributes[str(name)] = value.attrs
    known = [[uncertainties(reference, length) for length in periods] for _, reference in motions]
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
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
            "measure": ("measure", measures, {"long_name": "measure of error, a variable of this dataset"}),
            "measure_title": (
                "measure",
                [attributes[measure]["long_name"] for measure in measures],
                {"long_name": "description of the measure"},
            ),
        },
        attrs={"title": "Accuracy of the schemes against the exact solution"},
    )
