"""OpenSees, a finite element code: ``conform conformance.codes.opensees:step`` with the package ``openseespy``.

OpenSees does not compute the acceleration at the start; ``step`` sets it, but ``from_zero`` does not. ``others`` and
``more`` run other integrators for the same schemes.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from conformance.codes.opensees_model import build


def _alpha(name: str, alpha_m: float, alpha_f: float, beta: float, gamma: float) -> tuple:
    return name, 1 - alpha_m, 1 - alpha_f, beta, gamma


#: Name and arguments of the integrator of each family, from the parameters of a scheme.
INTEGRATORS: dict[str, Callable[..., tuple]] = {
    "newmark": lambda beta, gamma: ("Newmark", gamma, beta),
    "central_difference": lambda: ("NewmarkExplicit", 0.5),
    "hht": lambda alpha, beta, gamma: ("HHT", 1 + alpha, gamma, beta),
    # the usage message of GeneralizedAlpha has γ before β, but its constructor has β before γ
    "generalized_alpha": partial(_alpha, "GeneralizedAlpha"),
    "wilson": lambda theta: ("WilsonTheta", theta),
    "houbolt": lambda: ("Houbolt",),
    "bathe": lambda gamma, rho_inf: ("TRBDF2",) if (gamma, rho_inf) == (0.5, 0.0) else (),
    "kr_alpha": lambda rho_inf: ("KRAlphaExplicit", rho_inf),
}

#: Other integrators of OpenSees, or another form of the integrator, for the same families.
OTHERS: dict[str, Callable[..., tuple]] = {
    "newmark": lambda beta, gamma: ("Newmark", gamma, beta, "-form", "A"),
    "generalized_alpha": partial(_alpha, "HHTGeneralized"),
    "wilson": lambda theta: ("Collocation", theta, 1 / 6, 0.5),
    "kr_alpha": lambda rho_inf: ("KRAlphaExplicit_TP", rho_inf),
}

#: Further integrators.
MORE: dict[str, Callable[..., tuple]] = {
    "central_difference": lambda: ("CentralDifference",),
    "hht": lambda alpha, beta, gamma: ("HHT_TP", 1 + alpha, beta, gamma),
    "generalized_alpha": partial(_alpha, "HHTGeneralized_TP"),
}


def run(ops: Any, integrators, started, problem, scheme, dt, steps):
    """Motion by an interpreter of OpenSees and the integrator of a scheme, as ``step`` returns it."""
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    integrator = integrators[scheme["family"]](**numbers) if scheme["family"] in integrators else ()
    if not integrator or np.any(problem.mass != np.diag(np.diag(problem.mass))):
        raise NotImplementedError("it has no such integrator, or no full mass matrix")
    build(ops, problem)
    ops.test("NormDispIncr", 1e-12, 50)
    ops.algorithm("Linear" if "Explicit" in integrator[0] or "Difference" in integrator[0] else "Newton")
    ops.integrator(*integrator)
    ops.analysis("Transient")
    a = np.linalg.solve(problem.mass, problem.load(0.0) - problem.damping @ problem.v0 - problem.force(problem.u0))
    nodes = range(2, len(problem.u0) + 2)
    for node, *values in zip(nodes, problem.u0.tolist(), problem.v0.tolist(), (a * started).tolist(), strict=True):
        for setter, value in zip((ops.setNodeDisp, ops.setNodeVel, ops.setNodeAccel), values, strict=True):
            setter(node, 1, value, "-commit")
    functions, rows = (ops.nodeDisp, ops.nodeVel, ops.nodeAccel), []
    for number, size in enumerate([0.0, *np.broadcast_to(dt, steps).tolist()]):
        if number and ops.analyze(1, size):
            raise ArithmeticError(f"step {number} fails")
        rows.append([[function(node, 1) for node in nodes] for function in functions])
    return [np.array([row[i] for row in rows]) for i in range(3)]


def _run(integrators, started, problem, scheme, dt, steps):
    import openseespy.opensees as ops

    return run(ops, integrators, started, problem, scheme, dt, steps)


step, from_zero = partial(_run, INTEGRATORS, True), partial(_run, INTEGRATORS, False)
others, more = partial(_run, OTHERS, True), partial(_run, MORE, True)
