"""What the paper could not measure: trajectory, phase, period and amplitude of every scheme against the truth."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study import datasets
from study.command import main, progress
from study.comparison import against
from study.experiments import labels
from study.observers import EnergyDrift, MaxEnergyError
from study.runs import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES, run

#: An error this many times the reference's uncertainty or less says as much of the reference as of the scheme.
FLAGGED_WITHIN = 10


def accuracy(
    problems: Sequence[str], schemes: Sequence[str], steps_per_period: Sequence[int], periods: int
) -> xr.Dataset:
    """Every measure of error of every scheme on every problem at every number of steps per exact period."""
    dims = ("problem", "scheme", "steps_per_period")
    measured: dict[str, np.ndarray] = {}
    attributes: dict[str, dict] = {"status": STATUS_ATTRIBUTES, "failed_at_step": FAILED_AT_STEP_ATTRIBUTES}
    uncertainty = np.empty(len(problems))
    for p, problem in enumerate(problems):
        reference = datasets.open(f"reference/{problem}")
        uncertainty[p] = (reference.u_uncertainty / abs(reference.u).max()).item()
        for s, scheme in enumerate(schemes):
            progress(f"accuracy of {scheme} on {problem}")
            for k, steps in enumerate(steps_per_period):
                dt, observers = against(reference, steps, max(steps_per_period))
                observe = [*observers, MaxEnergyError(), EnergyDrift()]
                ds = run(problem, scheme, dt=dt, steps=steps * periods, observe=observe)
                for name, value in ds.data_vars.items():
                    shape = (len(problems), len(schemes), len(steps_per_period))
                    measured.setdefault(str(name), np.empty(shape, value.dtype))[p, s, k] = value
                    attributes[str(name)] = value.attrs
    flagged = measured["max_trajectory_error"] <= FLAGGED_WITHIN * uncertainty[:, None, None]
    return xr.Dataset(
        {name: (dims, values, attributes[name]) for name, values in measured.items()}
        | {
            "flagged": (
                dims,
                flagged.astype(np.int32),
                {
                    "long_name": f"trajectory error within {FLAGGED_WITHIN} times the uncertainty of the reference",
                    "flag_values": np.arange(2, dtype=np.int32),
                    "flag_meanings": "above within",
                },
            ),
            "reference_uncertainty": (
                "problem",
                uncertainty,
                {"long_name": "uncertainty of the exact displacement, relative to its largest size", "units": "1"},
            ),
        },
        coords={
            **labels.problem_coordinates(problems),
            **labels.scheme_coordinates(schemes),
            **labels.steps_per_period_coordinate(steps_per_period),
        },
        attrs={"title": f"Accuracy of the schemes over {periods} periods against the exact solution"},
    )


if __name__ == "__main__":
    main(accuracy)
