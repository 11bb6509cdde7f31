"""Linear theory of a scheme for its page, from the code of the scheme itself."""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

import study
from study.analysis.forces import forces_of

#: Step sizes divided by the period, for the curves and for the measured order. The order needs the fine steps.
PARTS = np.logspace(-3, 3, 601)
#: Steps per period of the rule of thumb, at which pages give numbers.
STEPS = 20
#: Numbers of steps per period at which the error is computed, from the finest steps to the coarsest.
TRIED = np.unique(np.geomspace(1, 1e5, 1000).round())[::-1]
#: Number of periods after which the error is computed.
PERIODS = 100
#: Damping ratio of the oscillator that shows the order with damping.
DAMPED = 0.1
#: Size below which a number of linear theory, such as the loss of amplitude per period, counts as round-off.
ROUND_OFF = 1e-9


class Theory(NamedTuple):
    """Linear theory of a scheme, and further numbers for its page.

    Attributes
    ----------
    linear
        The dataset of :class:`study.LinearTheory` over :data:`PARTS`, without damping.
    elongation_of_rule, decay_of_rule
        Relative elongation of the period and loss of amplitude per period at :data:`STEPS` steps per period.
    order_with_damping
        Measured order with damping; NaN if the errors are round-off.
    limit
        ωΔt up to which the scheme is stable.
    at_infinity
        Spectral radius at infinite frequency; NaN for a scheme with a stability limit.
    least_radius
        Smallest spectral radius below a stability limit; NaN for a scheme without a limit or without stable steps.
    error
        Error of the displacement over :data:`PERIODS` periods for each number of steps per period in :data:`TRIED`; NaN
        where nothing oscillates.
    error_of_rule
        Largest error of the displacement in one period of :data:`STEPS` steps, from the two starts.
    forces
        Forces that a step evaluates at :data:`STEPS` steps per period of the undamped linear oscillator.
    """

    linear: xr.Dataset
    elongation_of_rule: float
    decay_of_rule: float
    order_with_damping: float
    limit: float
    at_infinity: float
    least_radius: float
    error: np.ndarray
    error_of_rule: float
    forces: float


#: Largest ρ∞ that counts as zero: round-off grows with the number of roots that meet at zero.
_NO_RADIUS = 5e-3


#: The undamped linear oscillator with ω = 1.
_LINEAR = study.Problem(force=lambda u: u, potential=lambda u: u * u / 2, u0=1.0, title="linear oscillator")


def _forces_and_error(scheme: study.Scheme) -> tuple[float, float]:
    """Forces that a step evaluates, and error of the displacement, in one period of :data:`STEPS` steps."""
    starts = np.eye(2)
    run = study.run(
        _LINEAR,
        scheme,
        dt=2 * math.pi / STEPS,
        steps=STEPS,
        u0=starts[0],
        v0=starts[1],
        observe=["newton_iterations", "trajectory"],
    )
    exact = starts[0][:, None] * np.cos(run.t.values) + starts[1][:, None] * np.sin(run.t.values)
    counted = forces_of(scheme, several=False)
    iterations = run.newton_iterations.isel(lane=0).item()
    return counted.per_step + counted.per_iteration * iterations / STEPS, float(abs(run.u.values - exact).max())


def error_of_displacement(scheme: study.Scheme, steps: np.ndarray, periods: int) -> np.ndarray:
    """Largest error of the displacement over a number of periods, relative to the amplitude, for each number of steps.

    The larger one of two starts, at rest and through zero, counts, or the growth of the largest root if it is larger.
    """
    theory = study.LinearTheory(scheme, 1 / steps)
    motion = theory.motion()
    delay = 2 * np.pi * periods * motion.period_elongation / (1 + motion.period_elongation)
    amplitude = (1 - motion.amplitude_decay) ** periods
    # clipped to half a period, where the error is largest: with a larger delay the error would fall again
    turned = amplitude * np.exp(-1j * np.clip(delay, -np.pi, np.pi))
    factors = theory.displacement_factors()
    error = np.maximum(abs(factors - 1), abs(factors * turned - 1)).max(axis=0)  # at the beginning and at the end
    growth = periods * steps * (theory.spectral_radius - 1)  # to first order: a power of the radius would overflow
    return np.maximum(error, growth)


def _least_radius(scheme: study.Scheme, limit: float) -> float:
    """Smallest spectral radius below a stability limit, on successively finer grids: two roots meet there in a cusp."""
    omega = np.linspace(0, limit, 1001)[1:]
    for _ in range(3):
        radius = study.LinearTheory(scheme, omega / (2 * np.pi)).spectral_radius
        place = int(radius.argmin())
        omega = np.linspace(omega[max(place - 1, 0)], omega[min(place + 1, len(omega) - 1)], 1001)
    return float(radius.min())


def theory_of(scheme: study.Scheme) -> Theory:
    """Linear theory of a scheme."""
    linear = study.LinearTheory(scheme, PARTS).dataset()
    rule = study.LinearTheory(scheme, [1 / STEPS]).motion()
    limit, at_infinity = scheme.stability_limit, linear.infinite_frequency_radius.item()
    if limit is None:
        limit = linear.stability_limit.item()
    forces, error_of_rule = _forces_and_error(scheme)
    least_radius = np.nan
    if 0 < limit < np.inf:
        least_radius = _least_radius(scheme, limit)
    return Theory(
        linear,
        float(rule.period_elongation[0]),
        float(rule.amplitude_decay[0]),
        study.LinearTheory(scheme, PARTS, damping_ratio=DAMPED).order(),
        limit,
        np.nan if np.isfinite(limit) else at_infinity * (at_infinity > _NO_RADIUS),
        least_radius,
        error_of_displacement(scheme, TRIED, PERIODS),
        error_of_rule,
        forces,
    )
