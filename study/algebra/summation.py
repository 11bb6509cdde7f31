"""Compensated summation."""

from study.algebra.arrays import Vector


def compensated_sum(total: Vector, increment: Vector, lost: Vector) -> tuple[Vector, Vector]:
    """Kahan's sum of a total and an increment, and the round-off of this addition.

    y = Δ − lost,    s₁ = s₀ + y,    lost = (s₁ − s₀) − y

    ``lost`` is the round-off of the addition before, zero at first.

    References
    ----------
    W. Kahan, Further remarks on reducing truncation errors, Commun. ACM 8(1), 1965, 40.
    """
    corrected = increment - lost
    new = total + corrected
    return new, (new - total) - corrected
