"""Diagonally implicit Runge-Kutta methods of order three and four with a prescribed spectral radius."""

import math
from functools import cache
from typing import ClassVar

import equinox as eqx
import numpy as np

from study.mechanics.balance import at, balance
from study.mechanics.state import Effort, Motion
from study.scheme.base import OneStep, check_ranges


def _diagonal(s: int, rho_inf: float) -> float:
    """Diagonal coefficient γ of the unconditionally stable method of s sub-steps and order s, for ρ∞.

    γ is a root of a polynomial. Of its several roots, the function returns the root nearest to the γ for ρ∞ = 0.
    """
    polynomial = [(-1) ** j * math.comb(s, j) / math.factorial(s - j) for j in range(s, -1, -1)]
    polynomial[0] -= rho_inf * (-1) ** s
    roots = np.roots(polynomial)
    return float(np.sort(roots[np.abs(roots.imag) < 1e-6].real)[s - 2])


def _explicit_part(c: np.ndarray, row: int, gamma: float, moments: list[float]) -> np.ndarray:
    """A row of A with γ on the diagonal; its first weights a satisfy Σ a cᵏ + γ c_rowᵏ = moments[k] for all k."""
    number = len(moments)
    weights = np.zeros(len(c))
    rest = np.array(moments) - gamma * c[row] ** np.arange(number)
    weights[:number] = np.linalg.solve(np.vander(c[:number], increasing=True).T, rest)
    weights[row] = gamma
    return weights


@cache
def _tableau(s: int, rho_inf: float) -> np.ndarray:
    """The weights A (s + 1, s + 1); the last row belongs to the end of the step."""
    g = _diagonal(s, rho_inf)
    # no weight exceeds three with these inner times, for any ρ∞; other times may be too close to 2γ
    c = np.array([0, 2 * g, 0.6, 1] if s == 3 else [0, 2 * g, 0.7, 0.6, 1])
    weights = np.zeros((s + 1, s + 1))
    for row in range(1, s):
        weights[row] = _explicit_part(c, row, g, [c[row], c[row] ** 2 / 2])
    b = weights[s] = _explicit_part(c, s, g, [1 / (k + 1) for k in range(s)])
    if s == 4:
        third = 1 / 12 - b @ weights @ c**2  # the last free weight satisfies Σ b A c² = 1/12
        weights[3] = _explicit_part(c, 3, g, [c[3], c[3] ** 2 / 2, weights[3] @ c**2 + third / b[3]])
    return weights


class DiagonallyImplicit(OneStep):
    r"""The ESDIRK method of s sub-steps and order s, s = 3 or 4: explicit first stage, one γ on the diagonal.

    For i = 1, ..., s, with the times c and the weights A, where the last y_i is the end of the step,

    .. math::

        y_i &= y_0 + \Delta t \sum_{j<i} A_{ij} \dot y_j + \gamma\Delta t\,\dot y_i \quad\text{for } y = u, \dot u \\
        M \ddot u_i + C \dot u_i + p(u_i) &= f(t_0 + c_i \Delta t) \\
        \sum_j A_{ij} &= c_i, \quad \sum_j A_{ij} c_j = \tfrac12 c_i^2, \quad c_1 = 2\gamma, \quad c_s = 1 \\
        \sum_j b_j c_j^k &= \tfrac{1}{k + 1} \text{ for } k < s, \quad b_j = A_{sj} \\
        \sum_{j=0}^s \binom{s}{j} \frac{(-\gamma)^j}{(s - j)!} &= \rho_\infty (-\gamma)^s

    The first sub-step is a step of the trapezoidal rule. For s = 4 the weights also satisfy
    :math:`\sum_j b_j (A c^2)_j = 1/12`. The order conditions do not determine the times between c₁ and c_s; here c₂ =
    0.6 for s = 3, and c₂ = 0.7 and c₃ = 0.6 for s = 4.

    Order s with damping and load too; unconditionally stable for linear systems, with the spectral radius ρ∞ at
    infinite frequency, and the same effective stiffness in all sub-steps. From ρ∞ = 1 to ρ∞ = 0, γ rises from 1/3 to
    0.436 for s = 3, and from 0.394 to 0.573 for s = 4. With γ > ½ the first sub-step, of length 2γΔt, ends beyond t₁.
    Carries u, u̇ and ü; solves s balances per step, each with one force per Newton iteration. The history of a force is
    committed at u₁; all sub-steps start from the history at u₀.

    Parameters
    ----------
    sub_steps
        s, 3 or 4.
    rho_inf
        0 ≤ ρ∞ ≤ 1.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    J. Li, H. Li, K. Yu, R. Zhao, High-order accurate multi-sub-step implicit integration algorithms with dissipation
    control for second-order hyperbolic problems, arXiv 2209.13820, Harbin Institute of Technology, 2023.
    """

    sub_steps: int = eqx.field(static=True)
    rho_inf: float = eqx.field(static=True)
    title: str = eqx.field(default="ESDIRK", static=True)

    family: ClassVar[str] = "Multi-step and composite"
    source: ClassVar[str] = "Li et al. (2023)"
    doi: ClassVar[str] = "10.48550/arXiv.2209.13820"
    explicit = False
    acceleration_offset = 0.0
    force_at_end = True
    stability_limit = math.inf

    def __check_init__(self):
        check_ranges(self, rho_inf=(0.0, 1.0))
        if self.sub_steps not in (3, 4):
            raise ValueError(f"DiagonallyImplicit(sub_steps={self.sub_steps}): sub_steps must be 3 or 4.")

    @property
    def order(self) -> int:
        return self.sub_steps

    def increment(self, problem, state, t, dt):
        u, v, a = state
        slopes, effort = [(v, a)], Effort()
        tableau = _tableau(self.sub_steps, self.rho_inf)
        for row in tableau[1:].tolist():
            h = row[len(slopes)] * dt
            terms = list(zip(row, slopes, strict=False))
            dv = dt * sum(w * a for w, (_, a) in terms)
            du = dt * sum(w * v for w, (v, _) in terms) + h * (v + dv)
            a, more = balance(*at(problem, t + sum(row) * dt), u + du, v + dv, h**2, h, guess=a)
            slopes.append((v + dv + h * a, a))
            effort = effort.then(more)
        return Motion(du + h**2 * a, dv + h * a, a), effort


esdirk3 = DiagonallyImplicit(sub_steps=3, rho_inf=0.8, title="ESDIRK, order 3")
esdirk4 = DiagonallyImplicit(sub_steps=4, rho_inf=0.8, title="ESDIRK, order 4")
