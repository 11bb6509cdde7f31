"""What a run may be asked for. Each observer is small and streams: it keeps no trajectory unless it is one."""

import abc
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp

from study.equilibrium import Effort
from study.problem import Problem
from study.registry import Registry


class Observer(eqx.Module):
    """Something to know of a run: a :class:`Reduction` gives one value a run, a :class:`Record` one value a sample."""

    #: Attributes of the variables that the observer gives, by the variables' names.
    variables: ClassVar[dict[str, dict[str, str]]]
    #: Whether the problem must have a potential.
    needs_energy: ClassVar[bool] = False


class Reduction(Observer):
    """A value that is updated with every step."""

    @abc.abstractmethod
    def start(self, problem: Problem, state) -> Any:
        """What is carried along, at t = 0."""

    @abc.abstractmethod
    def update(self, carried, problem: Problem, state, effort: Effort) -> Any:
        """What is carried along, one step later."""

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

    def update(self, carried, problem, state, effort):
        reference, largest = carried
        return reference, jnp.maximum(largest, jnp.abs(problem.energy(state.u, state.v) - reference))

    def result(self, carried, problem, state):
        reference, largest = carried
        return {"max_energy_error": 100 * largest / jnp.abs(reference)}


class EnergyDrift(Reduction):
    """Signed relative error of the energy at the end of the run in percent."""

    variables = {
        "energy_drift": {"long_name": "signed relative error of the total energy at the end", "units": "percent"}
    }
    needs_energy = True

    def start(self, problem, state):
        return state

    def update(self, carried, problem, state, effort):
        return carried

    def result(self, carried, problem, state):
        return {"energy_drift": relative_energy_error(problem, carried, state)}


class NewtonIterations(Reduction):
    """How many Newton iterations a run took, in all and at most in one step."""

    variables = {
        "newton_iterations": {"long_name": "Newton iterations in all steps", "units": "1"},
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
    }

    def start(self, problem, state):
        return jnp.zeros((), int), jnp.zeros((), int)

    def update(self, carried, problem, state, effort):
        total, most = carried
        return total + effort.iterations, jnp.maximum(most, effort.iterations)

    def result(self, carried, problem, state):
        return dict(zip(self.variables, carried, strict=True))


class Trajectory(Record):
    """Displacement and velocity along time."""

    variables = {
        "u": {"long_name": "displacement", "units": "1"},
        "v": {"long_name": "velocity", "units": "s-1"},
    }

    def sample(self, problem, initial, state):
        return {"u": state.u, "v": state.v}


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
        "energy_drift": EnergyDrift(),
        "newton_iterations": NewtonIterations(),
    },
)
