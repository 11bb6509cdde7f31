"""Forces that an error costs with controlled and with equal steps, on kinked, shaken and stiff problems."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study.control.named import estimators
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import ControllerName, FallingTolerances, RisingCounts, Sampled, Schemes
from study.declaration.samples import KINKED, Known, check, jobs, known, reference_of
from study.experiments import coordinates
from study.io import flags
from study.marching.adaptive_run import ENDS
from study.marching.control import usual_estimator
from study.marching.run import run
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name
from study.scheme.wrapper.with_history import WithHistory

#: Most steps of a controlled run, in those of the run with the most equal steps.
MOST = 4

#: How a run can end; a scheme that does not fit a problem has no run.
STATUSES = (*ENDS, "not_run")
NOT_RUN = STATUSES.index("not_run")


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    """Those of the runs with equal steps; those of the others are known afterwards."""
    lengths = {one["problem"]: one["periods"] for one in configuration["structures"]["lengths"]}
    samples = 0.0
    for problem in options["problems"]:
        name = "kinks" if problem in KINKED else "structures"
        periods = configuration["kinks"]["periods"] if problem in KINKED else lengths[problem]
        samples += periods * configuration[name]["samples_per_period"]
    return samples * len(options["schemes"]) * sum(options["steps_per_sample"])


@experiment(
    "control_cost",
    split=jobs,
    along="problem",
    reads=lambda options: [reference_of(problem) for problem in options["problems"]],
    check=check,
    steps=_number_of_steps,
)
def control_cost(
    problems: Sampled,
    schemes: Schemes,
    controller: ControllerName,
    tolerances: FallingTolerances,
    steps_per_sample: RisingCounts,
) -> xr.Dataset:
    """Measure error and forces of runs with controlled and with equal steps.

    All runs end steps at the samples of the exact motion, of which there are eight in a period of the problems of the
    section ``kinks`` and ten of a structure. The error is the largest distance there over the largest displacement.
    Forces of a controlled run are those of all its trial steps, of which each counts as many Newton iterations as the
    accepted ones have on average, and those of the estimate. The estimator is the usual one of the scheme.

    Variables have the shape (problem, scheme, tolerance), and of equal steps (problem, scheme, steps_per_sample).
    """
    shape = len(problems), len(schemes)
    controlled = {name: np.full((*shape, len(tolerances)), np.nan) for name in ("error", "forces", "steps", "rejected")}
    equal = {name: np.full((*shape, len(steps_per_sample)), np.nan) for name in ("error", "forces")}
    status = np.full((*shape, len(tolerances)), NOT_RUN, np.int8)
    equal_status = np.full((*shape, len(steps_per_sample)), NOT_RUN, np.int8)
    uncertainty = np.empty(len(problems))
    used = np.full(shape, "", object)
    for p, problem in enumerate(problems):
        exact, definition = known(problem), problems_by_name[problem]
        uncertainty[p] = exact.uncertainty
        for s, name in enumerate(schemes):
            scheme = schemes_by_name[name]
            if scheme.refusal(definition):
                continue
            progress(f"control of {name} on {problem}")
            marched = scheme if definition.history is None else WithHistory(scheme)
            for k, parts in enumerate(steps_per_sample):
                ds = _equal(problem, name, exact, parts)
                steps, at = parts * len(exact.t), (p, s, k)
                equal["error"][at], equal_status[at] = exact.error(ds.u.values[1:]), ds.status
                equal["forces"][at] = _forces(marched, marched.forces_per_step, ds, steps, steps)
            if scheme.needs_equal_steps:
                continue
            estimator = usual_estimator(marched, definition)
            used[p, s] = estimators[estimator].title
            for k, tolerance in enumerate(tolerances):
                ds = run(
                    problem,
                    name,
                    tolerance=tolerance,
                    duration=exact.t[-1],
                    estimator=estimator,
                    controller=controller,
                    times=exact.t,
                    steps=MOST * max(steps_per_sample) * len(exact.t),
                    observe=["trajectory", "newton_iterations"],
                    on_failure="ignore",
                )
                at = p, s, k
                status[at] = ds.status
                rejected = ds.steps_rejected_by_estimate.item() + ds.steps_rejected_by_solver.item()
                controlled["steps"][at], controlled["rejected"][at] = ds.steps, rejected
                if not status[at]:
                    controlled["error"][at] = exact.error(ds.u.sel(t=exact.t, method="nearest").values)
                of_step = estimators[estimator].forces_per_step(marched)
                controlled["forces"][at] = _forces(marched, of_step, ds, ds.steps.item(), ds.steps.item() + rejected)
    dims, of_equal = ("problem", "scheme", "tolerance"), ("problem", "scheme", "steps_per_sample")
    error = {"long_name": "largest error of the displacement over its size", "units": "1"}
    forces = {"long_name": "evaluations of the internal force", "units": "1"}
    return xr.Dataset(
        {
            "error": (dims, controlled["error"], error),
            "forces": (dims, controlled["forces"], forces),
            "steps": (dims, controlled["steps"], {"long_name": "number of steps", "units": "1"}),
            "rejected": (dims, controlled["rejected"], {"long_name": "trial steps that were rejected", "units": "1"}),
            "status": (dims, status, flags("how the run ended", STATUSES, np.int8)),
            "equal_error": (of_equal, equal["error"], error | {"comment": "with equal steps"}),
            "equal_forces": (of_equal, equal["forces"], forces | {"comment": "with equal steps"}),
            "equal_status": (of_equal, equal_status, flags("how the run ended", STATUSES, np.int8)),
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
        attrs={"title": "Forces that an error costs with controlled and with equal steps", "controller": controller},
    )


def _equal(problem: str, scheme: str, exact: Known, parts: int) -> xr.Dataset:
    return run(
        problem,
        scheme,
        dt=exact.t[-1] / len(exact.t) / parts,
        steps=parts * len(exact.t),
        every=parts,
        observe=["trajectory", "newton_iterations"],
        on_failure="ignore",
    )


def _forces(scheme, per_step: int, ds: xr.Dataset, steps: int, trials: int) -> float:
    """Forces of a run, of trial steps that each take as many iterations as the steps that were taken."""
    of_iterations = 0 if scheme.explicit else scheme.forces_per_iteration * ds.newton_iterations.item() / max(steps, 1)
    return trials * (per_step + of_iterations)
