"""What a run may be asked for. Each observer is small and streams: it keeps no trajectory unless it is one."""

import abc
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp

from study.equilibrium import Effort, load
from study.linear import times
from study.problem import Problem
from study.registry import Registry
from study.summation import compensated_sum

#: A perturbation that has grown by so many powers of two was of round-off and is of the size of the motion.
APART = 33


class Observer(eqx.Module):
    """Something to know of a run: a :class:`Reduction` gives one value a run, a :class:`Record` one value a sample."""

    #: Attributes of the variables that the observer gives, by the variables' names.
    variables: ClassVar[dict[str, dict[str, str]]]
    #: Whether the problem must have a potential, or positions.
    needs_energy: ClassVar[bool] = False
    needs_positions: ClassVar[bool] = False
    #: Whether the run must have a neighbour along (:class:`study.schemes.Linearised`).
    needs_neighbour: ClassVar[bool] = False

    def lacking(self, problem: Problem) -> str | None:
        """The argument of :class:`Problem` that the observer needs and the problem was made without."""
        if self.needs_energy and problem.potential is None:
            return "potential"
        if self.needs_positions and problem.positions is None:
            return "positions"
        return None


class Reduction(Observer):
    """A value that is updated with every step."""

    @abc.abstractmethod
    def start(self, problem: Problem, state) -> Any:
        """What is carried along, at t = 0."""

    @abc.abstractmethod
    def update(self, carried, problem: Problem, state, t, effort: Effort) -> Any:
        """What is carried along, one step later, at the time ``t``."""

    @abc.abstractmethod
    def result(self, carried, problem: Problem, state) -> dict[str, Any]:
        """The values of ``variables`` at the end of the run, where ``state`` is the last one."""


class Record(Observer):
    """Values that are stored along time."""

    @abc.abstractmethod
    def sample(self, problem: Problem, initial, state) -> dict[str, Any]:
        """The values of ``variables`` at one time."""


def relative_energy_error(problem: Problem, initial, state):
    """Signed relative error of the energy in percent, 100 (E − E₀)/|E₀|; its size is Xie (1996), eq. (17)."""
    reference = problem.energy(initial.u, initial.v)
    return 100 * (problem.energy(state.u, state.v) - reference) / jnp.abs(reference)


class MaxEnergyError(Reduction):
    """Largest |E − E₀|/|E₀| over the run in percent, Xie (1996), eq. (17)."""

    variables = {"max_energy_error": {"long_name": "largest relative error of the total energy", "units": "percent"}}
    needs_energy = True

    def start(self, problem, state):
        return problem.energy(state.u, state.v), jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        reference, largest = carried
        return reference, jnp.maximum(largest, jnp.abs(problem.energy(state.u, state.v) - reference))

    def result(self, carried, problem, state):
        reference, largest = carried
        return {"max_energy_error": 100 * largest / jnp.abs(reference)}


class MeanEnergyError(Reduction):
    """Mean of (E − E₀)/|E₀| over all steps of the run in percent.

    The oscillation of the energy about the orbit cancels in it, and a drift does not: one that is linear in time shows
    by a half, a random walk by 1/√3 of its size at the end. The sum is compensated.
    """

    variables = {
        "mean_energy_error": {"long_name": "mean signed relative error of the total energy", "units": "percent"}
    }
    needs_energy = True

    def start(self, problem, state):
        return problem.energy(state.u, state.v), jnp.zeros((), int), jnp.zeros(()), jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        reference, steps, total, lost = carried
        total, lost = compensated_sum(total, problem.energy(state.u, state.v) - reference, lost)
        return reference, steps + 1, total, lost

    def result(self, carried, problem, state):
        reference, steps, total, _ = carried
        return {"mean_energy_error": 100 * total / (steps.astype(float) * jnp.abs(reference))}


class EnergyDrift(Reduction):
    """Signed relative error of the energy at the end of the run in percent."""

    variables = {
        "energy_drift": {"long_name": "signed relative error of the total energy at the end", "units": "percent"}
    }
    needs_energy = True

    def start(self, problem, state):
        return state

    def update(self, carried, problem, state, t, effort):
        return carried

    def result(self, carried, problem, state):
        return {"energy_drift": relative_energy_error(problem, carried, state)}


