"""Loads f(t) of the named problems."""

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from study.problem.definition import Problem


class HarmonicLoad(eqx.Module):
    """A load amplitude cos(ωt − phase), its amplitude of the shape of the displacement."""

    amplitude: float | np.ndarray = eqx.field(converter=np.asarray)
    frequency: float = eqx.field(converter=np.float64)
    phase: float = eqx.field(converter=np.float64)

    def __call__(self, t):
        """The load at the time t."""
        return self.amplitude * jnp.cos(self.frequency * t - self.phase)


class _Scaled(eqx.Module):
    """A load times a factor."""

    load: Callable
    factor: float = eqx.field(converter=np.float64)

    def __call__(self, t):
        return self.factor * self.load(t)


def excited(problem: Problem, factor: float) -> Problem:
    """The problem with ``factor`` times its initial velocity and its load, in the same compiled programs."""
    problem = eqx.tree_at(lambda p: p.v0, problem, factor * problem.v0)
    if problem.load is None:
        return problem
    return eqx.tree_at(lambda p: p.load, problem, _Scaled(problem.load, factor))


class Pulse(eqx.Module):
    """Half a sine of a force on the first unknown, then none."""

    n: int = eqx.field(static=True)
    amplitude: float = eqx.field(converter=np.float64)
    duration: float = eqx.field(converter=np.float64)

    def __call__(self, t):
        """The load at the time t."""
        pulse = jnp.where(t < self.duration, self.amplitude * jnp.sin(jnp.pi * t / self.duration), 0.0)
        return jnp.zeros(self.n).at[0].set(pulse)
