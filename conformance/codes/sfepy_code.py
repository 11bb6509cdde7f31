"""SfePy, a code of finite elements: ``conform conformance.codes.sfepy_code:step`` with the package ``sfepy``.

Its solvers for elastodynamics take the residual of the state (u, u̇, ü). As in a problem of SfePy, the load is updated
by the function ``prestep_fun``, at the time that the solver sets before it calls this function.
"""

import numpy as np
import scipy.sparse as sp
from sfepy.base.base import Struct, output
from sfepy.solvers.ls import ScipyDirect
from sfepy.solvers.nls import Newton
from sfepy.solvers.ts_solvers import BatheTS, CentralDifferenceTS, GeneralizedAlphaTS, NewmarkTS

output.set_output(quiet=True)


def _solver(scheme):
    """Solver of a scheme and its parameters; None if SfePy does not have the scheme."""
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    match scheme["family"]:
        case "newmark":
            return NewmarkTS, numbers
        case "hht":
            return GeneralizedAlphaTS, {"alpha_m": 0.0, "alpha_f": -numbers.pop("alpha"), **numbers}
        case "generalized_alpha":
            return GeneralizedAlphaTS, numbers
        case "central_difference":
            return CentralDifferenceTS, {}
        case "bathe" if numbers == {"gamma": 0.5, "rho_inf": 0.0}:
            return BatheTS, {}
    return None


def step(problem, scheme, dt, steps):
    """Displacement, velocity and acceleration at the start and after every step, each (steps + 1, n)."""
    choice = _solver(scheme)
    if choice is None or problem.text["form"] == "elastoplastic" or np.ndim(dt):
        raise NotImplementedError("it has no such solver, or no spring with a memory, or is run with equal steps")
    kind, numbers = choice
    n = len(problem.u0)
    parts = [slice(i * n, (i + 1) * n) for i in range(3)]
    load, rows = problem.load(0.0), []

    def residual(vec):
        u, v, a = (vec[part] for part in parts)
        return np.concatenate([problem.force(u) - load, problem.damping @ v, problem.mass @ a])

    def tangent(vec):
        u = problem.u0 if vec is None else vec[parts[0]]
        return sp.block_diag([problem.tangent(u), problem.damping, problem.mass], format="csr")

    def before(ts, vec):
        nonlocal load
        load = problem.load(ts.time)
        return vec

    def after(ts, vec):
        rows.append([vec[part].copy() for part in parts])
        return vec

    newton = {"eps_a": 1e-13, "eps_r": 1e-15, "macheps": 1e-16, "i_max": 50, "eps_mode": "or", "ls_on": 1e9}
    nls = Newton(Struct(**newton), fun=residual, fun_grad=tangent, lin_solver=ScipyDirect(Struct()), context=None)
    names = dict(zip(("u", "du", "ddu"), ("u", "v", "a"), strict=True))
    conf = Struct(t0=0.0, t1=dt * steps, n_step=steps + 1, dt=None, var_names=names, verbose=False, **numbers)
    solver = kind(conf, nls=nls, context=None)
    solver.di = Struct(indx=dict(zip("uva", parts, strict=True)), n_dof=dict.fromkeys("uva", n), n_dof_total=3 * n)
    solver(
        vec0=np.concatenate([problem.u0, problem.v0, 0 * problem.u0]),
        init_fun=lambda ts, vec: vec,
        prestep_fun=before,
        poststep_fun=after,
    )
    return [np.array(values) for values in zip(*rows, strict=True)]
