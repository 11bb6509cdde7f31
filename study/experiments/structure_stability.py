"""Structures that are stiff or chaotic: what becomes of runs, and of neighbours, at growing step sizes."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study.command import main, progress
from study.experiments import labels
from study.problems import periods as time_scales
from study.problems import problems as registry
from study.runs import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES, run


def structure_stability(lengths: Sequence[dict], schemes: Sequence[str], steps_per_period: Sequence[int]) -> xr.Dataset:
    """Lyapunov exponent of the numerical map, and error of the balance of energies, by structure and step size.

    Parameters
    ----------
    lengths
        ``problem`` and ``periods`` of each structure: the length of its runs in its time scale.
    steps_per_period
        Steps in the time scale of the structure (``study.problems.periods``).
    """
    names = [one["problem"] for one in lengths]
    shape = (len(names), len(schemes), len(steps_per_period))
    exponent, imbalance = np.empty(shape), np.empty(shape)
    status, failed_at_step = np.zeros(shape, np.int32), np.empty(shape, int)
    for p, one in enumerate(lengths):
        scale, problem = time_scales[one["problem"]], registry[one["problem"]]
        for s, scheme in enumerate(schemes):
            progress(f"stability of {scheme} on {one['problem']}")
            for k, parts in enumerate(steps_per_period):
                ds = run(
                    problem,
                    scheme,
                    dt=scale / parts,
                    steps=round(one["periods"] * parts),
                    observe=["lyapunov_exponent", "energy_balance"],
                )
                at = p, s, k
                exponent[at], imbalance[at] = ds.lyapunov_exponent * scale, ds.max_energy_imbalance
                status[at], failed_at_step[at] = ds.status, ds.failed_at_step
    dims = ("problem", "scheme", "steps_per_period")
    return xr.Dataset(
        {
            "lyapunov_exponent": (
                dims,
                exponent,
                {"long_name": "largest Lyapunov exponent of the numerical map, in a time scale", "units": "1"},
            ),
            "max_energy_imbalance": (
                dims,
                imbalance,
                {"long_name": "largest error of the balance of energies, dissipation and work", "units": "percent"},
            ),
            "status": (dims, status, STATUS_ATTRIBUTES),
            "failed_at_step": (dims, failed_at_step, FAILED_AT_STEP_ATTRIBUTES),
        },
        coords={
            **labels.problem_coordinates(names),
            **labels.scheme_coordinates(schemes),
            **labels.steps_per_period_coordinate(steps_per_period),
            "periods": ("problem", [one["periods"] for one in lengths], {"long_name": "length of runs", "units": "1"}),
        },
        attrs={"title": "Lyapunov exponents of the schemes on structures that are stiff or chaotic"},
    )


if __name__ == "__main__":
    main(structure_stability)