class EnergyBalance(Reduction):
    """What kinetic and potential energy, dissipation and the work of the load leave open: the drift of a scheme.

    Over a step the damping force C u̇ and the load f do the work of their mean at both ends on the way between,
    ΔD = ½ (u₁ − u₀)ᵀ C (u̇₀ + u̇₁) and ΔW = ½ (u₁ − u₀)ᵀ (f₀ + f₁), of second order, and for the trapezoidal rule on a
    linear structure exactly. The error is the largest |E + D − W − E₀| over what was put in, |E₀| and the largest |W|;
    zero where nothing was put in and nothing came of it.

    References
    ----------
    T. Belytschko, W. K. Liu, B. Moran, Nonlinear finite elements for continua and structures, Wiley, 2000,
    section 6.2.3.
    """

    variables = {
        "max_energy_imbalance": {
            "long_name": "largest error of the balance of energies, dissipation and work",
            "units": "percent",
        },
        "dissipated_energy": {"long_name": "energy dissipated by the damping", "units": "1"},
        "work_of_load": {"long_name": "work done by the load", "units": "1"},
    }
    needs_energy = True

    def start(self, problem, state):
        energy, zero = problem.energy(state.u, state.v), jnp.zeros(())
        return (state.u, state.v, load(problem, 0.0)), energy, (zero, zero), (zero, zero)

    def update(self, carried, problem, state, t, effort):
        (u, v, f), at_start, (dissipated, work), (imbalance, most_work) = carried
        way, now = state.u - u, load(problem, t)
        if problem.damping is not None:
            dissipated += jnp.vdot(way, times(problem.damping, v + state.v)) / 2
        if problem.load is not None:
            work += jnp.vdot(way, f + now) / 2
        handled = problem.energy(state.u, state.v) + dissipated
        imbalance = jnp.maximum(imbalance, jnp.abs(handled - work - at_start))
        most_work = jnp.maximum(most_work, jnp.abs(work))
        return (state.u, state.v, now), at_start, (dissipated, work), (imbalance, most_work)

    def result(self, carried, problem, state):
        _, at_start, (dissipated, work), (imbalance, most_work) = carried
        error = jnp.where(imbalance == 0, 0.0, 100 * imbalance / (jnp.abs(at_start) + most_work))
        return dict(zip(self.variables, (error, dissipated, work), strict=True))


def _momenta(problem: Problem, state):
    """Linear and angular momentum of every point, (points, directions) and (points, 3)."""
    points, directions = jnp.shape(problem.positions)
    p = problem.momentum(state.v).reshape(points, directions)
    x = problem.positions + state.u.reshape(points, directions)
    in_space = [(0, 0), (0, 3 - directions)]
    return p, jnp.cross(jnp.pad(x, in_space), jnp.pad(p, in_space))


class MomentumErrors(Reduction):
    """Largest change of linear and of angular momentum, over the largest sum of the points' own.

    NaN where no point has any.
    """

    variables = {
        "max_linear_momentum_error": {"long_name": "largest change of linear momentum, relative", "units": "1"},
        "max_angular_momentum_error": {"long_name": "largest change of angular momentum, relative", "units": "1"},
    }
    needs_positions = True

    def start(self, problem, state):
        momenta = _momenta(problem, state)
        return [m.sum(axis=0) for m in momenta], jnp.zeros(2), jnp.stack([_sizes(m) for m in momenta])

    def update(self, carried, problem, state, t, effort):
        at_start, errors, scales = carried
        momenta = _momenta(problem, state)
        changes = [jnp.linalg.norm(m.sum(axis=0) - before) for m, before in zip(momenta, at_start, strict=True)]
        return (
            at_start,
            jnp.maximum(errors, jnp.stack(changes)),
            jnp.maximum(scales, jnp.stack([_sizes(m) for m in momenta])),
        )

    def result(self, carried, problem, state):
        _, errors, scales = carried
        return dict(zip(self.variables, errors / scales, strict=True))


def _sizes(momenta):
    """Sum of the points' own."""
    return jnp.linalg.norm(momenta, axis=1).sum()


def _crossing(before, after, dt, level):
    """Where in 0 < s ≤ 1 a step comes up to a level, for each unknown.

    The inverse of the displacement is the cubic that has the step's displacements and, by the velocities, its slopes,
    which are kept within what leaves it monotonic (Fritsch and Carlson, 1980): s is of fourth order in the step.
    """
    (u0, v0), (u1, v1) = before, after
    way = jnp.where(u1 > u0, u1 - u0, 1.0)
    x = (level - u0) / way
    start, end = (jnp.clip(way / (dt * v), 0.0, 3.0) for v in (v0, v1))
    return x * x * (3 - 2 * x) + x * (1 - x) * (start * (1 - x) - end * x)


