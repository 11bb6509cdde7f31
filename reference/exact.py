"""Exact solutions beyond double precision, with a measured uncertainty.

The Taylor method of heyoka is run with significands of 128 and 192 bits, each in two formulations of the equation. The
digits common to all four integrations are certified; a closed form is compared too where one is known. A free
oscillator is integrated over one period only: its period is known to more than thirty digits, so any time can be
reduced by whole periods.
"""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Annotated, NamedTuple

import heyoka as hy
import jax
import mpmath
import numpy as np
import xarray as xr
from annotated_types import Ge, Le, Len
from numpy.typing import ArrayLike
from typing_extensions import TypedDict

from reference import closed_form, taylor
from reference.solution import History, RouteFailed
from reference.symbolic import first_order, with_force_as_state
from study.pipeline.command import progress
from study.pipeline.experiment import Options, experiment
from study.pipeline.options import Springs, section
from study.problem.definition import Problem
from study.problem.named import printed_periods
from study.problem.named import problems as problems_by_name

#: Significands and formulations of the integrations; the first of each gives the solution.
BITS = (192, 128)
FORMULATIONS = (first_order, with_force_as_state)
#: Largest difference of the integrations, over the largest value, up to which a solution counts as exact.
CERTIFIED = 1e-25
#: Number of samples of a trajectory that are compared with the closed form.
WITNESSED = 33


class ExactSolution(NamedTuple):
    """Exact solution at some times, rounded to doubles.

    Attributes
    ----------
    u, v
        Displacement and velocity, (t,).
    u_certified, v_certified
        Largest absolute difference of the four integrations before rounding.
    """

    u: History
    v: History
    u_certified: float
    v_certified: float


def _mpf(value: hy.real) -> mpmath.mpf:
    with mpmath.workprec(value.prec):
        return mpmath.mpf(str(value))


def _spread(values: Sequence[np.ndarray]) -> float:
    """Largest difference of any of the arrays from the first."""
    return max(float(np.max(np.abs(other - values[0]))) for other in values[1:])


def _doubles(values: np.ndarray) -> np.ndarray:
    return np.array([float(value) for value in values])


def period(problem: Problem, estimate: float) -> tuple[hy.real, float]:
    """Exact period of a free oscillator at rest, and its largest relative difference from the other routes.

    Parameters
    ----------
    estimate
        Rough period; the exact one must be less than one and a half times as long.

    Returns
    -------
    period : heyoka.real
        Period of 192 bits.
    difference : float
        Largest relative difference of the other integrations, and of a closed form if one is known.

    Raises
    ------
    ValueError
        If the problem is no free oscillator of one unknown that starts at rest, out of equilibrium.
    RouteFailed
        If no turning point comes within three quarters of the estimate.
    """
    found = [
        taylor.period(problem, estimate, bits=bits, formulation=formulation)
        for bits in BITS
        for formulation in FORMULATIONS
    ]
    best = found[0]
    differences = [float(abs(other / best - 1)) for other in found[1:]]
    if closed_form.is_known(problem):
        with mpmath.workdps(closed_form.DIGITS):
            differences.append(float(abs(closed_form.period(problem) / _mpf(best) - 1)))
    return best, max(differences)


def trajectory(problem: Problem, t: Sequence) -> ExactSolution:
    """Exact solution of a problem with one unknown at the increasing times ``t``.

    Parameters
    ----------
    t
        Times as floats or as numbers of heyoka.

    Raises
    ------
    ValueError
        If the problem is not smooth or has more than one unknown, or the times do not increase.
    RouteFailed
        If the integrations differ by more than ``CERTIFIED``, as they do after some time of chaotic motion.
    """
    solutions = [
        taylor.trajectory(problem, t, bits=bits, formulation=formulation)
        for bits in BITS
        for formulation in FORMULATIONS
    ]
    u, v = [s.u for s in solutions], [s.v for s in solutions]
    for values in (u, v):
        if not _spread(values) <= CERTIFIED * float(np.max(np.abs(values[0]))):
            raise RouteFailed(
                f"the exact solution of '{problem.title}' up to t = {float(t[-1]):g} is known to {_spread(values):.0e} "
                "only, because its integrations separate; ask for shorter times."
            )
    return ExactSolution(_doubles(u[0]), _doubles(v[0]), _spread(u), _spread(v))


