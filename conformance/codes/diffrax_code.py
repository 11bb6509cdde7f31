"""diffrax, a library of solvers in JAX: ``conform conformance.codes.diffrax_code:step``.

Symplectic Euler is a solver of diffrax. Every other supported scheme is a Runge-Kutta solver of diffrax with the
tableau of the scheme. The equations are taken from the study, because JAX must differentiate them.
"""

import json
from typing import Any, ClassVar

import diffrax
import jax.numpy as jnp
import numpy as np
import optimistix

from conformance.codes.time_integration_study import problem_of
from study.mechanics.balance import acceleration


def _solver(rows, weights) -> Any:
    """Runge-Kutta solver with a tableau whose rows end with the diagonal entry."""
    lower, diagonal = tuple(np.array(row[:-1]) for row in rows[1:]), np.array([row[-1] for row in rows])
    implicit, ends = bool(diagonal.any()), np.array([sum(row) for row in rows[1:]])
    # Newton's iteration of a stage starts from the slope of the previous stage
    slopes = tuple(np.eye(len(row))[-1] for row in lower)
    stages: dict[str, Any] = {"a_diagonal": diagonal, "a_predictor": slopes} if implicit else {}
    butcher = diffrax.ButcherTableau(c=ends, b_sol=np.array(weights), b_error=0 * diagonal, a_lower=lower, **stages)

    class OfTableau(diffrax.AbstractDIRK if implicit else diffrax.AbstractERK):  # type: ignore[misc]
        tableau: ClassVar = butcher
        interpolation_cls: ClassVar = diffrax.Heun.interpolation_cls
        root_finder: Any = optimistix.Newton(rtol=1e-10, atol=1e-10)  # of the last correction
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

    def slope(t, u, v):
        return acceleration(modelled, jnp.asarray(t), u, v)

    terms: Any = diffrax.ODETerm(lambda t, y, args: (y[1], slope(t, *y)))
    solver: Any = diffrax.SemiImplicitEuler() if symplectic else _solver(*tableau)
    if symplectic:
        terms = (
            diffrax.ODETerm(lambda t, v, args: v),
            diffrax.ODETerm(lambda t, u, args: slope(t, u, jnp.zeros_like(u))),
        )
    times = np.append(0.0, np.cumsum(dt)) if np.ndim(dt) else dt * np.arange(steps + 1)
    control, saved = diffrax.StepTo(jnp.asarray(times)), diffrax.SaveAt(t0=True, steps=True)
    start, end = (jnp.asarray(problem.u0), jnp.asarray(problem.v0)), times[-1]
    solution = diffrax.diffeqsolve(
        terms, solver, 0.0, end, None, start, stepsize_controller=control, saveat=saved, max_steps=steps
    )
    return [np.asarray(values) for values in solution.ys]
