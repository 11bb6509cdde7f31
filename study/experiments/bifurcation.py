"""From order to chaos over the step size: where a scheme's iterates settle, and how fast neighbours part."""

import numpy as np
import xarray as xr

from study.command import main, progress
from study.problems import problems
from study.runs import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES, run

#: Distance at which a perturbation counts as of order one.
ORDER_ONE = 0.1


def bifurcation(
    problem: str, scheme: str, dt: dict[str, float], steps: int, shown: int, perturbation: float
) -> xr.Dataset:
    """The last displacements, the Lyapunov exponent, and the steps until two neighbours are apart, over step sizes.

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
    one, other = (
        run(
            problem,
            scheme,
            dt=np.repeat(step_sizes, 2),
            u0=np.tile([u0, u0 + perturbation], len(step_sizes)),
            steps=steps,
        )
        .u.values.reshape(len(step_sizes), 2, -1)
        .transpose(1, 0, 2)
    )
    apart = np.abs(other - one) >= ORDER_ONE  # not where a run has failed and has no displacement
    growth = run(problem, scheme, dt=step_sizes, steps=steps, observe=["lyapunov_exponent"])
    return xr.Dataset(
        {
            "u": (
                ("dt", "iterate"),
                one[:, -shown:].astype(np.float32),
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
            "status": ("dt", growth.status.values, STATUS_ATTRIBUTES),
            "failed_at_step": ("dt", growth.failed_at_step.values, FAILED_AT_STEP_ATTRIBUTES),
        },
        coords={
            "dt": ("dt", step_sizes, {"long_name": "step size", "units": "s"}),
            "iterate": (
                "iterate",
                np.arange(steps + 1)[-shown:],
                {"long_name": "steps taken", "units": "1"},
            ),
        },
        attrs={
            "title": f"Iterates of {scheme} on the {problems[problem].title} over the step size",
            "problem": problem,
            "scheme": scheme,
        },
    )


if __name__ == "__main__":
    main(bifurcation)
