"""Loads f(t) of the named problems."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import Scalar, Vector, VectorLike, as_float64
from study.mechanics.definition import Problem
from study.mechanics.ground import GroundLoad, GroundMotion
from study.mechanics.scan import INTERVALS, Times, beside_jumps, events


class HarmonicLoad(eqx.Module):
    """A harmonic load f(t) = amplitude · cos(ωt − phase), with an amplitude of the shape of u."""

    amplitude: VectorLike = eqx.field(converter=as_float64)
    frequency: float = eqx.field(converter=np.float64)
    phase: float = eqx.field(converter=np.float64)

    def __call__(self, t: Scalar) -> Vector:
        """f(t)."""
        return self.amplitude * jnp.cos(self.frequency * t - self.phase)


class _Scaled(eqx.Module):
    """A load multiplied by a factor."""

    load: Callable
    factor: float = eqx.field(converter=np.float64)

    def __call__(self, t):
        return self.factor * self.load(t)

    @property
    def kinks(self):
        return getattr(self.load, "kinks", ())


def excited(problem: Problem, factor: float, displaced: bool = False) -> Problem:
    """The problem with its initial velocity, its load and its ground motion multiplied by ``factor``.

    With ``displaced``, its initial displacement is multiplied too. Problems that differ in the factor share one
    compiled program.
    """
    problem = eqx.tree_at(lambda p: p.v0, problem, factor * problem.v0)
    if displaced:
        problem = eqx.tree_at(lambda p: p.u0, problem, factor * problem.u0)
    if problem.ground is not None:
        problem = eqx.tree_at(lambda p: p.ground, problem, problem.ground.scaled(factor))
    if problem.load is None:
        return problem
    load, previous = (
        (problem.load.load, problem.load.factor) if isinstance(problem.load, _Scaled) else (problem.load, 1.0)
    )
    return eqx.tree_at(lambda p: p.load, problem, _Scaled(load, factor * previous)).examined()


def restarted(problem: Problem, factor: float) -> Problem:
    """The problem with its initial velocity multiplied by ``factor``.

    At rest the initial displacement is multiplied instead, and from equilibrium the load. Multiplying all of them would
    only scale the motion of a mass on a stop. Such problems share one compiled program.
    """
    if np.any(problem.v0):
        return eqx.tree_at(lambda p: p.v0, problem, factor * problem.v0)
    if np.any(problem.u0):
        return eqx.tree_at(lambda p: p.u0, problem, factor * problem.u0)
    return excited(problem, factor)


def under_stochastic_record(problem: Problem, seed: int) -> Problem:
    """The problem under a stochastic record with the title, samples and largest acceleration of its own record.

    Such problems share one compiled program.
    """

    def grounds(member: Any) -> tuple[GroundMotion, GroundMotion]:
        load: Any = member.load.load if isinstance(member.load, _Scaled) else member.load
        return member.ground, load.ground

    record = grounds(problem)[0]
    ground = GroundMotion.kanai_tajimi(seed, duration=record.duration, dt=float(record.dt))
    scale = abs(record.acceleration).max() / abs(ground.acceleration).max()
    ground = GroundMotion(scale * ground.acceleration, record.dt, title=record.title, source=record.source)
    return eqx.tree_at(grounds, problem, (ground, ground)).examined()


def times_of(load: Callable | None, duration: float, intervals: int = INTERVALS, sides: bool = False) -> Times:
    """Times within ``duration`` at which steps should end: the kinks that a load declares, or :func:`events` of a load.

    Of a sum of a ground motion and a load, both parts are considered. A scan has ``intervals`` intervals. With
    ``sides`` there is a time on either side of each jump.
    """
    if load is None:
        return np.zeros(0)
    if isinstance(load, _Scaled):
        return times_of(load.load, duration, intervals, sides)
    if isinstance(load, GroundLoad):
        return np.union1d(_within(load.ground.kinks, duration), times_of(load.load, duration, intervals, sides))
    if np.size(declared := getattr(load, "kinks", ())):
        times = np.asarray(declared, float).ravel()
    else:
        times = events(load, duration, intervals)
    times = _within(times, duration)
    return _within(beside_jumps(load, times, duration), duration) if sides else times


def _within(times: Times, duration: float) -> Times:
    return times[(times > 0) & (times < duration)]


def times_of_problem(problem: Problem, duration: float, intervals: int = INTERVALS, sides: bool = False) -> Times:
    """Times within ``duration`` at which steps should end: those of the load, and of a force that takes the time.

    The force is scanned at the displacement and velocity at the start.
    """
    times = times_of(problem.load, duration, intervals, sides)
    if not problem.takes_time:
        return times

    def force(t):
        return problem.at_time(t).internal_force(problem.u0, problem.v0)

    force_times = events(force, duration, intervals)
    return np.union1d(times, _within(beside_jumps(force, force_times, duration), duration) if sides else force_times)


def record_of(load: Callable | None) -> dict[str, str]:
    """Name and source of the ground motion in a load, as attributes of a dataset.

    The dict is empty if the load has no ground motion, or if the source is not known.
    """
    load = load.load if isinstance(load, _Scaled) else load
    if not isinstance(load, GroundLoad) or not load.ground.source:
        return {}
    return {"record": load.ground.title, "record_source": load.ground.source}


class HalfSine(eqx.Module):
    """Half a period of a sine, f(t) = amplitude · sin(πt/duration), then zero, with an amplitude of the shape of u."""

    amplitude: VectorLike = eqx.field(converter=as_float64)
    duration: float = eqx.field(converter=np.float64)

    def __call__(self, t: Scalar) -> Vector:
        """f(t)."""
        return jnp.where(t < self.duration, self.amplitude * jnp.sin(jnp.pi * t / self.duration), 0.0)

    @property
    def kinks(self) -> tuple[float, ...]:
        """The time ``duration``, at which the slope jumps."""
        return (self.duration,)
