"""Compensated summation."""


def compensated_sum(total, increment, lost):
    """Kahan's sum of a total and an increment, and what it lost; ``lost`` is what the sum before this one lost.

    y = Δ − lost,    s₁ = s₀ + y,    lost = (s₁ − s₀) − y

    References
    ----------
    W. Kahan, Further remarks on reducing truncation errors, Comm. ACM 8(1), 1965, 40.
    """
    corrected = increment - lost
    new = total + corrected
    return new, (new - total) - corrected
