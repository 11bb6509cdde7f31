"""Linear theory of a scheme for its page, from the code of the scheme itself."""

import math
from typing import NamedTuple

import numpy as np

import study

#: Step sizes over period of the curves and of the order, which needs fine steps.
PARTS = np.logspace(-3, 3, 601)
#: Steps per period of the rule of thumb, at which pages give numbers.
STEPS = 20
#: Damping ratio of the oscillator that shows the order with damping.
DAMPED = 0.1
#: Loss of amplitude per period below which it counts as round-off.
ROUND_OFF = 1e-9


class Theory(NamedTuple):
    """Linear theory over :data:`PARTS`, and the numbers that follow from it.

    Attributes
    ----------
    radius, elongation, damping
        Spectral radius; relative elongation of the period and damping ratio, which are NaN where nothing oscillates.
    elongation_of_rule, decay_of_rule
        Relative elongation of the period and loss of amplitude per period at :data:`STEPS` steps per period.
    order, order_with_damping
        Measured order without and with damping; NaN if the errors are round-off.
    limit
        ωΔt up to which the scheme is stable.
    at_infinity
        Spectral radius at infinite frequency; NaN for a scheme that is unstable there.
    growth
        Exponents of ωΔt with which the first step grows, from :meth:`study.LinearTheory.growth`.
    overshoot
        Overshoot of displacement and velocity in 64 steps from u = 1 and u̇ = 0, the largest of all stable step sizes.
    memory
        Number of vectors of the size of u in the state that a step passes to the next.
    forces
        Forces that a step evaluates at :data:`STEPS` steps per period of the undamped linear oscillator.
    """

    radius: np.ndarray
    elongation: np.ndarray
    damping: np.ndarray
    elongation_of_rule: float
    decay_of_rule: float
    order: float
    order_with_damping: float
    limit: float
    at_infinity: float
    growth: np.ndarray
    overshoot: np.ndarray
    memory: int
    forces: float


#: Largest ρ∞ that counts as zero: round-off grows with the number of roots that meet at zero.
_NO_RADIUS = 5e-3


#: The undamped linear oscillator with ω = 1.
_LINEAR = study.Problem(force=lambda u: u, potential=lambda u: u * u / 2, u0=1.0, title="linear oscillator")


def _forces(scheme: study.Scheme) -> float:
    if scheme.explicit:
        return scheme.forces_per_step
    run = study.run(_LINEAR, scheme, dt=2 * math.pi / STEPS, steps=STEPS, observe=["newton_iterations"])
    return scheme.forces_per_step + scheme.forces_per_iteration * run.newton_iterations.item() / STEPS


def theory_of(scheme: study.Scheme) -> Theory:
    """Linear theory of a scheme."""
    undamped = study.LinearTheory(scheme, PARTS)
    motion, rule = undamped.motion(), study.LinearTheory(scheme, [1 / STEPS]).motion()
    limit, at_infinity = scheme.stability_limit, undamped.infinite_frequency_radius()
    if limit is None:
        limit = undamped.stability_limit()
    return Theory(
        undamped.spectral_radius,
        motion.period_elongation,
        motion.algorithmic_damping,
        float(rule.period_elongation[0]),
        float(rule.amplitude_decay[0]),
        undamped.order(),
        study.LinearTheory(scheme, PARTS, damping_ratio=DAMPED).order(),
        limit,
        np.nan if np.isfinite(limit) else at_infinity * (at_infinity > _NO_RADIUS),
        undamped.growth(),
        np.nanmax(undamped.overshoot(), axis=1, initial=0.0),
        undamped.matrices.shape[-1],
        _forces(scheme),
    )
