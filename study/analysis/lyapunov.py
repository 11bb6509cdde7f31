"""Lyapunov exponents of the numerical map of a scheme under a periodic load, and the mean square of its motion."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Float

from study.marching.program import unlabelled
from study.mechanics.definition import Problem
from study.scheme.base import Scheme
from study.scheme.contract import started, stepped

#: Values of each run, of shape (runs, 2n) or (runs, n).
OfRuns = Float[np.ndarray, "runs _"]


class Statistics(NamedTuple):
    """Statistics of runs of a problem with n unknowns.

    Attributes
    ----------
    exponents
        Lyapunov exponents in descending order, in 1/s, (runs, 2n).
    mean_square
        Mean square of the displacement, (runs, n).
    """

    exponents: OfRuns
    mean_square: OfRuns


@jax.enable_x64(True)
def statistics(
    problem: Problem,
    scheme: Scheme,
    u0: OfRuns,
    period: float,
    steps_per_period: int,
    periods: int,
    skipped: int,
) -> Statistics:
    r"""Lyapunov exponents and mean squares of runs side by side; NaN if a run fails.

    A basis of initial displacements and velocities is carried by the derivative of the step in the whole state of the
    scheme. After each period a QR decomposition of the displacements and velocities of the basis makes it orthogonal;
    the mean logarithms of the diagonal of R are the exponents. The sum of the exponents is the mean rate at which a
    volume of states grows: −tr(M⁻¹C) of the equation of motion, less what the scheme dissipates.

    Parameters
    ----------
    u0
        Initial displacements.
    period
        Period of the load in s.
    periods, skipped
        Length of the runs in periods, and number of first periods that are left out.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical
    systems and for Hamiltonian systems; a method for computing all of them. Part 2: numerical application, Meccanica
    15(1), 1980, 21-30.
    """
    dt = period / steps_per_period
    counts = (jnp.asarray(number) for number in (steps_per_period, periods, skipped))  # one compilation serves all
    logarithms, squares = _marched(problem, unlabelled(scheme), jnp.asarray(u0), jnp.asarray(dt), *counts)
    counted = periods - skipped
    return Statistics(np.asarray(logarithms) / (counted * period), np.asarray(squares) / (counted * steps_per_period))


@eqx.filter_jit
def _marched(problem, scheme, u0, dt, steps_per_period, periods, skipped):
    """Sums of the logarithms (runs, 2n) and of the squares of the displacement (runs, n) after the first periods."""
    n, shape = u0.shape[1], jnp.shape(problem.u0)

    def start(motion):
        u, v = (part.reshape(shape) for part in jnp.split(motion, 2))
        return started(scheme, problem, u, v, dt)[0]

    def started_basis(u):
        motion = jnp.concatenate([u, jnp.broadcast_to(problem.v0, shape).ravel()])
        return start(motion), jax.vmap(lambda direction: jax.jvp(start, (motion,), (direction,))[1])(jnp.eye(2 * n))

    def step(state, basis, t):
        def pushed(direction):
            return jax.jvp(lambda state: stepped(scheme, problem, state, t, dt)[0], (state,), (direction,))

        return jax.vmap(pushed, out_axes=(None, 0))(basis)

    def orthogonal(basis):
        rows = jnp.concatenate([basis.u.reshape(2 * n, n), basis.v.reshape(2 * n, n)], axis=1)
        triangle = jnp.linalg.qr(rows.T, mode="r").T

        def solved(part):
            flat = jax.scipy.linalg.solve_triangular(triangle, part.reshape(2 * n, -1), lower=True)
            return flat.reshape(part.shape)

        return jax.tree.map(solved, basis), jnp.log(jnp.abs(jnp.diagonal(triangle)))

    def over_a_period(k, carried):
        state, basis, logarithms, squares = carried

        def next_step(i, carried):
            state, basis, squares = carried
            t = (k * steps_per_period + i).astype(float) * dt
            state, basis = jax.vmap(step, (0, 0, None))(state, basis, t)
            return state, basis, squares + state.u.reshape(u0.shape) ** 2

        state, basis, more = lax.fori_loop(0, steps_per_period, next_step, (state, basis, jnp.zeros_like(squares)))
        basis, growth = jax.vmap(orthogonal)(basis)
        growth, more = (jnp.where(k >= skipped, part, 0.0) for part in (growth, more))
        return state, basis, logarithms + growth, squares + more

    state, basis = jax.vmap(started_basis)(u0)
    sums = jnp.zeros((len(u0), 2 * n)), jnp.zeros_like(u0)
    return lax.fori_loop(0, periods, over_a_period, (state, basis, *sums))[2:]
