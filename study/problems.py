"""The named problems of the study, each with its parameters and its source."""

from dataclasses import replace
from functools import partial

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from study import structures
from study.problem import Problem
from study.registry import Registry


class CubicSpring(eqx.Module):
    """p(u) = S1 u (1 + S2 u²), the Duffing spring of Xie (1996), eqs (2) and (4)."""

    # NumPy's numbers are arguments of what is compiled, Python's are constants in it: so two springs share a program
    S1: float = eqx.field(converter=np.float64)
    S2: float = eqx.field(converter=np.float64)

    def force(self, u):
        """S1 u (1 + S2 u²)."""
        return self.S1 * u * (1 + self.S2 * u * u)

    def potential(self, u):
        """½ S1 u² + ¼ S1 S2 u⁴."""
        return 0.5 * self.S1 * u * u * (1 + 0.5 * self.S2 * u * u)


def _log_cosh(u):
    """Logarithm of cosh u, |u| − ln(1 + t) with t = tanh |u|, which no u overflows.

    That of 1 + t is 2 artanh s = 2 (s + s³/3 + s⁵/5 + ...) with s = t/(2 + t) ≤ 1/3. So many terms leave nothing but
    round-off, and take a seventh of the time of the compiler's own logarithm, by far the dearest part of a step.
    """
    t = jnp.abs(jnp.tanh(u))
    s = t / (2 + t)
    # in s⁴, every other term for itself: a run waits for a chain of half the length
    z = s * s
    even = odd = 0.0
    for n in range(29, 0, -4):
        even, odd = even * (z * z) + 1 / n, odd * (z * z) + 1 / (n + 2)
    return jnp.abs(u) - 2 * s * (even + z * odd)


class TanhSpring(eqx.Module):
    """p(u) = S tanh u, the softening spring of Xie (1996), eqs (3) and (5)."""

    S: float = eqx.field(converter=np.float64)

    def force(self, u):
        """S tanh u."""
        return self.S * jnp.tanh(u)

    def potential(self, u):
        """S ln cosh u."""
        return self.S * _log_cosh(u)


def _oscillator(title: str, spring: CubicSpring | TanhSpring, u0: float) -> Problem:
    return Problem(force=spring.force, potential=spring.potential, u0=u0, title=title)


#: Every problem that can be called by name, made and checked when it is first asked for.
problems: Registry[Problem] = Registry(
    "problem",
    {},
    made_by={
        "hardening": partial(_oscillator, "hardening spring", CubicSpring(100.0, 10.0), u0=1.5),
        "softening": partial(_oscillator, "softening spring", TanhSpring(100.0), u0=4.0),
        "softening_large": partial(_oscillator, "softening spring, large amplitude", TanhSpring(100.0), u0=10.0),
        "double_well": partial(_oscillator, "double well", CubicSpring(-0.5, -1.0), u0=0.5),
        "pendulum": structures.pendulum,
        "duffing_periodic": partial(structures.duffing, 0.2, "Duffing, periodic"),
        "duffing_chaotic": partial(structures.duffing, 0.5, "Duffing, chaotic"),
        "stiff_soft": structures.stiff_soft,
        "stiff_soft_sine": structures.stiff_soft_sine,
        "elastic_pendulum": structures.elastic_pendulum,
        "fpu_chain": structures.fpu_chain,
        "toda_chain": structures.toda_chain,
        "impact_bar": structures.impact_bar,
        "spinning_truss": structures.spinning_truss,
        "cantilever_truss": structures.cantilever_truss,
    },
)


def untitled(name: str) -> Problem:
    """A problem without its title, which alone keeps springs of one kind from sharing a program in one process."""
    return replace(problems[name], title="untitled")


#: The time by which the steps of each structure are counted: a period of its load or of its motion, where there is one.
periods = {
    "pendulum": 33.7210,
    "duffing_periodic": 2 * np.pi / 1.2,
    "duffing_chaotic": 2 * np.pi / 1.2,
    "stiff_soft": 2 * np.pi / 1.2,
    "stiff_soft_sine": 2 * np.pi / 1.2,
    # one turn
    "elastic_pendulum": 2 * np.pi * 3.0443 / 7.72,
    # of the soft springs, about
    "fpu_chain": 2 * np.pi,
    # the shortest of a linear chain
    "toda_chain": np.pi,
    # a wave crosses the bar
    "impact_bar": 1.0,
    # one turn
    "spinning_truss": 2 * np.pi,
    # of its first mode, about
    "cantilever_truss": 1.0,
}

#: The periods that the paper prints and takes its step sizes from (sections 3.1, 3.2 and 4): two or three digits.
printed_periods = {"hardening": 0.15, "softening": 1.14, "softening_large": 1.8, "double_well": 7.3}
