"""Newmark's formulas for displacement and velocity, which several families share.

u₁ = u₀ + Δt u̇₀ + Δt² (½ − β) ü₀ + Δt² β ü₁,    u̇₁ = u̇₀ + Δt (1 − γ) ü₀ + Δt γ ü₁

References
----------
N. M. Newmark, A method of computation for structural dynamics, J. Eng. Mech. Div. ASCE 85(EM3), 1959, 67-94.
"""

from study.algebra.arrays import ScalarLike, VectorLike

#: Conditions on parameters hold up to this round-off.
ROUND_OFF = 1e-12


def predicted(
    v: VectorLike, a: VectorLike, dt: ScalarLike, beta: ScalarLike, gamma: ScalarLike
) -> tuple[VectorLike, VectorLike]:
    """Increments of u and u̇ without the terms of ü₁: Δt u̇₀ + Δt² (½ − β) ü₀ and Δt (1 − γ) ü₀."""
    return dt * v + dt**2 * (0.5 - beta) * a, dt * (1 - gamma) * a


def corrected(
    v: VectorLike, a: VectorLike, a_new: VectorLike, dt: ScalarLike, beta: ScalarLike, gamma: ScalarLike
) -> tuple[VectorLike, VectorLike]:
    """Increments of u and u̇, with ü₁ known."""
    return dt * v + dt**2 * ((0.5 - beta) * a + beta * a_new), dt * ((1 - gamma) * a + gamma * a_new)


def bounded_at_infinite_frequency(beta: float, gamma: float) -> bool:
    """Whether velocity and acceleration of an unknown without mass stay bounded by these formulas.

    A balance of such an unknown prescribes its displacement. With u₀ = u₁ = 0 the formulas give ü₁ only if β > 0, and
    their roots solve β λ² + (½ + γ − 2β) λ + (½ − γ + β) = 0. Neither is larger than one if 2β ≥ γ ≥ ½.
    """
    return bool(beta > 0 and 2 * beta >= gamma - ROUND_OFF and gamma >= 0.5 - ROUND_OFF)
