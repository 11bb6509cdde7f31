"""Errors of the energy, and of the balance of energies."""

import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.elementwise import compensated_sum
from study.algebra.matrices import times
from study.mechanics.balance import load
from study.mechanics.definition import Problem
from study.observer.base import Record, Reduction

#: Number of points of the integral of a force over the displacement.
POINTS = 4096

#: Round-off of an energy, as a fraction of it.
ROUND_OFF = 1e-9


def relative_energy_error(problem: Problem, initial, state):
    """Signed relative error of the energy, (E − E₀)/|E₀|."""
    reference = problem.at(initial).energy(initial.u, initial.v)
    return (problem.energy(state.u, state.v) - reference) / jnp.abs(reference)


class MaxEnergyError(Reduction):
    """Largest relative error of the energy over the run, Xie (1996), eq. (17)."""

    variables = {
        "max_energy_error": {
            "long_name": "largest relative error of the total energy, eq. (17) of Xie (1996)",
            "units": "1",
        }
    }
    needs_energy = True

    def start(self, problem, state):
        return problem.energy(state.u, state.v), jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        reference, largest = carried
        return reference, jnp.maximum(largest, jnp.abs(problem.energy(state.u, state.v) - reference))

    def result(self, carried, problem, state):
        reference, largest = carried
        return {"max_energy_error": largest / jnp.abs(reference)}


class MeanEnergyError(Reduction):
    """Mean of the signed relative error of the energy over all steps of the run, by a compensated sum.

    Oscillations of the energy along the orbit cancel in the mean; drifts do not. The mean of a drift linear in time is
    half of its final value. For a random walk, the standard deviation of the mean is 1/√3 of that of the final value.
    """

    variables = {"mean_energy_error": {"long_name": "mean signed relative error of the total energy", "units": "1"}}
    needs_energy = True
    needs_equal_steps = True

    def start(self, problem, state):
        return problem.energy(state.u, state.v), jnp.zeros((), int), jnp.zeros(()), jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        reference, steps, total, lost = carried
        total, lost = compensated_sum(total, problem.energy(state.u, state.v) - reference, lost)
        return reference, steps + 1, total, lost

    def result(self, carried, problem, state):
        reference, steps, total, _ = carried
        return {"mean_energy_error": total / (steps.astype(float) * jnp.abs(reference))}


class EnergyDrift(Reduction):
    """Signed relative error of the energy at the end of the run."""

    variables = {"energy_drift": {"long_name": "signed relative error of the total energy at the end", "units": "1"}}
    needs_energy = True

    def start(self, problem, state):
        return state

    def update(self, carried, problem, state, t, effort):
        return carried

    def result(self, carried, problem, state):
        return {"energy_drift": relative_energy_error(problem, carried, state)}


