"""diffrax, a library of solvers in JAX: ``conform conformance.codes.diffrax_code:step``.

The state is (u, v). Symplectic Euler is a solver of diffrax. Every other supported scheme is an explicit or diagonally
implicit Runge-Kutta solver of diffrax with the tableau of the scheme. The equations are taken from the study, because
JAX must differentiate them.
"""

import json
from typing import Any, ClassVar

import diffrax
import jax.numpy as jnp
import numpy as np
import optimistix

from conformance.codes.time_integration_study import problem_of
from study.mechanics.balance import acceleration

#: Relative and absolute tolerance of the last correction of Newton's iteration; the remaining error is much smaller.
_TOLERANCE = 1e-10


def _solver(rows, weights) -> Any:
    """Runge-Kutta solver with a tableau whose rows end with the diagonal entry."""
    lower, diagonal = [np.array(row[:-1]) for row in rows[1:]], np.array([row[-1] for row in rows])
    implicit = bool(diagonal.any())
    given = diffrax.ButcherTableau(
        a_lower=tuple(lower),
        b_sol=np.array(weights),
        b_error=np.zeros(len(weights)),
        c=np.array([sum(row) for row in rows[1:]]),
        a_diagonal=diagonal if implicit else None,
        # Newton's iteration of a stage starts from the slope of the previous stage
        a_predictor=tuple(np.eye(len(row))[-1] for row in lower) if implicit else None,
    )

    class OfTableau(diffrax.AbstractDIRK if implicit else diffrax.AbstractERK):  # type: ignore[misc]
        tableau: ClassVar = given
        interpolation_cls: ClassVar = diffrax.Heun.interpolation_cls
        root_finder: Any = optimistix.Newton(rtol=_TOLERANCE, atol=_TOLERANCE)
        root_find_max_steps: int = 50

        def order(self, terms):
            return 1

    return OfTableau()


def _tableau(scheme):
    """Rows and weights of the tableau of a scheme; None for any other scheme."""
    family = scheme["family"]
    if family == "rk4":
        return [[0.0], [0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0, 0.0]], [1 / 6, 1 / 3, 1 / 3, 1 / 6]
    if family == "midpoint":
        return [[0.0], [0.0, 0.5]], [0.0, 1.0]
    if family == "newmark" and (scheme["beta"], scheme["gamma"]) == ("0.25", "0.5"):
        return [[0.0], [0.5, 0.5]], [0.5, 0.5]
    if family == "bathe":
        gamma, rho = float(scheme["gamma"]), float(scheme["rho_inf"])
        q1 = (1 + rho) / (2 * gamma * (rho - 1) + 4)
        last = [(gamma - 1) * q1 + 0.5, q1, 0.5 - gamma * q1]
        return [[0.0], [gamma / 2, gamma / 2], last], last
    return None


def step(problem, scheme, dt, steps):
    """Displacement and velocity at the start and after every step, each (steps + 1, n)."""
    tableau, symplectic = _tableau(scheme), scheme["family"] == "symplectic_euler"
    modelled = problem_of(json.dumps(problem.text))
    if modelled.history is not None or not (tableau or (symplectic and not problem.damping.any())):
        raise NotImplementedError("it has no such solver, or no spring with a memory, or no damping in this solver")
    terms: Any
    solver: Any
    if symplectic:
        of_u = diffrax.ODETerm(lambda t, v, args: v)
        of_v = diffrax.ODETerm(lambda t, u, args: acceleration(modelled, jnp.asarray(t), u, jnp.zeros_like(u)))
        terms, solver = (of_u, of_v), diffrax.SemiImplicitEuler()
    else:
        terms = diffrax.ODETerm(lambda t, y, args: (y[1], acceleration(modelled, jnp.asarray(t), *y)))
        solver = _solver(*tableau)
    times = np.append(0.0, np.cumsum(dt)) if np.ndim(dt) else dt * np.arange(steps + 1)
    found = diffrax.diffeqsolve(
        terms,
        solver,
        t0=0.0,
        t1=times[-1],
        dt0=None,
        y0=(jnp.asarray(problem.u0), jnp.asarray(problem.v0)),
        stepsize_controller=diffrax.StepTo(jnp.asarray(times)),
        saveat=diffrax.SaveAt(t0=True, steps=True),
        max_steps=steps,
    )
    return [np.asarray(one) for one in found.ys]