class Oscillations(Reduction):
    """Upward crossings of a level by each unknown: how many, when the last came, and their mean period.

    The crossing i comes at the time (k_i + s_i) Δt, with the step k_i as a whole number and the part s_i of a step by
    a cubic that displacements and velocities at both ends define; the mean period is ((k_n − k_1) + (s_n − s_1))
    Δt/(n − 1). What interpolation leaves does not grow with the length of the run, nor does single precision lose the
    count of the steps.

    Parameters
    ----------
    level
        The displacement that is crossed.
    """

    level: float = 0.0

    variables = {
        "crossings": {"long_name": "upward crossings", "units": "1"},
        "last_crossing_step": {"long_name": "whole steps before the last upward crossing", "units": "1"},
        "last_crossing_part": {"long_name": "part of a step from there to the last upward crossing", "units": "1"},
        "mean_period": {"long_name": "mean time between upward crossings", "units": "s"},
    }

    def start(self, problem, state):
        none, now = jnp.zeros(state.u.shape, int), (state.u, state.v)
        never = none, now, now
        return (jnp.zeros((), int), jnp.zeros(())), now, none, never, never

    def update(self, carried, problem, state, t, effort):
        (step, dt), before, crossings, first, last = carried
        dt, now = jnp.where(step == 0, t, dt), (state.u, state.v)
        crossed = (before[0] < self.level) & (state.u >= self.level)
        # interpolated at the end of the run only
        last = jax.tree.map(partial(jnp.where, crossed), (step, before, now), last)
        first = jax.tree.map(partial(jnp.where, crossings == 0), last, first)
        return (step + 1, dt), now, crossings + crossed.astype(int), first, last

    def result(self, carried, problem, state):
        (_, dt), _, crossings, (first, *start), (last, *end) = carried
        since_first, part = _crossing(*start, dt, self.level), _crossing(*end, dt, self.level)
        steps = (last - first).astype(float) + (part - since_first)
        period = jnp.where(crossings > 1, dt * steps / (crossings - 1).astype(float), jnp.nan)
        return dict(zip(self.variables, (crossings, last, part, period), strict=True))


class NewtonIterations(Reduction):
    """How many Newton iterations a run took, in all and at most in one step."""

    variables = {
        "newton_iterations": {"long_name": "Newton iterations in all steps", "units": "1"},
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
    }

    def start(self, problem, state):
        return jnp.zeros((), int), jnp.zeros((), int)

    def update(self, carried, problem, state, t, effort):
        total, most = carried
        return total + effort.iterations, jnp.maximum(most, effort.iterations)

    def result(self, carried, problem, state):
        return dict(zip(self.variables, carried, strict=True))


class LyapunovExponent(Reduction):
    """Largest Lyapunov exponent of the numerical map over the run, and when neighbours are far apart.

    λ = ln |δ(t)|/t with the distance δ of displacement and velocity of :class:`study.schemes.Linearised`, whose
    displacement is of length one at the start. A regular motion has λ of the order of ln t/t. Neighbours are far apart
    where a component of δ is 2³³ times as large, 8.6e9.
    """

    variables = {
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"},
        "apart_from": {"long_name": "time from which on a perturbation is 8.6e9 times as large", "units": "s"},
    }
    needs_neighbour = True

    def start(self, problem, state):
        return jnp.zeros(()), jnp.full((), jnp.inf)

    def update(self, carried, problem, state, t, effort):
        _, first = carried
        return t, jnp.where(state.exponent >= APART, jnp.minimum(first, t), jnp.inf)

    def result(self, carried, problem, state):
        t, first = carried
        size = jnp.sqrt(jnp.sum(state.distance.u**2 + state.distance.v**2))
        growth = jnp.log(size) + jnp.log(2.0) * state.exponent.astype(size.dtype)
        return {"lyapunov_exponent": growth / t, "apart_from": first}


class Trajectory(Record):
    """Displacement and velocity along time."""

    variables = {
        "u": {"long_name": "displacement", "units": "1"},
        "v": {"long_name": "velocity", "units": "s-1"},
    }

    def sample(self, problem, initial, state):
        return {"u": state.u, "v": state.v}


class Quantity(Record):
    """A number of your own along time, a function of u and u̇.

    Parameters
    ----------
    function
        Takes u and u̇, each of shape () or (n,), and returns a number.
    name, long_name, units
        What the dataset calls it.
    """

    function: Callable
    name: str = eqx.field(static=True)
    long_name: str = eqx.field(static=True)
    units: str = eqx.field(default="1", static=True)

    @property
    def variables(self) -> dict[str, dict[str, str]]:  # type: ignore[override]
        return {self.name: {"long_name": self.long_name, "units": self.units}}

    def sample(self, problem, initial, state):
        return {self.name: self.function(state.u, state.v)}


class EnergyError(Record):
    """Signed relative error of the energy along time in percent."""

    variables = {"energy_error": {"long_name": "signed relative error of the total energy", "units": "percent"}}
    needs_energy = True

    def sample(self, problem, initial, state):
        return {"energy_error": relative_energy_error(problem, initial, state)}


#: Every observer that can be called by name.
observers: Registry[Observer] = Registry(
    "observer",
    {
        "trajectory": Trajectory(),
        "energy_error": EnergyError(),
        "max_energy_error": MaxEnergyError(),
        "mean_energy_error": MeanEnergyError(),
        "energy_drift": EnergyDrift(),
        "energy_balance": EnergyBalance(),
        "momentum_errors": MomentumErrors(),
        "oscillations": Oscillations(),
        "newton_iterations": NewtonIterations(),
        "lyapunov_exponent": LyapunovExponent(),
    },
)
