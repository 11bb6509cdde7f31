"""Exact solutions beyond double precision, with a measured uncertainty.

The Taylor method of heyoka is run with significands of 128 and 192 bits, each in two formulations of the equation. The
digits common to all four integrations are certified. A period is also compared with its closed form if one is known.
:func:`folded` integrates a free oscillator only over one period. The period is known to more than thirty digits, so
any time can be reduced by whole periods.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import heyoka as hy
import jax
import mpmath
import numpy as np
from numpy.typing import ArrayLike

from reference import closed_form, taylor
from reference.solution import History, RouteFailed
from reference.symbolic import first_order, with_force_as_state
from study.mechanics.definition import Problem

#: Bits of the significands of the integrations; the first number gives the solution.
BITS = (192, 128)
#: Formulations of the equation of motion; the first formulation gives the solution.
FORMULATIONS = (first_order, with_force_as_state)
#: Largest difference of the integrations, relative to the largest value, up to which a solution counts as exact.
CERTIFIED = 1e-25


class ExactSolution(NamedTuple):
    """Exact solution at some times, rounded to doubles.

    Attributes
    ----------
    u, v
        Displacement and velocity, (t,).
    u_certified, v_certified
        Largest absolute difference of u and of v from the other integrations, before rounding to doubles. In a solution
        by :func:`folded`, the effect of the error of the times is added.
    """

    u: History
    v: History
    u_certified: float
    v_certified: float


def mpf(value: hy.real) -> mpmath.mpf:
    """A number of heyoka as a number of mpmath, with all its digits."""
    with mpmath.workprec(value.prec):
        return mpmath.mpf(str(value))


def _spread(values: Sequence[np.ndarray]) -> float:
    """Largest difference of any of the arrays from the first."""
    return max(float(np.max(np.abs(other - values[0]))) for other in values[1:])


def _doubles(values: np.ndarray) -> np.ndarray:
    return np.array([float(value) for value in values])


def period(problem: Problem, estimate: float) -> tuple[hy.real, float]:
    """Exact period of a free oscillator released from rest, with a measured uncertainty.

    Parameters
    ----------
    estimate
        Rough period; the exact period must be less than one and a half times as long.

    Returns
    -------
    period : heyoka.real
        Period of 192 bits.
    difference : float
        Largest relative difference of this period from the other integrations, and from a closed form if one is known.

    Raises
    ------
    ValueError
        If the problem is not a free oscillator of one unknown that starts at rest, out of equilibrium.
    RouteFailed
        If no turning point comes within three quarters of the estimate.
    """
    periods = [
        taylor.period(problem, estimate, bits=bits, formulation=formulation)
        for bits in BITS
        for formulation in FORMULATIONS
    ]
    best = periods[0]
    differences = [float(abs(other / best - 1)) for other in periods[1:]]
    if closed_form.is_known(problem):
        with mpmath.workdps(closed_form.DIGITS):
            differences.append(float(abs(closed_form.period(problem) / mpf(best) - 1)))
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
                "only, because its integrations diverge; ask for shorter times."
            )
    return ExactSolution(_doubles(u[0]), _doubles(v[0]), _spread(u), _spread(v))


def _less_whole_periods(time: hy.real, period: hy.real) -> hy.real:
    """``time`` modulo ``period``."""
    rest = time - period * math.floor(float(time / period))
    # the quotient may have been rounded up to a whole number
    return rest + period if rest < 0 else rest


def folded(problem: Problem, t: ArrayLike, exact_period: hy.real, period_certified: float) -> ExactSolution:
    """Exact solution of a free oscillator at times of any size, in any order.

    Each time is reduced by whole periods. The period is known to more than thirty digits, so the sixteen digits of a
    double stay exact over a hundred thousand periods. The effect of the error of the reduced times is added to
    ``u_certified`` and ``v_certified``.

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
        raise ValueError(f"the exact solution of '{problem.title}' needs finite times.")
    times, inverse = np.unique(np.asarray(t, float), return_inverse=True)
    rests = [_less_whole_periods(hy.real(float(time), max(BITS)), exact_period) for time in times]
    order = sorted(range(len(rests)), key=rests.__getitem__)
    solution = trajectory(problem, [rests[i] for i in order])
    back = np.argsort(order)[inverse]
    time_error = period_certified * float(np.max(np.abs(times)))
    fastest, strongest = np.max(np.abs(solution.v)), np.max(np.abs(jax.vmap(problem.static_force)(solution.u)))
    return ExactSolution(
        solution.u[back],
        solution.v[back],
        solution.u_certified + fastest * time_error,
        solution.v_certified + strongest * time_error,
    )
