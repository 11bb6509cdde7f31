"""Extrapolation of velocity Verlet to step size zero."""

from fractions import Fraction
from typing import ClassVar

import equinox as eqx

from study.algebra.arrays import VectorLike
from study.mechanics.balance import acceleration
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, as_tuple, check_numbers
from study.scheme.splitting import Composition


class Extrapolation(OneStep):
    r"""A step by velocity Verlet in n₁, n₂, ..., n_k sub-steps, extrapolated to infinitely many sub-steps.

    .. math::

        y_1 = \sum_j w_j\,y_1(n_j), \quad w_j = \prod_{i \ne j} \frac{n_j^2}{n_j^2 - n_i^2}
            \quad\text{for } y = u \text{ and } y = \dot u

    Verlet's method is symmetric: its error is a series in (Δt/n)², and the extrapolation removes its first k − 1 terms.
    The order is 2k, with damping and load too. The k integrations of a step do not depend on each other, so a processor
    can execute them in parallel. Not symplectic. With the sequence 1, 2, ..., 6 it is stable without damping for ωΔt ≤
    3.141, and, beyond a narrow window of instability, again from π to 3.705. Carries u, u̇ and ü; n₁ + ... + n_k + 1
    forces per step. The history of a force is committed at u₁; all sub-steps start from the history at u₀.

    Parameters
    ----------
    sequence
        Numbers of sub-steps, n₁ < n₂ < ... < n_k.
    stability_limit
        Largest ωΔt at which the method is stable without damping, if known.

    Raises
    ------
    ValueError
        If the numbers of sub-steps are not whole, positive and ascending.

    References
    ----------
    W. B. Gragg, On extrapolation algorithms for ordinary initial value problems, SIAM J. Numer. Anal. 2(3), 1965,
    384-403.
    E. Hairer, S. P. Nørsett, G. Wanner, Solving ordinary differential equations I, 2nd ed., Springer, 1993, sections
    II.9 and II.14.
    """

    sequence: tuple[int, ...] = eqx.field(static=True, converter=as_tuple)
    stability_limit: float | None = eqx.field(default=None, static=True)
    title: str = eqx.field(default="Extrapolation", static=True)

    family: ClassVar[str] = "Runge-Kutta and conserving"
    source: ClassVar[str] = "Gragg (1965)"
    doi: ClassVar[str] = "10.1137/0702030"
    explicit = True
    acceleration_offset = 0.0

    def __check_init__(self):
        check_numbers("Extrapolation", "sequence", self.sequence)
        rising = all(a < b for a, b in zip((0, *self.sequence), self.sequence, strict=False))
        if not rising or not all(isinstance(n, int) for n in self.sequence):
            raise ValueError(
                f"Extrapolation(sequence={self.sequence}): sequence must be whole numbers that rise from at least 1."
            )

    @property
    def order(self) -> int:
        return 2 * len(self.sequence)

    def increment(self, problem, state, t, dt):
        du: VectorLike = 0.0
        dv: VectorLike = 0.0
        effort = Effort()
        squares = [Fraction(n) ** 2 for n in self.sequence]
        for n, square in zip(self.sequence, squares, strict=True):
            weight = Fraction(1)
            for other in squares:
                weight *= square / (square - other) if other != square else 1
            verlet, more = Composition(weights=(1 / n,) * n, order_without_damping=2).increment(problem, state, t, dt)
            du, dv = du + float(weight) * verlet.u, dv + float(weight) * verlet.v
            effort = effort.then(more)
        return Motion(du, dv, acceleration(problem, t + dt, state.u + du, state.v + dv)), effort


extrapolation12 = Extrapolation(sequence=(1, 2, 3, 4, 5, 6), stability_limit=3.1411691, title="Extrapolation, order 12")
