"""PETSc, a library of solvers: ``conform conformance.codes.petsc_code:step`` with the package ``petsc4py``.

The method ALPHA2 takes α_m, α_f, β and γ. The other methods have the state (u, u̇): the θ-method with θ = ½ is the
implicit midpoint rule, and the Runge-Kutta method "4" is the classical one. PETSc computes Jacobians by differences.
"""

import numpy as np
import petsc4py

petsc4py.init()
from petsc4py import PETSc  # noqa: E402  the package must be initialised first

_REST = {"ts_adapt_type": "none", "snes_fd": "", "snes_rtol": 0, "snes_atol": 1e-13, "snes_stol": 1e-15}
_REST |= {"ts_max_snes_failures": -1, "ksp_type": "preonly", "pc_type": "lu"}


def _options(scheme):
    """Options of PETSc for a scheme; None if PETSc does not have the scheme."""
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    if scheme["family"] in ("newmark", "hht", "generalized_alpha"):
        # PETSc weights the end of a step by its α_m and α_f
        alpha_m, alpha_f = 1 - numbers.get("alpha_m", 0.0), 1 - numbers.get("alpha_f", -numbers.pop("alpha", 0.0))
        return {"type": "alpha2"} | {
            f"alpha_{name}": value for name, value in (numbers | {"alpha_m": alpha_m, "alpha_f": alpha_f}).items()
        }
    known = {"rk4": {"type": "rk", "rk_type": "4"}, "midpoint": {"type": "theta", "theta_theta": 0.5}}
    return known.get(scheme["family"])


def _vector(values):
    vector = PETSc.Vec().createSeq(len(values))
    vector.setArray(values)
    vector.assemble()
    return vector


def step(problem, scheme, dt, steps):
    """Displacement and velocity at the start and after every step, each (steps + 1, n)."""
    options, n = _options(scheme), len(problem.u0)
    if options is None or problem.text["form"] == "elastoplastic" or np.ndim(dt):
        raise NotImplementedError("it has no such method, or no spring with a memory, or is run with equal steps")
    for name, value in {**{f"ts_{name}": x for name, x in options.items()}, **_REST}.items():
        PETSc.Options().setValue(name, str(value))
    ts = PETSc.TS().create()
    ts.setType(options["type"])

    def residual(ts, t, u, v, a, f):
        u, v, a = (x.getArray(readonly=True) for x in (u, v, a))
        f.setArray(problem.mass @ a + problem.damping @ v + problem.force(u) - problem.load(t))

    def right(ts, t, y, f):
        u, v = np.split(y.getArray(readonly=True), 2)
        f.setArray(
            np.concatenate([v, np.linalg.solve(problem.mass, problem.load(t) - problem.damping @ v - problem.force(u))])
        )

    second = options["type"] == "alpha2"
    if second:
        ts.setI2Function(residual, _vector(problem.u0))
        ts.setSolution2(_vector(problem.u0), _vector(problem.v0))
    else:
        ts.setRHSFunction(right, _vector(np.zeros(2 * n)))
        ts.setSolution(_vector(np.concatenate([problem.u0, problem.v0])))
    ts.setTimeStep(dt)
    ts.setMaxSteps(steps)
    ts.setMaxTime(2 * dt * steps)
    ts.setFromOptions()
    rows = [np.concatenate([problem.u0, problem.v0])]
    for _ in range(steps):
        ts.step()
        rows.append(np.concatenate([x.getArray() for x in (ts.getSolution2() if second else [ts.getSolution()])]))
    return np.array(rows)[:, :n], np.array(rows)[:, n:]
