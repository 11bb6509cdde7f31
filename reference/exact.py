"""The truth beyond double precision, with an uncertainty that is measured.

The Taylor method of heyoka is run with significands of 128 and of 192 bits, each in two formulations of the equation.
What all four agree on is certified; where a closed form is known it is a fifth witness. A free oscillator is computed
over one period only: with the period known to more than thirty digits, a time of any size is folded into it.
"""

import math
from collections.abc import Sequence
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
from reference.solution import RouteFailed
from reference.symbolic import first_order, with_force_as_state
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Springs, section
from study.problem.definition import Problem
from study.problem.named import printed_periods, problems

BITS = (192, 128)
FORMULATIONS = (first_order, with_force_as_state)
#: What calls itself truth is known to this part of its largest size.
CERTIFIED = 1e-25
#: How many samples of the trajectory the closed form is held against.
WITNESSED = 33


class Truth(NamedTuple):
    """Displacement and velocity rounded to double, and the largest difference of the four integrations, absolute."""

    u: np.ndarray
    v: np.ndarray
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
    """Exact period, and the largest relative difference of the integrations, and of a closed form, from it.

    Raises
    ------
    ValueError
        If the problem has no period.
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


def trajectory(problem: Problem, t: Sequence) -> Truth:
    """Truth at the increasing times ``t``, given as floats or numbers of heyoka.

    Raises
    ------
    ValueError
        If the problem is not smooth or has more than one unknown, or the times do not increase.
    RouteFailed
        If the integrations agree to less than ``CERTIFIED``, as those of a chaotic motion do before long.
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
                f"up to t = {float(t[-1]):g} the truth of '{problem.title}' is known to {_spread(values):.0e} only: "
                "its integrations separate; ask for shorter times."
            )
    return Truth(_doubles(u[0]), _doubles(v[0]), _spread(u), _spread(v))


def _less_whole_periods(time: hy.real, period: hy.real) -> hy.real:
    """``time`` modulo ``period``; the quotient may round up to a whole number that it does not reach."""
    rest = time - period * math.floor(float(time / period))
    return rest + period if rest < 0 else rest


def folded(problem: Problem, t: ArrayLike, exact_period: hy.real, period_certified: float) -> Truth:
    """Truth of a free oscillator at any times, in any order: each less the whole periods that are over.

    The period is known to more than thirty digits, so that a hundred thousand periods cost none of a double's sixteen;
    what they cost of the certified digits is counted in.

    Parameters
    ----------
    t
        Times as doubles, which are taken to be exact.
    exact_period, period_certified
        What :func:`period` found.

    Raises
    ------
    ValueError
        If a time is not finite.
    """
    if not np.all(np.isfinite(t)):
        raise ValueError(f"the truth of '{problem.title}' is asked for at a time that is not finite.")
    times, where = np.unique(np.asarray(t, float), return_inverse=True)
    rests = [_less_whole_periods(hy.real(float(time), max(BITS)), exact_period) for time in times]
    order = sorted(range(len(rests)), key=rests.__getitem__)
    truth = trajectory(problem, [rests[i] for i in order])
    back = np.argsort(order)[where]
    doubt = period_certified * float(np.max(np.abs(times)))
    fastest, strongest = np.max(np.abs(truth.v)), np.max(np.abs(jax.vmap(problem.force)(truth.u)))
    return Truth(
        truth.u[back], truth.v[back], truth.u_certified + fastest * doubt, truth.v_certified + strongest * doubt
    )


def phases(steps_per_period: Sequence[int]) -> list[Fraction]:
    """Every part of the period that is met with one of these numbers of steps, in order, both ends included."""
    parts = {Fraction(step, steps) for steps in steps_per_period for step in range(steps + 1)}
    return sorted(parts)


def _witnessed(problem: Problem, times: Sequence[hy.real]) -> float:
    """Largest difference of the closed form from the motion before rounding, relative; NaN without closed form."""
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
    """Half a unit in the last place of the largest value and of the time, as they are stored, and the certificate."""
    return 0.5 * (np.spacing(np.max(np.abs(values))) + np.max(np.abs(rates)) * np.spacing(t)) + certified


@section
class _References(TypedDict):
    problems: Springs
    steps_per_period: Annotated[list[Annotated[int, Ge(2), Le(100_000)]], Len(1, 100)]


@experiment(
    "reference",
    section="references",
    model=_References,
    split=lambda o: {
        problem: {"problem": problem, "steps_per_period": o["steps_per_period"]} for problem in o["problems"]
    },
    # in numbers of 192 bits, four times
    values=lambda o, c: 100 * sum(o["steps_per_period"]),
)
def reference(problem: str, steps_per_period: Sequence[int]) -> xr.Dataset:
    """Period and trajectory over one period, at every phase that the given numbers of steps per period meet."""
    definition = problems[problem]
    progress(f"truth of {problem}: 128 and 192 bits, two formulations")
    exact_period, period_certified = period(definition, printed_periods[problem])
    parts = phases(steps_per_period)
    times = [exact_period * part.numerator / part.denominator for part in parts]
    truth = trajectory(definition, times)
    energy = np.asarray(jax.vmap(definition.energy)(truth.u, truth.v))
    forces = np.asarray(jax.vmap(definition.force)(truth.u))
    rounded = float(exact_period)

    def scalar(value, long_name, units):
        return (), float(value), {"long_name": long_name, "units": units}

    def spread(quantity, certified, units):
        return scalar(certified, f"largest difference of the {quantity} between precisions and formulations", units)

    return xr.Dataset(
        {
            "u": ("t", truth.u, {"long_name": "displacement", "units": "1"}),
            "v": ("t", truth.v, {"long_name": "velocity", "units": "s-1"}),
            "u_uncertainty": scalar(
                _uncertainty(truth.u, truth.v, rounded, truth.u_certified), "uncertainty of the displacement", "1"
            ),
            "v_uncertainty": scalar(
                _uncertainty(truth.v, forces, rounded, truth.v_certified), "uncertainty of the velocity", "s-1"
            ),
            "u_certified": spread("displacement before rounding", truth.u_certified, "1"),
            "v_certified": spread("velocity before rounding", truth.v_certified, "s-1"),
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
            "period_30_digits": mpmath.nstr(_mpf(exact_period), 30, strip_zeros=False),
        },
    )
