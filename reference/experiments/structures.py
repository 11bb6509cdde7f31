"""Reference solutions of the structures by closed forms, diffrax and CVODE, with their uncertainty."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from reference import closed_form, diffrax, sundials
from reference.solution import History
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Structure
from study.problem.named import problems as problems_by_name
from study.problem.named import time_scales

#: Limit of the number of steps; a stiff mode needs about ten steps in each of its short periods.
MAX_STEPS = 10_000_000


def _spread(first: History, second: History) -> np.ndarray:
    """Largest absolute difference between two histories over the unknowns, (t,)."""
    return np.abs(first - second).reshape(len(first), -1).max(axis=1)


def _options(configuration: Mapping) -> Options:
    return configuration["structures"]


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each structure."""
    shared = {key: options[key] for key in ("samples_per_period", "rtol")}
    return {length["problem"]: {**length, **shared} for length in options["lengths"]}


@experiment("reference", section="structures", options=_options, split=_jobs)
def structure_reference(problem: Structure, periods: float, samples_per_period: int, rtol: float) -> xr.Dataset:
    """Compute the reference motion of a structure by the best route, with its difference from the next best.

    The routes, best first, are a closed form if one is known, diffrax's Dopri8 and CVODE's Adams method. No two routes
    share the method or the control of the step, so the digits on which they agree are reliable. Displacement and
    velocity have the shape (t, unknown), or (t,) for one unknown.

    Parameters
    ----------
    periods
        Length in time scales of the structure (``study.problem.named.time_scales``).
    samples_per_period
        Samples in a time scale.
    rtol
        Relative tolerance of the solvers.

    Raises
    ------
    RouteFailed
        If a solver reaches its limit of steps or stops early for another reason.
    """
    definition, scale = problems_by_name[problem], time_scales[problem]
    t = np.arange(1, round(periods * samples_per_period) + 1) * scale / samples_per_period
    routes = {
        "diffrax Dopri8": lambda: diffrax.trajectory(definition, t, rtol, "Dopri8", MAX_STEPS)[:2],
        "CVODE Adams": lambda: sundials.trajectory(definition, t, rtol, "Adams", MAX_STEPS)[:2],
    }
    if problem in closed_form.STRUCTURE_TRAJECTORIES:
        routes = {"closed form": lambda: closed_form.structure_trajectory(problem, definition, t), **routes}
    best, witness, *_ = routes
    progress(f"reference of {problem}: {best}, {witness}")
    (u, v), (u_of_witness, v_of_witness) = routes[best](), routes[witness]()
    unknown = ("unknown",) if np.ndim(definition.u0) else ()
    return xr.Dataset(
        {
            "u": (("t", *unknown), u, {"long_name": "displacement", "units": "1"}),
            "v": (("t", *unknown), v, {"long_name": "velocity", "units": "s-1"}),
            "u_uncertainty": (
                "t",
                _spread(u, u_of_witness),
                {"long_name": "largest difference of the displacement from the witness", "units": "1"},
            ),
            "v_uncertainty": (
                "t",
                _spread(v, v_of_witness),
                {"long_name": "largest difference of the velocity from the witness", "units": "s-1"},
            ),
            "period": ((), scale, {"long_name": "time by which steps are counted", "units": "s"}),
        },
        coords={"t": ("t", t, {"long_name": "elapsed time", "units": "s"})},
        attrs={
            "title": f"Reference solution of the {definition.title}",
            "problem": problem,
            "route": best,
            "witness": witness,
            "samples_per_period": samples_per_period,
            "rtol": rtol,
        },
    )
