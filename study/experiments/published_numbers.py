"""Errors of schemes at known displacements, which are printed in sources or exact."""

from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Ge, Le, Len
from typing_extensions import TypedDict

from study.declaration.experiment import experiment, progress
from study.declaration.options import Count, FallingTolerances, KnownProblem, Schemes, section
from study.experiments import coordinates
from study.io import flags
from study.marching.result import STATUSES_OR_NOT_RUN
from study.marching.run import sweep
from study.problem.named import known, problems
from study.problem.naming import Known
from study.scheme.named import schemes as schemes_by_name

#: Factor between the numbers of steps of successive runs.
FINER = 4


@section
class _Coarsest(TypedDict):
    problem: KnownProblem
    steps: Count


def _error(at: Known, u: np.ndarray) -> float:
    """Error of the displacement relative to the norm of the known displacement."""
    displacement = u if at.weights is None else at.weights @ u
    return float(np.linalg.norm(displacement - at.u) / np.linalg.norm(at.u))


def _equal(problem: str, scheme: str, steps: int) -> tuple[float, int]:
    """Error and status of a run with equal steps."""
    at = known[problem]
    ds = sweep(problem, scheme, dt=at.time / steps, steps=steps, every=steps)
    return _error(at, ds.u.values[-1]), ds.status.item()


def _controlled(problem: str, scheme: str, tolerance: float) -> tuple[float, float]:
    """Error of a run with controlled steps, and the number of its steps; both are NaN if the run failed."""
    at = known[problem]
    ds = sweep(problem, scheme, tolerance=tolerance, duration=at.time)
    return (_error(at, ds.u.values[-1]), ds.steps.item()) if ds.status == 0 else (np.nan, np.nan)


@experiment("published_numbers")
def published_numbers(
    coarsest: Annotated[list[_Coarsest], Len(1, 100)],
    refinements: Annotated[int, Ge(2), Le(10)],
    schemes: Schemes,
    controlled: Annotated[list[KnownProblem], Len(1, 100)],
    tolerances: FallingTolerances,
) -> xr.Dataset:
    """Compute the errors of schemes at known displacements, which are printed in sources or exact.

    The error is |u − u_known| / |u_known| at the time of ``study.problem.named.known``, with Euclidean norms. It is NaN
    if the run failed or the scheme refuses the problem.

    Parameters
    ----------
    coarsest
        Problems, each with the number of steps of its coarsest run.
    refinements
        Number of runs of each scheme and problem, each with four times as many steps as the run before.
    controlled, tolerances
        Problems that are also run with the default step control of ``study.run``, and its tolerances.

    Returns
    -------
    xarray.Dataset
        Errors and statuses with equal steps have the shape (problem, scheme, refinement), variables with controlled
        steps (problem, scheme, tolerance). Variables with controlled steps are NaN for problems that are not
        ``controlled``, and for schemes that need equal steps.
    """
    names = [case["problem"] for case in coarsest]
    steps = np.array([case["steps"] for case in coarsest])[:, None] * FINER ** np.arange(refinements)
    error = np.full((len(names), len(schemes), refinements), np.nan)
    status = np.full(error.shape, STATUSES_OR_NOT_RUN.index("not_run"), np.int8)
    for (p, s, k), _ in np.ndenumerate(error):
        if k == 0:
            progress(f"{schemes[s]} on {names[p]}")
        if not schemes_by_name[schemes[s]].refusal(problems[names[p]]):
            error[p, s, k], status[p, s, k] = _equal(names[p], schemes[s], int(steps[p, k]))
    control = np.full((2, len(names), len(schemes), len(tolerances)), np.nan)
    for (p, s, k), _ in np.ndenumerate(control[0]):
        scheme = schemes_by_name[schemes[s]]
        if names[p] in controlled and not (scheme.needs_equal_steps or scheme.refusal(problems[names[p]])):
            control[:, p, s, k] = _controlled(names[p], schemes[s], tolerances[k])
    dims, control_dims = ("problem", "scheme", "refinement"), ("problem", "scheme", "tolerance")
    points = [known[name] for name in names]
    return xr.Dataset(
        {
            "end_error": (
                dims,
                error,
                {"long_name": "Euclidean error of the displacement at the end over its size", "units": "1"},
            ),
            "status": (dims, status, flags("how the run ended", STATUSES_OR_NOT_RUN, np.int8)),
            "steps": (("problem", "refinement"), steps, {"long_name": "number of steps", "units": "1"}),
            "controlled_end_error": (
                control_dims,
                control[0],
                {"long_name": "error with controlled steps", "units": "1"},
            ),
            "controlled_steps": (control_dims, control[1], {"long_name": "number of controlled steps", "units": "1"}),
            "duration": (
                "problem",
                [point.time for point in points],
                {"long_name": "time of the displacement", "units": "s"},
            ),
        },
        coords={
            **coordinates.problem_coordinates(names),
            **coordinates.scheme_coordinates(schemes),
            "tolerance": ("tolerance", list(tolerances), {"long_name": "tolerance of the control", "units": "1"}),
            "known_from": ("problem", [point.source for point in points], {"long_name": "source of the displacement"}),
        },
        attrs={"title": "Errors at displacements that sources print or that are exact"},
    )
