"""The effective equation u + κΔt² p(u) = ũ that a step of many implicit schemes solves, and the number of its roots."""

import jax
import numpy as np

from study.mechanics.definition import Problem
from study.scheme.alpha import HHTAlpha1996
from study.scheme.base import Scheme
from study.scheme.houbolt import Houbolt
from study.scheme.newmark import Newmark
from study.scheme.wilson import WilsonTheta

#: Number of equally spaced displacements at which the sign of the residual is evaluated to count the roots.
SEARCHED = 4001

#: Limit of the search: a range that extends to this displacement is not doubled again.
FARTHEST = 1e6


def effective_coefficient(scheme: Scheme) -> float:
    """Coefficient κ of the effective equation u + κΔt² p(u) = ũ for a unit mass without damping and load.

    Raises
    ------
    ValueError
        If a step of the scheme does not solve one such equation.
    """
    match scheme:
        case Newmark(beta=beta) if beta > 0:
            return beta
        case HHTAlpha1996(alpha=alpha, beta=beta):
            return (1 + alpha) * beta
        case WilsonTheta(theta=theta, beta=beta):
            return beta * theta**2
        case Houbolt():
            return 1 / 2
    raise ValueError(f"a step of '{scheme.title}' is not one effective equation u + κΔt² p(u) = ũ.")


def number_of_roots(problem: Problem, coefficient: np.ndarray, predictor: np.ndarray) -> np.ndarray:
    """Number of roots u of u + c p(u) = ũ, counted as changes of sign of the residual.

    Parameters
    ----------
    problem
        A problem with one unknown.
    coefficient
        c = κΔt², of shape (coefficients,).
    predictor
        ũ, of shape (predictors,).

    Returns
    -------
    numpy.ndarray
        Number of roots, of shape (coefficients, predictors).
    """
    force = jax.jit(jax.vmap(problem.static_force))
    far = 2 * np.abs(predictor).max()
    # double the range until its ends lie beyond all roots: there the left side exceeds every ũ in size, and grows
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
    """Largest Δt at which the effective equation has one root for every ũ.

    It is 1/√(κ max(−p′)), where the maximum is over the displacements ``u``. It is infinite if p′ ≥ 0 at all of them.
    """
    softest = -np.asarray(jax.vmap(jax.grad(problem.static_force))(u)).min()
    return float(1 / np.sqrt(effective_coefficient(scheme) * softest)) if softest > 0 else np.inf
