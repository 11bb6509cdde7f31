"""The springs of Xie (1996)."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from study.mechanics.definition import Problem
from study.problem.naming import named


class CubicSpring(eqx.Module):
    """The Duffing spring p(u) = S1 u (1 + S2 u²) of Xie (1996), eqs (2) and (4)."""

    # NumPy numbers are arguments of a compiled program, which all springs share; Python numbers would be constants
    S1: float = eqx.field(converter=np.float64)
    S2: float = eqx.field(converter=np.float64)

    def force(self, u):
        """S1 u (1 + S2 u²)."""
        return self.S1 * u * (1 + self.S2 * u * u)

    def potential(self, u):
        """½ S1 u² + ¼ S1 S2 u⁴."""
        return 0.5 * self.S1 * u * u * (1 + 0.5 * self.S2 * u * u)


def _log_cosh(u):
    """Ln cosh u = |u| − ln(1 + t) with t = tanh |u|, which does not overflow.

    ln(1 + t) = 2 artanh s = 2 (s + s³/3 + s⁵/5 + ...) with s = t/(2 + t) ≤ 1/3. The terms up to s³¹ leave an error of
    round-off. This sum takes a seventh of the time of XLA's logarithm, which would dominate the cost of a step.
    """
    t = jnp.abs(jnp.tanh(u))
    s = t / (2 + t)
    # two Horner schemes in s⁴, each for every other term: the chain of dependent operations is half as long
    z = s * s
    even: Any = 0.0
    odd: Any = 0.0
    for n in range(29, 0, -4):
        even, odd = even * (z * z) + 1 / n, odd * (z * z) + 1 / (n + 2)
    return jnp.abs(u) - 2 * s * (even + z * odd)


class TanhSpring(eqx.Module):
    """The softening spring p(u) = S tanh u of Xie (1996), eqs (3) and (5)."""

    S: float = eqx.field(converter=np.float64)

    def force(self, u):
        """S tanh u."""
        return self.S * jnp.tanh(u)

    def potential(self, u):
        """S ln cosh u."""
        return self.S * _log_cosh(u)


def _oscillator(spring: CubicSpring | TanhSpring, u0: float, title: str) -> Problem:
    """Free oscillation of a unit mass on the spring, released from rest at ``u0``."""
    return Problem(force=spring.force, potential=spring.potential, u0=u0, title=title)


@named(period=0.15, printed=True)
def hardening() -> Problem:
    """Hardening spring, section 3.1: S1 = 100, S2 = 10, u₀ = 1.5."""
    return _oscillator(CubicSpring(100.0, 10.0), u0=1.5, title="hardening spring")


@named(period=1.14, printed=True)
def softening() -> Problem:
    """Softening spring, section 3.2: S = 100, u₀ = 4."""
    return _oscillator(TanhSpring(100.0), u0=4.0, title="softening spring")


@named(period=1.8, printed=True)
def softening_large() -> Problem:
    """The softening spring at the amplitude of section 4: u₀ = 10."""
    return _oscillator(TanhSpring(100.0), u0=10.0, title="softening spring, large amplitude")


@named(period=7.3, printed=True)
def double_well() -> Problem:
    """Double well, section 4: S1 = −½, S2 = −1, u₀ = 0.5."""
    return _oscillator(CubicSpring(-0.5, -1.0), u0=0.5, title="double well")
