r"""Closed form of the ratio of an estimate to the true error of a step, to leading order in ωΔt.

The motion of a linear undamped oscillator is :math:`u = \cos \varphi`, with the phase φ in the middle of a step. A
second-order method of the generalized-α family, such as Newmark's with γ = ½, carries an acceleration
:math:`\ddot u(t + s\,\Delta t) + c\,\Delta t^2 u^{(4)}(t)` with s = α_m − α_f. The errors of a step are

.. math::

    e_u &= (\beta - \tfrac16 + \tfrac{s}{2})\,\Delta t^3 u^{(3)}, \quad
    e_v = (\tfrac1{12} - \tfrac{s^2}{2} + c)\,\Delta t^3 u^{(4)} \\
    c &= \tfrac12 (1 - \alpha_f) - \tfrac12 [(1 - \alpha_m)(1 + 2 s) + s^2]

Relative to the largest u and u̇, the true error is :math:`(\omega \Delta t)^3 \max(|e_u \sin \varphi|, |e_v \cos
\varphi|)`, where e_u and e_v denote the factors in parentheses above.
"""

import numpy as np

from study.scheme.alpha import GeneralizedAlpha, HHTAlpha1996
from study.scheme.base import Scheme
from study.scheme.newmark import Newmark


def _weights(scheme: Scheme) -> tuple[float, float, float] | None:
    """α_m, α_f and β of a second-order method of the generalized-α family; None for any other."""
    if scheme.order != 2:
        return None
    if isinstance(scheme, GeneralizedAlpha):
        return scheme.alpha_m, scheme.alpha_f, scheme.beta
    if isinstance(scheme, HHTAlpha1996):
        return 0.0, -scheme.alpha, scheme.beta
    return (0.0, 0.0, scheme.beta) if isinstance(scheme, Newmark) else None


def linear_ratio(scheme: Scheme, estimator: str, part: np.ndarray, steps: float) -> np.ndarray:
    """Ratio of the estimate to the true error of a step along a period, NaN where no closed form is known.

    Parameters
    ----------
    estimator
        Name of the estimator.
    part
        Phase in the middle of the step, as a fraction of the period, zero at the largest displacement.
    steps
        Number of steps in a period.
    """
    unknown = np.full_like(part, np.nan)
    if estimator == "step_doubling":
        # no closed form is known if the carried acceleration has an offset, because half a step halves the offset,
        # or if damping lowers the order, because the estimate uses the lower order
        exact = not scheme.acceleration_offset and scheme.order == scheme.order_with_damping
        return np.ones_like(part) if exact else unknown
    weights = _weights(scheme)
    if weights is None:
        return unknown
    alpha_m, alpha_f, beta = weights
    s = alpha_m - alpha_f
    c = (1 - alpha_f) / 2 - ((1 - alpha_m) * (1 + 2 * s) + s**2) / 2
    phase, angle = 2 * np.pi * part, 2 * np.pi / steps
    sine, cosine = abs(np.sin(phase)), abs(np.cos(phase))
    error_u, error_v = abs(beta - 1 / 6 + s / 2) * sine, abs(1 / 12 - s**2 / 2 + c) * cosine
    estimates = {
        "zienkiewicz_xie": error_u,
        "zienkiewicz_xie_balance": error_u,
        # the parabola treats the carried acceleration as exact, so its estimate lacks c
        "three_point": np.maximum(error_u, abs(1 / 12 - s**2 / 2) * cosine),
        # without a force at the end of the step, the accelerations are those of the equation of motion
        "half_step_residual": (abs(1 / 8 - s**2 / 2 + c) if scheme.force_at_end else 1 / 8) * cosine / angle,
    }
    return estimates.get(estimator, unknown) / np.maximum(error_u, error_v)
