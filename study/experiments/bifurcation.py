"""From order to chaos over the step size: where a scheme's iterates settle, and how fast neighbours part."""

import numpy as np
import xarray as xr

from study.marching.result import COMPLETED, FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import run
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Count, Numbers, RecordedSteps, SchemeName, Spring, Tolerance
from study.problem.named import problems

#: Distance at which a perturbation counts as of order one.
ORDER_ONE = 0.1


def _shown(o, c) -> str | None:
    if o["shown"] > o["steps"]:
        return f"shown, {o['shown']}, are more than the steps, {o['steps']}."
    if o["dt"]["first"] <= 0:
        return f"dt: first must be greater than zero, not {o['dt']['first']}."
    return None


@experiment(
    "stability/bifurcation",
    check=_shown,
    steps=lambda o, c: 4 * o["dt"]["count"] * o["steps"],
    values=lambda o, c: 6 * o["dt"]["count"] * o["steps"],
)
def bifurcation(
    problem: Spring, scheme: SchemeName, dt: Numbers, steps: RecordedSteps, shown: Count, perturbation: Tolerance
) -> xr.Dataset:
    """The last displacements, the Lyapunov exponent, and the steps until two neighbours are apart, over step sizes.

    Of a run that fails, what there was before it did.

    Parameters
    ----------
    dt
        ``first``, ``last`` and ``count`` of the step sizes.
    steps, shown
        Length of the runs, and how many of the last displacements are kept.
    perturbation
        By how much the initial displacement of a second run differs.
    """
    progress(f"bifurcation diagram of {scheme} on {problem}")
    step_sizes = np.linspace(dt["first"], dt["last"], int(dt["count"]))
    u0 = float(problems[problem].u0)
    pairs = run(
        problem,
        scheme,
        dt=np.repeat(step_sizes, 2),
        u0=np.tile([u0, u0 + perturbation], len(step_sizes)),
        steps=steps,
    )
    one, other = pairs.u.values.reshape(len(step_sizes), 2, -1).transpose(1, 0, 2)
    apart = np.abs(other - one) >= ORDER_ONE  # not where a run has failed and has no displacement
    status, failed_at_step = (pairs[name].values[::2] for name in ("status", "failed_at_step"))
    whole = np.full(len(step_sizes), steps)
    # in chaos another program may fail at another step than that of the pairs: so by itself
    growth = run(problem, scheme, dt=step_sizes, steps=whole, observe=["lyapunov_exponent"])
    lasted = np.where(growth.status == COMPLETED, whole, np.maximum(growth.failed_at_step - 1, 1))
    growth = run(problem, scheme, dt=step_sizes, steps=lasted, observe=["lyapunov_exponent"])
    last = np.where(status == COMPLETED, steps, failed_at_step - 1)
    places = last[:, None] + np.arange(1 - shown, 1)
    shown_u = np.where(places < 0, np.nan, np.take_along_axis(one, np.maximum(places, 0), axis=1))
    return xr.Dataset(
        {
            "u": (
                ("dt", "iterate"),
                shown_u.astype(np.float32),
                {"long_name": "displacement", "units": "1"},
            ),
            "lyapunov_exponent": ("dt", growth.lyapunov_exponent.values, growth.lyapunov_exponent.attrs),
            "steps_until_apart": (
                "dt",
                np.where(apart.any(axis=1), apart.argmax(axis=1), -1),
                {
                    "long_name": f"steps until a perturbation of {perturbation:g} has become {ORDER_ONE}, -1 if never",
                    "units": "1",
                },
            ),
            "perturbation": ((), perturbation, {"long_name": "initial distance of two runs", "units": "1"}),
            "order_one": ((), ORDER_ONE, {"long_name": "distance that counts as of order one", "units": "1"}),
            "status": ("dt", status, STATUS_ATTRIBUTES),
            "failed_at_step": ("dt", failed_at_step, FAILED_AT_STEP_ATTRIBUTES),
            "steps": ((), steps, {"long_name": "steps of a run that does not fail", "units": "1"}),
        },
        coords={
            "dt": ("dt", step_sizes, {"long_name": "step size", "units": "s"}),
            "iterate": (
                "iterate",
                np.arange(1 - shown, 1),
                {"long_name": "steps after the last one of the run", "units": "1"},
            ),
        },
        attrs={
            "title": f"Iterates of {scheme} on the {problems[problem].title} over the step size",
            "problem": problem,
            "scheme": scheme,
        },
    )
