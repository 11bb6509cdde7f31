"""The effective equation u + κΔt² p(u) = ũ that a step of many implicit schemes solves, and how many roots it has."""

import jax
import numpy as np

from study.problem import Problem
from study.schemes import HHTAlpha, Houbolt, Newmark, Scheme, WilsonTheta

#: Displacements among which a change of sign is looked for.
SEARCHED = 4001


def effective_coefficient(scheme: Scheme) -> float:
    """κ of u + κΔt² p(u) = ũ, the effective equation of a step without mass matrix, damping and load.

    Raises
    ------
    ValueError
        If a step of the scheme is not one such equation.
    """
    match scheme:
        case Newmark(beta=beta) if beta > 0:
            return beta
        case HHTAlpha(alpha=alpha, beta=beta):
            return (1 + alpha) * beta
        case WilsonTheta(theta=theta, beta=beta):
            return beta * theta**2
        case Houbolt():
            return 1 / 2
    raise ValueError(f"a step of '{scheme.title}' is not one effective equation u + κΔt² p(u) = ũ.")


def number_of_roots(problem: Problem, coefficient: np.ndarray, predictor: np.ndarray) -> np.ndarray:
    """How many u there are with u + c p(u) = ũ, (coefficients, predictors), from changes of sign."""
    # no root lies beyond the largest predictor and the last rest of the potential
    far = 2 * max(np.abs(predictor).max(), 2.0)
    u = np.linspace(-far, far, SEARCHED)
    p = np.asarray(jax.vmap(problem.force)(u))
    left = u + coefficient[:, None] * p
    sign = left[:, None, :] > predictor[:, None]
    return np.count_nonzero(sign[..., 1:] != sign[..., :-1], axis=-1)
