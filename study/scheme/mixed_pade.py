"""High-order methods for linear structures from mixed Padé expansions; a step solves complex systems of n unknowns."""

import math
from functools import cache
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.polynomial.legendre import Legendre

from study.algebra.elimination import solve
from study.algebra.matrices import Banded, Form, add, form_of, product, times
from study.mechanics.balance import load
from study.mechanics.state import Effort, Phase
from study.scheme.base import OneStep, check_ranges


class _Weights(NamedTuple):
    """Weights of the method.

    ``c`` holds the times. The other fields have an entry for each eigenvalue λ for which a system is solved: λ, its row
    of T⁻¹, the sum of this row, the product of this row with c, and the weights of u̇ and u.
    """

    c: np.ndarray
    roots: np.ndarray
    rows: np.ndarray
    sums: np.ndarray
    moments: np.ndarray
    velocity: np.ndarray
    displacement: np.ndarray


@cache
def _weights(m: int, rho_inf: float) -> _Weights:
    nodes = Legendre([*[0.0] * (m - 1), rho_inf - 1, rho_inf + 1], domain=[0, 1]).roots()
    c = np.sort(nodes.real)
    powers = np.arange(1, m + 1)
    inverse = np.linalg.inv(np.vander(c, increasing=True))
    a = (c[:, None] ** powers / powers) @ inverse
    b = (1 / powers) @ inverse
    roots, vectors = np.linalg.eig(a)
    # two conjugate eigenvalues contribute twice the real part of one of them, so only one is kept
    upper = roots.imag > -1e-12
    twice = np.where(roots.imag > 1e-12, 2.0, 1.0)
    rows = np.linalg.inv(vectors)
    weights = roots, rows, rows.sum(axis=1), rows @ c, twice * (b @ vectors), twice * (b @ a @ vectors)
    return _Weights(c, *(weight[upper].astype(complex) for weight in weights))


def _complex(numbers):
    """A matrix in any form, or a vector, as complex numbers."""
    return jax.tree.map(lambda x: jnp.asarray(x, complex), numbers)


class MixedPade(OneStep):
    r"""The method of Song et al. for linear structures, from a mean of two Padé expansions of order M.

    The amplification of the free motion :math:`e^{zt/\Delta t}` in a step is

    .. math::

        R(z) = \frac{\rho_\infty P_{M,M}(z) + (1 - \rho_\infty) P_{M-1,M}(z)}
            {\rho_\infty Q_{M,M}(z) + (1 - \rho_\infty) Q_{M-1,M}(z)} = e^z + O(z^{2M})

    with the Padé expansions P/Q of :math:`e^z`, each Q with the leading coefficient :math:`(-1)^M`. This is the
    collocation method at the roots c of :math:`(1 + \rho_\infty) P_M - (1 - \rho_\infty) P_{M-1}`, where P_M is
    Legendre's polynomial on [0, 1]. The method has the weights b and :math:`A = T \Lambda T^{-1}`. For each eigenvalue
    λ with the row τ of :math:`T^{-1}`, and the weights w = bᵀT and w′ = bᵀAT,

    .. math::

        (M + \lambda\Delta t\,C + \lambda^2 \Delta t^2 K)\,a_\lambda &= \sum_j \tau_j f(t_0 + c_j \Delta t)
            - \sum_j \tau_j\,[C \dot u_0 + K (u_0 + c_j \Delta t\,\dot u_0)] \\
        \dot u_1 &= \dot u_0 + \Delta t \sum_\lambda w_\lambda a_\lambda \\
        u_1 &= u_0 + \Delta t\,\dot u_0 + \Delta t^2 \sum_\lambda w'_\lambda a_\lambda

    In this system, M is the mass. Of two conjugate λ only one needs a solution. Order 2M − 1, and 2M for ρ∞ = 1, with
    damping and load too; unconditionally stable, with the spectral radius ρ∞ at infinite frequency. M = 1 with ρ∞ = 1
    is the midpoint rule, with ρ∞ = 0 the implicit Euler method. For linear problems whose matrices are numbers,
    diagonals, tridiagonal or full. Carries u and u̇; no iteration. Solves M/2 complex systems per step, rounded up; if M
    is odd, the λ of one of them is real.

    Parameters
    ----------
    terms
        M, from 1 to 6.
    rho_inf
        0 ≤ ρ∞ ≤ 1.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    C. Song, X. Zhang, S. Eisenträger, A. S. Kumar, High-order implicit time integration scheme with controllable
    numerical dissipation based on mixed-order Padé expansions, Comput. Struct. 285, 2023, 107071.
    E. Hairer, G. Wanner, Solving ordinary differential equations II, 2nd ed., Springer, 1996, sections IV.3 and IV.5.
    """

    terms: int = eqx.field(static=True)
    rho_inf: float = eqx.field(static=True)
    title: str = eqx.field(default="Mixed Padé", static=True)

    family: ClassVar[str] = "Linear structures"
    source: ClassVar[str] = "Song et al. (2023)"
    doi: ClassVar[str] = "10.1016/j.compstruc.2023.107071"
    explicit = False
    stability_limit = math.inf

    def __check_init__(self):
        check_ranges(self, rho_inf=(0.0, 1.0))
        if self.terms not in range(1, 7):
            raise ValueError(f"MixedPade(terms={self.terms}): terms must be a whole number from 1 to 6.")

    @property
    def order(self) -> int:
        return 2 * self.terms - (self.rho_inf < 1)

    def refusal(self, problem):
        matrices = [x for x in (problem.mass, problem.damping, problem.stiffness) if x is not None]
        wide = any(isinstance(x, Banded) and x.half_bandwidth > 1 for x in matrices)
        if not problem.linear or wide or any(form_of(x) in (Form.SPARSE, Form.FREE) for x in matrices):
            return (
                f"'{self.title}' needs a linear problem without a force and with matrices that are numbers, diagonals, "
                f"tridiagonal or full, which '{problem.title}' is not."
            )
        return super().refusal(problem)

    def start(self, problem, u0, v0, dt):
        return Phase(u0, v0), Effort()

    def increment(self, problem, state, t, dt):
        u, v = state
        c, *root_weights = _weights(self.terms, self.rho_inf)
        loads = [_complex(load(problem, t + part * dt)) for part in c.tolist()]
        # the tangent of the force is included, because the oscillator of linear theory has a force p(u) = u and no K
        tangent = problem.stiffness_at(jnp.zeros_like(u))
        u_0, v_0, h = _complex(u), _complex(v), _complex(dt)
        mass, damping, stiffness = (
            _complex(default if x is None else x)
            for x, default in ((problem.mass, 1.0), (problem.damping, 0.0), (tangent, 0.0))
        )
        du, dv = dt * v, jnp.zeros_like(v)
        for root, row, row_sum, moment, velocity_weight, displacement_weight in zip(*root_weights, strict=True):
            pushes = sum(part * f for part, f in zip(row, loads, strict=True))
            resistance = times(damping, row_sum * v_0) + times(stiffness, row_sum * u_0 + moment * h * v_0)
            effective = add(
                mass, product(root * h, damping, u.size), product((root * h) ** 2, stiffness, u.size), n=u.size
            )
            a = solve(effective, pushes - resistance)
            dv, du = dv + dt * jnp.real(velocity_weight * a), du + dt**2 * jnp.real(displacement_weight * a)
        return Phase(du, dv), Effort()
