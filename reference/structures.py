"""References of the structures: closed forms, diffrax and CVODE, and how far the best two differ as the error bar."""

import numpy as np
import xarray as xr

from reference import closed_form, diffrax, sundials
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.problem.named import problems, time_scales

#: A stiff mode takes ten steps of a method of order eight in each of its own short periods.
MAX_STEPS = 10_000_000


def _spread(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Largest difference of any unknown, by time."""
    return np.abs(one - other).reshape(len(one), -1).max(axis=1)


def _jobs(o) -> dict[str, dict]:
    shared = {key: o[key] for key in ("samples_per_period", "rtol")}
    return {one["problem"]: {**one, **shared} for one in o["lengths"]}


@experiment("reference", section="structures", options=lambda c: c["structures"], split=_jobs)
def structure(problem: str, periods: float, samples_per_period: int, rtol: float) -> xr.Dataset:
    """Displacement and velocity of every unknown by the best route that there is, with the difference of the next.

    A closed form is better than diffrax's Dopri8, which is better than CVODE's Adams. No two of them share method, code
    or control of the step, so that they agree as far as both are right.
    """
    definition, scale = problems[problem], time_scales[problem]
    t = np.arange(1, round(periods * samples_per_period) + 1) * scale / samples_per_period
    routes = {
        "diffrax Dopri8": lambda: diffrax.trajectory(definition, t, rtol, "Dopri8", MAX_STEPS)[:2],
        "CVODE Adams": lambda: sundials.trajectory(definition, t, rtol, "Adams", MAX_STEPS)[:2],
    }
    if problem in closed_form.STRUCTURES:
        routes = {"closed form": lambda: closed_form.structure(problem, definition, t), **routes}
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