class ChangeOfEnergy(Reduction):
    r"""Change of a constant energy between the ends of a run, and its largest kinetic energy, for a warning.

    Without a potential, the change of the stored energy of one unknown is :math:`\int p\,du` from u₀ to the end, by the
    midpoint rule. The change is reduced by the error of this rule, which its difference from the rule with half the
    points shows.
    """

    variables = {"change_of_energy": {}, "largest_kinetic_energy": {}}

    def refusal(self, problem):
        known = problem.potential is not None or not np.ndim(problem.u0)
        return None if problem.conservative and known else f"the energy of '{problem.title}' need not be constant."

    def start(self, problem, state):
        kinetic = _kinetic(problem, state)
        return state.u, kinetic, kinetic

    def update(self, carried, problem, state, t, effort):
        u0, kinetic, largest = carried
        return u0, kinetic, jnp.maximum(largest, _kinetic(problem, state))

    def result(self, carried, problem, state):
        u0, kinetic, largest = carried
        if problem.potential is not None:
            stored, stored_end = problem.stored_energy(u0), problem.stored_energy(state.u)
            change, error = stored_end - stored, ROUND_OFF * (jnp.abs(stored) + jnp.abs(stored_end))
        else:
            change, half = (_work(problem, u0, state.u, points) for points in (POINTS, POINTS // 2))
            error = 4 * jnp.abs(change - half)
        change += _kinetic(problem, state) - kinetic
        change = jnp.sign(change) * jnp.maximum(jnp.abs(change) - error, 0.0)
        return dict(zip(self.variables, (change, largest), strict=True))


def _kinetic(problem: Problem, state):
    return jnp.vdot(state.v, problem.momentum(state.v)) / 2


def _work(problem: Problem, start, end, points: int):
    """Integral of the internal force of one unknown between two displacements."""
    u = start + (end - start) * (jnp.arange(points, dtype=float) + 0.5) / points
    return jnp.mean(jax.vmap(problem.static_force)(u)) * (end - start)


class EnergyBalance(Reduction):
    r"""Largest error of the balance E + D − W = E₀ of energy E, dissipation D and work W of the load.

    The error is the largest :math:`|E + D - W - E_0|` relative to :math:`|E_0| + \max|W|`, and zero if the balance
    holds exactly. Dissipation and work over a step follow from the mean of the forces at both ends,

    .. math::

        \Delta D = \tfrac12 (u_1 - u_0)^T C (\dot u_0 + \dot u_1), \quad \Delta W = \tfrac12 (u_1 - u_0)^T (f_0 + f_1)

    which is of second order, and exact for the trapezoidal rule on a linear structure. A force that depends on the
    velocity or a history dissipates too, :math:`\Delta D = \tfrac12 (u_1 - u_0)^T (p_0 + p_1) - \Delta V`. Without a
    potential the stored energy counts as dissipated, V = 0, and the error is relative to
    :math:`|E_0| + \max(\max|W|, \max|D|)`. If the force takes a velocity or a history, the formulas of the trapezoidal
    rule for u and u̇ imply this balance to round-off at any step size. The balance then does not measure the accuracy
    of the trapezoidal rule.

    References
    ----------
    T. Belytschko, W. K. Liu, B. Moran, Nonlinear finite elements for continua and structures, Wiley, 2000, section
    6.2.3.
    """

    variables = {
        "max_energy_imbalance": {
            "long_name": "largest error of the balance of energies, dissipation and work",
            "units": "1",
        },
        "dissipated_energy": {"long_name": "energy dissipated by damping and internal force", "units": "1"},
        "work_of_load": {"long_name": "work done by the load", "units": "1"},
    }

    def refusal(self, problem):
        if problem.potential is None and not problem.dissipative:
            return f"{', '.join(self.variables)} of '{problem.title}' needs Problem(potential=...)."
        return super().refusal(problem)

    def _at(self, problem, state, t):
        """Values at one time that the balance uses: u, u̇, f, and for a dissipative force also (p, V)."""
        if not problem.dissipative:
            return state.u, state.v, load(problem, t), ()
        stored = jnp.zeros(()) if problem.potential is None else problem.stored_energy(state.u)
        return state.u, state.v, load(problem, t), (problem.internal_force(state.u, state.v), stored)

    def _energy(self, problem, state):
        if problem.potential is None:
            return _kinetic(problem, state)
        return problem.energy(state.u, state.v)

    def start(self, problem, state):
        zero = jnp.zeros(())
        return self._at(problem, state, 0.0), self._energy(problem, state), (zero, zero), (zero, zero)

    def update(self, carried, problem, state, t, effort):
        (u, v, f, force), at_start, (dissipated, work), (imbalance, most_work) = carried
        end = self._at(problem, state, t)
        way = state.u - u
        if problem.damping is not None:
            dissipated += jnp.vdot(way, times(problem.damping, v + state.v)) / 2
        if problem.dissipative:
            (p, stored), (p_now, stored_now) = force, end[3]
            dissipated += jnp.vdot(way, p + p_now) / 2 - (stored_now - stored)
        if problem.load is not None:
            work += jnp.vdot(way, f + end[2]) / 2
        handled = self._energy(problem, state) + dissipated
        imbalance = jnp.maximum(imbalance, jnp.abs(handled - work - at_start))
        most_work = jnp.maximum(most_work, jnp.abs(work))
        if problem.potential is None:
            most_work = jnp.maximum(most_work, jnp.abs(dissipated))
        return end, at_start, (dissipated, work), (imbalance, most_work)

    def result(self, carried, problem, state):
        _, at_start, (dissipated, work), (imbalance, most_work) = carried
        error = jnp.where(imbalance == 0, 0.0, imbalance / (jnp.abs(at_start) + most_work))
        return dict(zip(self.variables, (error, dissipated, work), strict=True))


class EnergyError(Record):
    """Signed relative error of the energy along time."""

    variables = {"energy_error": {"long_name": "signed relative error of the total energy", "units": "1"}}
    needs_energy = True

    def sample(self, problem, initial, state, t):
        return {"energy_error": relative_energy_error(problem, initial, state)}
