"""The effective equation u + κΔt² p(u) = ũ that a step of many implicit schemes solves."""

import jax
import numpy as np

from study.mechanics.definition import Problem
from study.scheme.alpha import HHTAlpha1996
from study.scheme.base import Scheme
from study.scheme.houbolt import Houbolt
from study.scheme.newmark import Newmark
from study.scheme.wilson import WilsonTheta


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


def unique_up_to(problem: Problem, scheme: Scheme, u: np.ndarray) -> float:
    """Largest Δt at which the effective equation has one root for every ũ.

    It is 1/√(κ max(−p′)), where the maximum is over the displacements ``u``. It is infinite if p′ ≥ 0 at all of them.
    """
    softest = -np.asarray(jax.vmap(jax.grad(problem.static_force))(u)).min()
    return float(1 / np.sqrt(effective_coefficient(scheme) * softest)) if softest > 0 else np.inf
