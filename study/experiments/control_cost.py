"""Force evaluations for a given error with controlled and with equal steps, on kinked, shaken and stiff problems."""

import numpy as np
import xarray as xr

from study.control.estimators import Estimator
from study.control.named import estimators
from study.declaration.experiment import experiment, progress
from study.declaration.options import ControllerName, FallingTolerances, RisingCounts, Sampled, Schemes
from study.declaration.samples import Known, check, jobs, known, reference_of
from study.experiments import coordinates
from study.io import flags
from study.marching.adaptive_run import ENDS
from study.marching.control import usual_estimator
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.problem.named import problems as problems_by_name
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name

#: Largest number of steps of a controlled run, as a multiple of the largest number of equal steps.
MOST = 4

#: Outcomes of a run; ``not_run`` marks a scheme that does not fit the problem or, with controlled steps, needs equal
#: steps.
STATUSES = (*ENDS, "not_run")
NOT_RUN = STATUSES.index("not_run")


@experiment(
    "control_cost",
    split=jobs,
    along="problem",
    reads=lambda options: [reference_of(problem) for problem in options["problems"]],
    check=check,
)
def control_cost(
    problems: Sampled,
    schemes: Schemes,
    controller: ControllerName,
    tolerances: FallingTolerances,
    steps_per_sample: RisingCounts,
) -> xr.Dataset:
    """Measure error and force evaluations of runs with controlled and with equal steps.

    In all runs, steps end at the samples of the exact motion. ``samples_per_period`` of the sections ``kinks`` and
    ``structures`` is the number of samples in a period. The error is the largest distance from the samples, relative
    to the largest displacement. The number of force evaluations of a controlled run includes all its trial steps and
    the estimates, but not the trial run that measures the sizes of the motion if one of them is zero at the start. The
    estimator is the default estimator of the scheme.

    Results of controlled runs have the shape (problem, scheme, tolerance), and results with equal steps the shape
    (problem, scheme, steps_per_sample).
    """
    shape = len(problems), len(schemes)
    controlled = {
        name: np.full((*shape, len(tolerances)), np.nan) for name in ("error", "force_evaluations", "steps", "rejected")
    }
    equal = {name: np.full((*shape, len(steps_per_sample)), np.nan) for name in ("error", "force_evaluations")}
    for results in (controlled, equal):
        results["status"] = np.full(results["error"].shape, NOT_RUN, np.int8)
    uncertainty, used = np.empty(len(problems)), np.full(shape, "", object)
    for p, problem in enumerate(problems):
        exact, definition = known(problem), problems_by_name[problem]
        uncertainty[p] = exact.uncertainty
        for s, name in enumerate(schemes):
            scheme = schemes_by_name[name]
            if scheme.refusal(definition):
                continue
            progress(f"control of {name} on {problem}")
            runs = [(equal, k, _equal(definition, scheme, exact, parts)) for k, parts in enumerate(steps_per_sample)]
            if not scheme.needs_equal_steps:
                estimator = estimators[usual_estimator(scheme, definition)]
                used[p, s] = estimator.title
                most = MOST * max(steps_per_sample) * len(exact.t)
                for k, tolerance in enumerate(tolerances):
                    values = _controlled(definition, scheme, exact, tolerance, estimator, controller, most)
                    runs.append((controlled, k, values))
            for arrays, k, values in runs:
                for variable, value in values.items():
                    arrays[variable][p, s, k] = value
    dims, equal_dims = ("problem", "scheme", "tolerance"), ("problem", "scheme", "steps_per_sample")
    error = {"long_name": "largest error of the displacement at the samples over its size", "units": "1"}
    forces = {"long_name": "evaluations of the internal force", "units": "1"}
    return xr.Dataset(
        {
            "sampled_error": (dims, controlled["error"], error),
            "force_evaluations": (dims, controlled["force_evaluations"], forces),
            "steps": (dims, controlled["steps"], {"long_name": "number of steps", "units": "1"}),
            "rejected": (dims, controlled["rejected"], {"long_name": "trial steps that were rejected", "units": "1"}),
            "status": (dims, controlled["status"], flags("how the run ended", STATUSES, np.int8)),
            "equal_sampled_error": (equal_dims, equal["error"], error | {"comment": "with equal steps"}),
            "equal_force_evaluations": (
                equal_dims,
                equal["force_evaluations"],
                forces | {"comment": "with equal steps"},
            ),
            "equal_status": (equal_dims, equal["status"], flags("how the run ended", STATUSES, np.int8)),
            "estimator_title": (dims[:2], used.astype(str), {"long_name": "estimator of the error of a step"}),
            "uncertainty": (
                "problem",
                uncertainty,
                {"long_name": "uncertainty of the exact motion over the largest displacement", "units": "1"},
            ),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            "tolerance": ("tolerance", list(tolerances), {"long_name": "tolerance", "units": "1"}),
            "steps_per_sample": (
                "steps_per_sample",
                list(steps_per_sample),
                {"long_name": "equal steps between two samples", "units": "1"},
            ),
        },
        attrs={"title": "Number of forces for an error with controlled and with equal steps", "controller": controller},
    )


#: Observers of every run.
OBSERVED = ["trajectory", "effort"]


def _equal(problem: Problem, scheme: Scheme, exact: Known, parts: int) -> dict[str, float]:
    """Error, number of force evaluations, and status of a run with ``parts`` equal steps between two samples."""
    steps = parts * len(exact.t)
    ds = sweep(problem, scheme, dt=exact.t[-1] / steps, steps=steps, every=parts, observe=OBSERVED)
    return {
        "error": exact.error(ds.u.values[1:]),
        "force_evaluations": ds.force_evaluations.item(),
        "status": ds.status.item(),
    }


def _controlled(
    problem: Problem,
    scheme: Scheme,
    exact: Known,
    tolerance: float,
    estimator: Estimator,
    controller: str,
    most: int,
) -> dict[str, float]:
    """Error, numbers of force evaluations, steps and rejected steps, and status of a run with controlled steps."""
    ds = sweep(
        problem,
        scheme,
        tolerance=tolerance,
        duration=exact.t[-1],
        estimator=estimator,
        controller=controller,
        times=exact.t,
        steps=most,
        observe=OBSERVED,
    )
    steps, rejected = ds.steps.item(), (ds.steps_rejected_by_estimate + ds.steps_rejected_by_solver).item()
    completed = ds.status == ENDS.index("completed")
    return {
        "error": exact.error(ds.u.sel(t=exact.t, method="nearest").values) if completed else np.nan,
        "force_evaluations": ds.force_evaluations.item(),
        "steps": steps,
        "rejected": rejected,
        "status": ds.status.item(),
    }
