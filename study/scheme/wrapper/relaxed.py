"""Relaxation: the increment of a step is scaled so that the energy stays the same."""

from collections.abc import Callable
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax

from study.algebra.arrays import Scalar
from study.mechanics.newton import iterated, opened_closure
from study.mechanics.state import Effort
from study.scheme.base import OneStep, Wrapper, WrapperState


class Late(WrapperState):
    """State of the wrapped scheme, and the time to which it belongs minus the time of the march."""

    inner: Any
    lead: Scalar


def _relaxation(energy: Callable) -> tuple[Scalar, Effort]:
    """The γ near one with E(γ) = E(0), and whether Newton's iteration found it, with the energies evaluated.

    The iteration solves (E(γ) − E(0))/γ = 0. This quotient does not have the root γ = 0 of the energy difference, and
    is a straight line for a linear system.
    """
    initial = energy(0.0)
    unity = jnp.ones_like(initial)

    def corrected(gamma):
        quotient, slope = jax.jvp(lambda gamma: (energy(gamma) - initial) / gamma, (gamma,), (unity,))
        # a structure in balance does not move: any γ is valid
        return gamma - jnp.where(slope == 0, 0.0, quotient / jnp.where(slope == 0, 1.0, slope))

    def iterate(gamma, last):
        new = corrected(gamma)
        # the convergence is quadratic, so one correction after the loop reduces the error to round-off
        return new, jnp.abs(new - gamma) > jnp.finfo(unity.dtype).eps ** (1 / 3), last, 0

    opened, captured = opened_closure(iterate, unity, unity)
    first = unity, None, jnp.ones((), bool), jnp.zeros((), int), jnp.zeros((), int)
    gamma, _, unfinished, iterations, _ = iterated(opened, lax.stop_gradient(captured), first)
    # outside the loop, so that JAX can differentiate this correction
    # the energies before, of each iteration and of this correction; an energy counts as a force
    return corrected(gamma), Effort(converged=~unfinished, forces=iterations + 2)


class Relaxed(Wrapper):
    r"""Another scheme whose increment is scaled so that the energy stays the same.

    With the energy E = ½ u̇ᵀ M u̇ + ½ uᵀ K u + V, the increment Δy of the scheme for a step h from y₀ = (u₀, u̇₀) at its
    own time τ₀, and the end t₁ of the step,

    .. math::

        h &= t_1 - \tau_0, \quad y_1 = y_0 + \gamma\,\Delta y, \quad \tau_1 = \tau_0 + \gamma h \\
        E(y_1) &= E(y_0), \quad \gamma = 1 + O(h^{p-1})

    The motion y₁ belongs to τ₁ and has the order p of the scheme there. If the next step started at t₁ instead of τ₁,
    the differences (γ − 1) h of all steps would accumulate, and the order would be p − 1. Because the next step starts
    at τ₁, only the last difference τ₁ − t₁ = (γ − 1) h = O(hᵖ) remains, and y₁ as the motion at t₁ has the order p too.
    Stability for linear systems is unchanged. For problems with a potential and without damping, load and history.
    Carries the state of the wrapped scheme, scaled in the same way, and τ₁ − t₁; as many forces per step as the wrapped
    scheme, and additional evaluations of the potential.

    Parameters
    ----------
    scheme
        A scheme whose step adds increments to displacement and velocity: any one-step scheme of the study.

    Raises
    ------
    TypeError
        If ``scheme`` is not a :class:`study.OneStep`.

    References
    ----------
    D. I. Ketcheson, Relaxation Runge-Kutta methods: conservation and stability for inner-product norms, SIAM J. Numer.
    Anal. 57(6), 2019, 2850-2870.
    H. Ranocha, D. I. Ketcheson, Relaxation Runge-Kutta methods for Hamiltonian problems, J. Sci. Comput. 84(1), 2020,
    17.
    H. Ranocha, L. Lóczi, D. I. Ketcheson, General relaxation methods for initial-value problems with application to
    multistep schemes, Numer. Math. 146(4), 2020, 875-906.
    """

    scheme: OneStep
    title: str = eqx.field(default="Relaxed", static=True)

    family: ClassVar[str] = "Relaxed"
    source: ClassVar[str] = "Ketcheson (2019)"
    doi: ClassVar[str] = "10.1137/19M1263662"
    keeps_energy = True

    def __check_init__(self):
        if not isinstance(self.scheme, OneStep):
            raise TypeError(
                f"Relaxed takes a study.OneStep, whose step adds to u and u̇, not "
                f"{getattr(self.scheme, 'title', self.scheme)!r}."
            )

    def refusal(self, problem):
        if not problem.conservative or problem.potential is None:
            return (
                f"'{self.title}' needs a problem with a potential and without damping, load and history, "
                f"which '{problem.title}' is not."
            )
        return super().refusal(problem)

    def start(self, problem, u0, v0, dt):
        inner, effort = self.scheme.start(problem, u0, v0, dt)
        return Late(inner, jnp.zeros((), u0.dtype)), effort

    def step(self, problem, state, t, dt) -> tuple[Late, Effort]:
        old, h = state.inner, dt - state.lead
        new, effort = self.scheme.step(problem, old, t + state.lead, h)

        def scaled(gamma):
            return jax.tree.map(lambda before, after: before + gamma * (after - before), old, new)

        def energy(gamma):
            candidate = scaled(gamma)
            return problem.energy(candidate.u, candidate.v)

        gamma, search_effort = _relaxation(energy)
        return Late(scaled(gamma), (gamma - 1) * h), effort.then(search_effort)