def _less_whole_periods(time: hy.real, period: hy.real) -> hy.real:
    """``time`` modulo ``period``."""
    rest = time - period * math.floor(float(time / period))
    # the quotient may have been rounded up to a whole number
    return rest + period if rest < 0 else rest


def folded(problem: Problem, t: ArrayLike, exact_period: hy.real, period_certified: float) -> ExactSolution:
    """Exact solution of a free oscillator at times of any size, in any order.

    Each time is reduced by whole periods. The period is known to more than thirty digits, so a hundred thousand periods
    leave the sixteen digits of a double exact. Their effect on the certified digits is added to the differences.

    Parameters
    ----------
    t
        Times as doubles, which are taken to be exact.
    exact_period, period_certified
        Period and difference that :func:`period` returns.

    Raises
    ------
    ValueError
        If a time is not finite.
    """
    if not np.all(np.isfinite(t)):
        raise ValueError(f"the exact solution of '{problem.title}' is asked for at a time that is not finite.")
    times, where = np.unique(np.asarray(t, float), return_inverse=True)
    rests = [_less_whole_periods(hy.real(float(time), max(BITS)), exact_period) for time in times]
    order = sorted(range(len(rests)), key=rests.__getitem__)
    solution = trajectory(problem, [rests[i] for i in order])
    back = np.argsort(order)[where]
    doubt = period_certified * float(np.max(np.abs(times)))
    fastest, strongest = np.max(np.abs(solution.v)), np.max(np.abs(jax.vmap(problem.static_force)(solution.u)))
    return ExactSolution(
        solution.u[back],
        solution.v[back],
        solution.u_certified + fastest * doubt,
        solution.v_certified + strongest * doubt,
    )


def phases(steps_per_period: Sequence[int]) -> list[Fraction]:
    """All fractions k/N of the period with 0 ≤ k ≤ N, for N in ``steps_per_period``, in order and each once."""
    parts = {Fraction(step, steps) for steps in steps_per_period for step in range(steps + 1)}
    return sorted(parts)


def _witnessed(problem: Problem, times: Sequence[hy.real]) -> float:
    """Largest relative difference of the closed form from the solution before rounding; NaN without a closed form."""
    if not closed_form.has_trajectory(problem):
        return np.nan
    chosen = [times[i] for i in np.linspace(0, len(times) - 1, WITNESSED).astype(int)]
    solution = taylor.trajectory(problem, chosen, bits=max(BITS))
    exact = closed_form.trajectory(problem, map(_mpf, chosen))
    with mpmath.workdps(closed_form.DIGITS):
        return max(
            float(max(abs(a - _mpf(b)) for a, b in zip(one, other, strict=True)) / max(map(abs, one)))
            for one, other in zip(exact, (solution.u, solution.v), strict=True)
        )


def _uncertainty(values: np.ndarray, rates: np.ndarray, t: float, certified: float) -> float:
    """Uncertainty of stored values: (ulp(max |u|) + max |u̇| ulp(t))/2 plus the certified difference.

    ulp is the unit in the last place: the values u and the times up to t are rounded. ``rates`` are the derivatives u̇.
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


def _numbers_held(options: Options, configuration: Mapping) -> float:
    # each phase is held in four integrations as numbers of 192 bits, which are objects
    return 100 * sum(options["steps_per_period"])


@experiment("reference", section="references", model=_References, split=_jobs, values=_numbers_held)
def reference(problem: str, steps_per_period: Sequence[int]) -> xr.Dataset:
    """Compute the exact period of a spring and its motion over one period.

    Displacement and velocity have the shape (t,), with the times of every step of T/N, N in ``steps_per_period``.

    Raises
    ------
    RouteFailed
        If the integrations do not agree.
    """
    definition = problems_by_name[problem]
    progress(f"exact solution of {problem} with 128 and 192 bits in two formulations")
    exact_period, period_certified = period(definition, printed_periods[problem])
    parts = phases(steps_per_period)
    times = [exact_period * part.numerator / part.denominator for part in parts]
    solution = trajectory(definition, times)
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
            "period_remainder": scalar(exact_period - rounded, "what rounding took from the period", "s"),
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
            "period_30_digits": mpmath.nstr(_mpf(exact_period), 30, strip_zeros=False),
        },
    )
