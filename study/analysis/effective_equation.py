"""The effective equation u + κΔt² p(u) = ũ that a step of many implicit schemes solves, and how many roots it has."""

import jax
import numpy as np

from study.problem.definition import Problem
from study.scheme.alpha import HHTAlpha
from study.scheme.base import Scheme
from study.scheme.houbolt import Houbolt
from study.scheme.newmark import Newmark
from study.scheme.wilson import WilsonTheta

#: Displacements among which a change of sign is looked for.
SEARCHED = 4001

#: How far they are looked for at most.
FARTHEST = 1e6


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
    force = jax.jit(jax.vmap(problem.force))
    far = 2 * np.abs(predictor).max()
    # beyond every root the left side is larger than any predictor, and grows without a change of sign
    while far < FARTHEST:
        ends = far * np.array([[-1.0, 1.0], [-2.0, 2.0]])
        left = ends + coefficient[:, None, None] * np.asarray(jax.vmap(force)(ends))
        near, beyond = np.abs(left[:, 0]), np.sign(left[:, 0]) * left[:, 1]
        if near.min() > np.abs(predictor).max() and (beyond > near).all():
            break
        far *= 2
    u = np.linspace(-far, far, SEARCHED)
    left = u + coefficient[:, None] * np.asarray(force(u))
    sign = left[:, None, :] > predictor[:, None]
    return np.count_nonzero(sign[..., 1:] != sign[..., :-1], axis=-1)


def unique_up_to(problem: Problem, scheme: Scheme, u: np.ndarray) -> float:
    """Δt = 1/√(κ max(−p′)) up to which the equation has one root, with p′ among the displacements ``u``."""
    softest = -np.asarray(jax.vmap(jax.grad(problem.force))(u)).min()
    return float(1 / np.sqrt(effective_coefficient(scheme) * softest)) if softest > 0 else np.inf
