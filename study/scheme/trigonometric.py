"""Trigonometric methods, which solve the linear part of a problem exactly: Gautschi's and its relatives."""

from collections.abc import Callable
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax.numpy as jnp

from study.algebra.arrays import Matrix, Vector
from study.algebra.matrices import Form, form_of
from study.mechanics.balance import load
from study.mechanics.definition import Problem
from study.mechanics.state import Effort
from study.registry import did_you_mean
from study.scheme.base import OneStep


class Pushed(NamedTuple):
    """Displacement, velocity, and the acceleration g due to all forces except K u, each of shape () or (n,)."""

    u: Vector
    v: Vector
    g: Vector


def _sinc(x: Vector) -> Vector:
    """The quotient sin(x)/x."""
    return jnp.sinc(x / jnp.pi)


def _unity(x: Vector) -> Vector:
    return jnp.ones_like(x)


def _tangent(x: Vector) -> Vector:
    """The quotient tan(x/2)/(x/2)."""
    return _sinc(x / 2) / jnp.cos(x / 2)


#: φ and ψ₁ = ψ/sinc of each member.
filters: dict[str, tuple[Callable, Callable]] = {
    "gautschi": (_unity, _tangent),
    "deuflhard": (_unity, _unity),
    "garcia_archilla": (_sinc, _sinc),
    "hairer_lubich": (_unity, _sinc),
}


def _mass_and_stiffness(problem: Problem) -> tuple[Matrix, Matrix]:
    """M and K of a problem; one if it declares no mass, zero if it declares no stiffness."""
    return 1.0 if problem.mass is None else problem.mass, 0.0 if problem.stiffness is None else problem.stiffness


class Trigonometric(OneStep):
    r"""A trigonometric method, exact for the linear part of M ü + K u + p(u) = f(t).

    With :math:`\Omega^2 = M^{-1} K`, the dimensionless step size :math:`\xi = \Delta t\,\Omega` and
    :math:`g(t, u) = M^{-1} (f(t) - p(\varphi(\xi)\,u))`,

    .. math::

        u_1 &= \cos(\xi)\,u_0 + \Delta t\,\mathrm{sinc}(\xi)\,\dot u_0 + \tfrac12 \Delta t^2 \psi(\xi)\,g_0 \\
        \dot u_1 &= -\Omega \sin(\xi)\,u_0 + \cos(\xi)\,\dot u_0
            + \tfrac12 \Delta t\,(\cos(\xi)\,\psi_1(\xi)\,g_0 + \psi_1(\xi)\,g_1), \quad \psi = \mathrm{sinc}\,\psi_1

    The displacements satisfy :math:`u_1 - 2\cos(\xi)\,u_0 + u_{-1} = \Delta t^2 \psi(\xi)\,g_0`. Members of the family:

    - ``gautschi``, ψ(ξ) = sinc²(ξ/2), φ = 1, whose velocity is not defined where ωΔt is an odd multiple of π;
    - ``deuflhard``, ψ = sinc, φ = 1, symplectic, the method called impulse in molecular dynamics;
    - ``garcia_archilla``, ψ = sinc², φ = sinc, symplectic, called mollified impulse;
    - ``hairer_lubich``, ψ = sinc², φ = 1, which nearly conserves the energy over long times.

    Second order; without K it is velocity Verlet. For problems without damping whose M and K are numbers or diagonals.
    Carries u, u̇ and g; one force per step. The history of a force is committed at u₁.

    Parameters
    ----------
    member
        The name of a member.

    Raises
    ------
    ValueError
        If there is no such member.

    References
    ----------
    W. Gautschi, Numerical integration of ordinary differential equations based on trigonometric polynomials, Numer.
    Math. 3, 1961, 381-397.
    P. Deuflhard, A study of extrapolation methods based on multistep schemes without parasitic solutions, Z. Angew.
    Math. Phys. 30, 1979, 177-189.
    B. García-Archilla, J. M. Sanz-Serna, R. D. Skeel, Long-time-step methods for oscillatory differential equations,
    SIAM J. Sci. Comput. 20(3), 1998, 930-963.
    E. Hairer, C. Lubich, Long-time energy conservation of numerical methods for oscillatory differential equations,
    SIAM J. Numer. Anal. 38(2), 2000, 414-441.
    E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, section XIII.2.
    """

    member: str = eqx.field(static=True)
    title: str = eqx.field(default="Trigonometric", static=True)

    family: ClassVar[str] = "Trigonometric"
    source: ClassVar[str] = "Gautschi (1961)"
    doi: ClassVar[str] = "10.1007/BF01386037"
    order = 2
    explicit = True
    keeps_energy = True
    is_exact_for_stiffness = True
    needs_equal_steps = True

    def __check_init__(self):
        if self.member not in filters:
            raise ValueError(
                f"Trigonometric(member={self.member!r}): no such member; {did_you_mean(str(self.member), filters)}"
            )

    def refusal(self, problem):
        if problem.damped or any(form_of(x) > Form.DIAGONAL for x in _mass_and_stiffness(problem)):
            return (
                f"'{self.title}' solves the linear part of '{problem.title}' exactly, which needs a problem without "
                "damping, with numbers or diagonals as mass and stiffness."
            )
        return super().refusal(problem)

    def start(self, problem, u0, v0, dt):
        return Pushed(u0, v0, self._push(problem, 0.0, u0, self._phase(problem, u0, dt))), Effort()

    def _phase(self, problem: Problem, u: Vector, dt) -> Vector:
        """ξ, of the shape of ``u``."""
        mass, stiffness = _mass_and_stiffness(problem)
        return dt * jnp.sqrt(stiffness / mass) * jnp.ones_like(u)

    def _push(self, problem: Problem, t, u: Vector, phase: Vector) -> Vector:
        """The acceleration g."""
        filtered, _ = filters[self.member]
        force = load(problem, t)
        if not problem.linear:
            force = force - problem.at_time(t).varying_force(filtered(phase) * u, jnp.zeros_like(u))
        return (force if problem.mass is None else force / problem.mass) + jnp.zeros_like(u)

    def increment(self, problem, state, t, dt):
        u, v, g = state
        phase = self._phase(problem, u, dt)
        _, velocity_filter = filters[self.member]
        cosine, sinc, weight = jnp.cos(phase), _sinc(phase), velocity_filter(phase)
        # −2 sin²(ξ/2) is cos ξ − 1 without cancellation
        du = -2 * jnp.sin(phase / 2) ** 2 * u + dt * sinc * v + dt**2 / 2 * sinc * weight * g
        g_new = self._push(problem, t + dt, u + du, phase)
        dv = -(phase**2) / dt * sinc * u - 2 * jnp.sin(phase / 2) ** 2 * v + dt / 2 * weight * (cosine * g + g_new)
        return Pushed(du, dv, g_new), Effort()
