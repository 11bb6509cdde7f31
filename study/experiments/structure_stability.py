"""Stability on stiff or chaotic structures: outcomes of runs and divergence of neighbouring runs, by step size."""

from collections.abc import Mapping
from itertools import product

import numpy as np
import xarray as xr

from study.analysis.outcomes import BALANCE_ATTRIBUTES, outcomes_of_balance
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Counts, Schemes, Sizes, StructureLengths
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.marching.stability import at_start, excess, has_limit
from study.mechanics.loads import excited
from study.problem.named import problems as problems_by_name
from study.problem.named import time_scales
from study.scheme.named import schemes as schemes_by_name

OBSERVED = ("lyapunov_exponent", "energy_balance", "newton_iterations")


def _check(options: Options, configuration: Mapping) -> str | None:
    for length in options["lengths"]:
        if length["periods"] * min(options["steps_per_period"]) < 2:
            return f"lengths: {length['periods']} periods of '{length['problem']}' are less than two steps."
    return None


@experiment(
    "stability/structures",
    split=lambda options: {one["problem"]: {**options, "lengths": [one]} for one in options["lengths"]},
    along="problem",
    check=_check,
)
def structure_stability(
    lengths: StructureLengths, schemes: Schemes, excitations: Sizes, steps_per_period: Counts
) -> xr.Dataset:
    """Find how the runs of every scheme on structures end, by excitation and step size.

    λ is the largest Lyapunov exponent of the numerical map, times the time scale. It is the mean over the second half
    of a run of N steps, (N λ_N − M λ_M)/(N − M) with M = ⌊N/2⌋.

    Parameters
    ----------
    lengths
        ``problem`` and ``periods`` of each structure: its name, and the length of its runs in time scales of the
        structure.
    excitations
        Factors of the initial velocity and of the load, including the load by ground motion.
    steps_per_period
        Steps in the time scale of the structure (``study.problem.named.time_scales``).

    Returns
    -------
    xarray.Dataset
        Variables of shape (problem, scheme, excitation, steps_per_period).
    """
    names = [one["problem"] for one in lengths]
    shape = (len(names), len(schemes), len(excitations), len(steps_per_period))
    exponent, imbalance, outcome = np.empty(shape), np.empty(shape), np.empty(shape, np.int8)
    status, failed_at_step, apart_at_step = np.zeros(shape, np.int32), np.empty(shape, int), np.empty(shape, int)
    iterations = np.empty(shape)
    for p, one in enumerate(lengths):
        scale, definition = time_scales[one["problem"]], problems_by_name[one["problem"]]
        excited_problems = [excited(definition, factor) for factor in excitations]
        for s, scheme in enumerate(schemes):
            progress(f"stability of {scheme} on {one['problem']}")
            for (e, problem), (k, parts) in product(enumerate(excited_problems), enumerate(steps_per_period)):
                steps, at = round(one["periods"] * parts), (p, s, e, k)
                half, whole = (
                    sweep(problem, scheme, dt=scale / parts, steps=n, observe=OBSERVED) for n in (steps // 2, steps)
                )
                # the first half is left out, because in it the perturbation turns towards the stiffest mode
                rate = (steps * whole.lyapunov_exponent - steps // 2 * half.lyapunov_exponent) / (steps - steps // 2)
                exponent[at], imbalance[at] = rate * scale, whole.max_energy_imbalance
                beyond = has_limit(schemes_by_name[scheme], problem) and bool(
                    excess(schemes_by_name[scheme], at_start(problem), scale / parts, steps)
                )
                outcome[at] = outcomes_of_balance(whole, exponent[at] * one["periods"], beyond)
                status[at], failed_at_step[at] = whole.status, whole.failed_at_step
                apart = whole.apart_from * parts / scale
                apart_at_step[at] = np.rint(apart) if np.isfinite(apart) else -1
                iterations[at] = whole.max_newton_iterations
    dims = ("problem", "scheme", "excitation", "steps_per_period")
    return xr.Dataset(
        {
            "outcome": (dims, outcome, BALANCE_ATTRIBUTES),
            "lyapunov_exponent": (
                dims,
                exponent,
                {
                    "long_name": "largest Lyapunov exponent over the second half of the run, times the time scale",
                    "units": "1",
                },
            ),
            "max_energy_imbalance": (
                dims,
                imbalance,
                {"long_name": "largest error of the balance of energies, dissipation and work", "units": "1"},
            ),
            "max_newton_iterations": (
                dims,
                iterations,
                {
                    "long_name": "most Newton iterations in one step, NaN where the run failed",
                    "units": "1",
                },
            ),
            "apart_at_step": (
                dims,
                apart_at_step,
                {"long_name": "step from which on a perturbation is 8.6e9 times as large, -1 if never", "units": "1"},
            ),
            "status": (dims, status, STATUS_ATTRIBUTES),
            "failed_at_step": (dims, failed_at_step, FAILED_AT_STEP_ATTRIBUTES),
        },
        coords={
            **coordinates.problem_coordinates(names),
            **coordinates.scheme_coordinates(schemes),
            "excitation": (
                "excitation",
                list(excitations),
                {"long_name": "initial velocity and load over the values of the problem", "units": "1"},
            ),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "periods": ("problem", [one["periods"] for one in lengths], {"long_name": "length of runs", "units": "1"}),
        },
        attrs={"title": "Outcomes of runs on structures that are stiff or chaotic, over excitation and step size"},
    )
