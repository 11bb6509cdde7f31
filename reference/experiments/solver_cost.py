"""Force evaluations that general solvers need for a given error, on the problems of ``control_cost``."""

from typing import Annotated, Literal

import numpy as np
import xarray as xr
from annotated_types import Len

from reference.experiments.work_precision import SOLVERS
from reference.solution import RouteFailed
from study.declaration.experiment import experiment, progress
from study.declaration.options import FallingTolerances, Sampled
from study.declaration.samples import check, jobs, known, reference_of
from study.problem.named import problems as problems_by_name

Solver = Literal["cvode_adams", "cvode_bdf", "dopri8", "tsit5", "kvaerno5"]


@experiment(
    "solver_cost",
    split=jobs,
    along="problem",
    reads=lambda options: [reference_of(problem) for problem in options["problems"]],
    check=check,
)
def solver_cost(
    problems: Sampled, solvers: Annotated[list[Solver], Len(1, 5)], tolerances: FallingTolerances
) -> xr.Dataset:
    """Measure error and force evaluations of CVODE, with Adams or BDF methods, and of diffrax with its PID controller.

    The error is defined as in the dataset ``control_cost``, at the same samples of the exact motion. Error and number
    of force evaluations are NaN if a solver fails. They are also NaN for a force with a history, because a solver needs
    a force that is a function of time and state. For ``kvaerno5`` the stages are counted, each of which evaluates the
    force several times.

    Variables have the shape (problem, solver, tolerance).
    """
    shape = len(problems), len(solvers), len(tolerances)
    error, forces = np.full(shape, np.nan), np.full(shape, np.nan)
    for p, problem in enumerate(problems):
        exact, definition = known(problem), problems_by_name[problem]
        if definition.history is not None:
            continue
        for s, solver in enumerate(solvers):
            progress(f"{solver} on {problem}")
            for k, tolerance in enumerate(tolerances):
                try:
                    solution = SOLVERS[solver](definition, exact.t, tolerance)
                except RouteFailed as failure:
                    progress(str(failure))
                    continue
                error[p, s, k], forces[p, s, k] = exact.error(np.asarray(solution.u)), solution.evaluations
    dims = ("problem", "solver", "tolerance")
    return xr.Dataset(
        {
            "sampled_error": (
                dims,
                error,
                {"long_name": "largest error of the displacement at the samples over its size", "units": "1"},
            ),
            "force_evaluations": (dims, forces, {"long_name": "evaluations of the internal force", "units": "1"}),
        },
        coords={
            "problem": ("problem", list(problems), {"long_name": "problem"}),
            "solver": ("solver", list(solvers), {"long_name": "solver"}),
            "tolerance": ("tolerance", list(tolerances), {"long_name": "relative tolerance", "units": "1"}),
        },
        attrs={"title": "Number of forces for an error with general solvers"},
    )
