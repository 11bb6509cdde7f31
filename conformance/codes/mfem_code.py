"""MFEM, a library of finite elements: ``conform conformance.codes.mfem_code:step`` with the package ``mfem``.

Its solvers of second order call an operator that returns the acceleration, or solves for it by Newton's iteration.
Runge-Kutta, the implicit midpoint rule and symplectic Euler are solvers of first order, with the state (u, u̇).
"""

import math

import mfem.ser as mfem
import numpy as np


def _solver(scheme):
    """Solver of a scheme; None if MFEM does not have the scheme."""
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    match scheme["family"]:
        case "newmark":
            return mfem.NewmarkSolver(numbers["beta"], numbers["gamma"])
        case "central_difference":
            return mfem.CentralDifferenceSolver()
        case "hht" if math.isclose(numbers["beta"], (1 - numbers["alpha"]) ** 2 / 4):
            return mfem.HHTAlphaSolver(1 + numbers["alpha"])
        case "generalized_alpha":
            rho = (1 + numbers["alpha_m"]) / (2 - numbers["alpha_m"])
            if math.isclose(numbers["alpha_f"], rho / (1 + rho)):
                return mfem.GeneralizedAlpha2Solver(rho)
            rho = (1 + numbers["alpha_m"]) / (1 - numbers["alpha_m"])
            return mfem.WBZAlphaSolver(rho) if numbers["alpha_f"] == 0 else None
    return None


class _Motion(mfem.SecondOrderTimeDependentOperator):
    """The acceleration that the equation of motion gives."""

    def __init__(self, problem):
        super().__init__(len(problem.u0), 0.0)
        self.problem = problem

    def _acceleration(self, u, v):
        problem = self.problem
        return np.linalg.solve(problem.mass, problem.load(self.GetTime()) - problem.damping @ v - problem.force(u))

    def Mult(self, u, v, a):
        a.Assign(self._acceleration(u.GetDataArray(), v.GetDataArray()))

    def ImplicitSolve(self, u_factor, v_factor, u, v, a):
        problem, u, v = self.problem, u.GetDataArray(), v.GetDataArray()
        x = self._acceleration(u, v)
        for _ in range(50):
            u_end = u + u_factor * x
            residual = (
                problem.mass @ x
                + problem.damping @ (v + v_factor * x)
                + problem.force(u_end)
                - problem.load(self.GetTime())
            )
            change = np.linalg.solve(
                problem.mass + v_factor * problem.damping + u_factor * problem.tangent(u_end), residual
            )
            x = x - change
            if abs(change).max() <= 1e-14 * abs(x).max():
                break
        a.Assign(x)


def step(problem, scheme, dt, steps):
    """Displacement and velocity at the start and after every step, each (steps + 1, n)."""
    solver = _solver(scheme)
    if solver is None or problem.text["form"] == "elastoplastic":
        raise NotImplementedError("it has no such solver, or no spring with a memory")
    motion, u, v = _Motion(problem), mfem.Vector(problem.u0.copy()), mfem.Vector(problem.v0.copy())
    solver.Init(motion)
    t, rows = 0.0, [(problem.u0, problem.v0)]
    for size in np.broadcast_to(dt, steps).tolist():
        t, _ = solver.Step(u, v, t, size)
        rows.append((u.GetDataArray().copy(), v.GetDataArray().copy()))
    return [np.array(values) for values in zip(*rows, strict=True)]
