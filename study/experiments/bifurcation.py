"""Bifurcation diagram over the step size: last iterates of a scheme, and divergence of neighbours."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, RecordedSteps, SchemeName, Spring, StepSizes, Tolerance
from study.marching.result import COMPLETED, FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.problem.named import problems as problems_by_name

#: Smallest distance of two runs that counts as of order one.
ORDER_ONE = 0.1


def _check(options: Options, configuration: Mapping) -> str | None:
    if options["shown"] > options["steps"]:
        return f"shown must be at most the number of steps, {options['steps']}, not {options['shown']}."
    return None


@experiment("stability/bifurcation", check=_check)
def bifurcation(
    problem: Spring, scheme: SchemeName, dt: StepSizes, steps: RecordedSteps, shown: Count, perturbation: Tolerance
) -> xr.Dataset:
    """Compute last displacements, Lyapunov exponent and number of steps until neighbours diverge, over step sizes.

    A run that fails is evaluated up to the step before it failed.

    Parameters
    ----------
    dt
        ``first``, ``last`` and ``count`` of the step sizes in seconds.
    steps
        Number of steps of a run.
    shown
        Number of last displacements of a run that are kept.
    perturbation
        Difference between the initial displacements of two neighbouring runs.

    Returns
    -------
    xarray.Dataset
        ``u`` has the shape (dt, iterate), the other variables (dt,), except the scalars ``perturbation``, ``order_one``
        and ``steps``.
    """
    progress(f"bifurcation diagram of {scheme} on {problem}")
    step_sizes = np.linspace(dt["first"], dt["last"], int(dt["count"]))
    u0 = float(problems_by_name[problem].u0)
    pairs = sweep(
        problem,
        scheme,
        dt=np.repeat(step_sizes, 2),
        u0=np.tile([u0, u0 + perturbation], len(step_sizes)),
        steps=steps,
    )
    first, second = pairs.u.values.reshape(len(step_sizes), 2, -1).transpose(1, 0, 2)
    apart = np.abs(second - first) >= ORDER_ONE  # false after a failure, because the displacement is then NaN
    status, failed_at_step = (pairs[name].values[::2] for name in ("status", "failed_at_step"))
    whole = np.full(len(step_sizes), steps)
    # a chaotic run for the exponent may fail at another step than the pair of runs, so it is repeated up to the step
    # before its own failure
    growth = sweep(problem, scheme, dt=step_sizes, steps=whole, observe=["lyapunov_exponent"])
    lasted = np.where(growth.status == COMPLETED, whole, np.maximum(growth.failed_at_step - 1, 1))
    growth = sweep(problem, scheme, dt=step_sizes, steps=lasted, observe=["lyapunov_exponent"])
    last = np.where(status == COMPLETED, steps, failed_at_step - 1)
    places = last[:, None] + np.arange(1 - shown, 1)
    shown_u = np.where(places < 0, np.nan, np.take_along_axis(first, np.maximum(places, 0), axis=1))
    return xr.Dataset(
        {
            "u": (
                ("step_size", "iterate"),
                shown_u.astype(np.float32),
                {"long_name": "displacement", "units": "1"},
            ),
            "lyapunov_exponent": ("step_size", growth.lyapunov_exponent.values, growth.lyapunov_exponent.attrs),
            "steps_until_apart": (
                "step_size",
                np.where(apart.any(axis=1), apart.argmax(axis=1), -1),
                {
                    "long_name": f"steps until a perturbation of {perturbation:g} grows to {ORDER_ONE}, -1 if never",
                    "units": "1",
                },
            ),
            "perturbation": ((), perturbation, {"long_name": "initial distance of two runs", "units": "1"}),
            "order_one": ((), ORDER_ONE, {"long_name": "distance that counts as of order one", "units": "1"}),
            "newton_restarts": ("step_size", pairs.newton_restarts.values[::2], pairs.newton_restarts.attrs),
            "status": ("step_size", status, STATUS_ATTRIBUTES),
            "failed_at_step": ("step_size", failed_at_step, FAILED_AT_STEP_ATTRIBUTES),
            "steps": ((), steps, {"long_name": "steps of a run that does not fail", "units": "1"}),
        },
        coords={
            "step_size": ("step_size", step_sizes, {"long_name": "step size", "units": "s"}),
            "iterate": (
                "iterate",
                np.arange(1 - shown, 1),
                {"long_name": "number of the step, counted from the last step of the run", "units": "1"},
            ),
        },
        attrs={
            "title": f"Iterates of {scheme} on the {problems_by_name[problem].title} over the step size",
            "problem": problem,
            "scheme": scheme,
        },
    )
