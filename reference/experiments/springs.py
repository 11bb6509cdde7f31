"""Exact period of each spring, and its motion over one period: the datasets ``reference/PROBLEM``."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Annotated

import heyoka as hy
import jax
import mpmath
import numpy as np
import xarray as xr
from annotated_types import Ge, Le, Len
from typing_extensions import TypedDict

from reference import closed_form, exact, taylor
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Spring, Springs, section
from study.mechanics.definition import Problem
from study.problem.named import approximate_periods
from study.problem.named import problems as problems_by_name

#: Number of samples of a trajectory that are compared with the closed form.
WITNESSED = 33


def phases(steps_per_period: Sequence[int]) -> list[Fraction]:
    """All fractions k/N of the period with 0 ≤ k ≤ N, for N in ``steps_per_period``, in order and each once."""
    parts = {Fraction(step, steps) for steps in steps_per_period for step in range(steps + 1)}
    return sorted(parts)


def _witnessed(problem: Problem, times: Sequence[hy.real]) -> float:
    """Largest relative difference of the closed form from the solution before rounding; NaN without a closed form."""
    if not closed_form.has_trajectory(problem):
        return np.nan
    chosen = [times[i] for i in np.linspace(0, len(times) - 1, WITNESSED).astype(int)]
    solution = taylor.trajectory(problem, chosen, bits=max(exact.BITS))
    witness = closed_form.trajectory(problem, map(exact.mpf, chosen))
    with mpmath.workdps(closed_form.DIGITS):
        return max(
            float(max(abs(a - exact.mpf(b)) for a, b in zip(expected, values, strict=True)) / max(map(abs, expected)))
            for expected, values in zip(witness, (solution.u, solution.v), strict=True)
        )


def _uncertainty(values: np.ndarray, rates: np.ndarray, t: float, certified: float) -> float:
    """Uncertainty of stored values: (ulp(max |u|) + max |u̇| ulp(t))/2 plus the certified difference.

    ulp is the unit in the last place. The values u, and the times up to t, are rounded to half an ulp. ``values``
    contains u, ``rates`` the derivatives u̇, and ``certified`` is the certified difference.
    """
    return 0.5 * (np.spacing(np.max(np.abs(values))) + np.max(np.abs(rates)) * np.spacing(t)) + certified


@section
class _References(TypedDict):
    problems: Springs
    steps_per_period: Annotated[list[Annotated[int, Ge(2), Le(100_000)]], Len(1, 100)]


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each problem."""
    steps_per_period = options["steps_per_period"]
    return {problem: {"problem": problem, "steps_per_period": steps_per_period} for problem in options["problems"]}


@experiment("reference", section="references", model=_References, split=_jobs)
def reference(problem: Spring, steps_per_period: Sequence[int]) -> xr.Dataset:
    """Compute the exact period of a spring and its motion over one period.

    Displacement and velocity have the shape (t,). The times t are zero and the ends of all steps T/N, with the period T
    and every N in ``steps_per_period``.

    Raises
    ------
    RouteFailed
        If no period is found, an integration ends early, or the integrations do not agree.
    """
    definition = problems_by_name[problem]
    progress(f"exact solution of {problem} with 128 and 192 bits in two formulations")
    exact_period, period_certified = exact.period(definition, approximate_periods[problem])
    parts = phases(steps_per_period)
    times = [exact_period * part.numerator / part.denominator for part in parts]
    solution = exact.trajectory(definition, times)
    energy = np.asarray(jax.vmap(definition.energy)(solution.u, solution.v))
    forces = np.asarray(jax.vmap(definition.static_force)(solution.u))
    rounded = float(exact_period)

    def scalar(value, long_name, units):
        return (), float(value), {"long_name": long_name, "units": units}

    def spread(quantity, certified, units):
        return scalar(certified, f"largest difference of the {quantity} between precisions and formulations", units)

    return xr.Dataset(
        {
            "u": ("t", solution.u, {"long_name": "displacement", "units": "1"}),
            "v": ("t", solution.v, {"long_name": "velocity", "units": "s-1"}),
            "u_uncertainty": scalar(
                _uncertainty(solution.u, solution.v, rounded, solution.u_certified),
                "uncertainty of the displacement",
                "1",
            ),
            "v_uncertainty": scalar(
                _uncertainty(solution.v, forces, rounded, solution.v_certified),
                "uncertainty of the velocity",
                "s-1",
            ),
            "u_certified": spread("displacement before rounding", solution.u_certified, "1"),
            "v_certified": spread("velocity before rounding", solution.v_certified, "s-1"),
            "closed_form_difference": scalar(
                _witnessed(definition, times), "largest relative difference of the closed form", "1"
            ),
            "period": scalar(rounded, "period", "s"),
            "period_remainder": scalar(exact_period - rounded, "exact period less the stored one", "s"),
            "period_uncertainty": scalar(0.5 * np.spacing(rounded), "uncertainty of the period as stored", "s"),
            "period_certified": scalar(
                period_certified, "largest relative difference of the period between integrations and closed form", "1"
            ),
            "energy_drift": scalar(
                np.max(np.abs(energy / energy[0] - 1)), "largest relative change of the energy along the reference", "1"
            ),
        },
        coords={
            "t": ("t", [float(time) for time in times], {"long_name": "elapsed time", "units": "s"}),
            "phase": ("t", [float(part) for part in parts], {"long_name": "elapsed part of the period", "units": "1"}),
        },
        attrs={
            "title": f"Exact solution of the {definition.title} over one period",
            "problem": problem,
            "problem_title": definition.title,
            "period_30_digits": mpmath.nstr(exact.mpf(exact_period), 30, strip_zeros=False),
        },
    )
