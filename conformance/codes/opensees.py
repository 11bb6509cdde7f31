"""OpenSees, a finite element code: ``python -m conformance conformance.codes.opensees:step``.

A stiffness or damping matrix is modelled by springs or dashpots between nodes on a line. OpenSees does not compute the
acceleration at the start; ``step`` sets it, but ``from_zero`` does not. ``others`` and ``more`` run other integrators
of OpenSees, or other forms of an integrator, for the same schemes.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import openseespy.opensees as ops

#: Name and arguments of the integrator of each family, from the parameters of a scheme.
INTEGRATORS: dict[str, Callable[..., tuple]] = {
    "newmark": lambda beta, gamma: ("Newmark", gamma, beta),
    "central_difference": lambda: ("NewmarkExplicit", 0.5),
    "hht": lambda alpha, beta, gamma: ("HHT", 1 + alpha, gamma, beta),
    # the usage message of GeneralizedAlpha has γ before β, but its constructor has β before γ
    "generalized_alpha": lambda alpha_m, alpha_f, beta, gamma: (
        "GeneralizedAlpha",
        1 - alpha_m,
        1 - alpha_f,
        beta,
        gamma,
    ),
    "wilson": lambda theta: ("WilsonTheta", theta),
    "houbolt": lambda: ("Houbolt",),
    "bathe": lambda gamma, rho_inf: ("TRBDF2",),
    "kr_alpha": lambda rho_inf: ("KRAlphaExplicit", rho_inf),
}


#: Other integrators of OpenSees, or another form of the integrator, for the same families.
OTHERS: dict[str, Callable[..., tuple]] = {
    "newmark": lambda beta, gamma: ("Newmark", gamma, beta, "-form", "A"),
    "generalized_alpha": lambda alpha_m, alpha_f, beta, gamma: (
        "HHTGeneralized",
        1 - alpha_m,
        1 - alpha_f,
        beta,
        gamma,
    ),
    "wilson": lambda theta: ("Collocation", theta, 1 / 6, 0.5),
    "kr_alpha": lambda rho_inf: ("KRAlphaExplicit_TP", rho_inf),
}

#: Further integrators of OpenSees for the same families.
MORE: dict[str, Callable[..., tuple]] = {
    "central_difference": lambda: ("CentralDifference",),
    "hht": lambda alpha, beta, gamma: ("HHT_TP", 1 + alpha, beta, gamma),
    "generalized_alpha": lambda alpha_m, alpha_f, beta, gamma: (
        "HHTGeneralized_TP",
        1 - alpha_m,
        1 - alpha_f,
        beta,
        gamma,
    ),
}


def _springs(text):
    """Add the springs and dashpots of a problem to the model of OpenSees; node 1 is fixed."""
    form, n = text["form"], len(text["u0"])
    numbers = {name: np.array(value, float) for name, value in text["parameters"].items()}
    damping = np.array(text["damping"], float)
    stiffness = numbers["stiffness"] if form == "linear" else np.zeros((n, n))
    tag = 0
    for i in range(n):
        for j in range(-1, i):
            # the sum of a row is the stiffness or damping to the fixed node
            k, c = (m[i].sum() if j < 0 else -m[i, j] for m in (stiffness, damping))
            if k or c:
                tag += 1
                ops.uniaxialMaterial("Elastic", tag, float(k), float(c))
                ops.element("zeroLength", tag, j + 2, i + 2, "-mat", tag, "-dir", 1)
    if form == "cubic":
        first, third = float(numbers["S1"]), float(numbers["S1"] * numbers["S2"])
        ops.uniaxialMaterial("ElasticPowerFunc", 99, "-coeff", first, third, "-exp", 1.0, 3.0)
    elif form == "elastoplastic":
        ops.uniaxialMaterial("Steel01", 99, *(float(numbers[name]) for name in ("yield_force", "k", "hardening")))
    elif form == "gap":
        # ENT resists compression only; with reversed nodes it resists u > 0
        ops.uniaxialMaterial("ENT", 99, float(numbers["k"]))
    elif form != "linear":
        raise NotImplementedError(f"it has no material for the form {form}")
    if form != "linear":
        ops.element("zeroLength", 99, *((2, 1) if form == "gap" else (1, 2)), "-mat", 99, "-dir", 1)


def _loads(text):
    if load := text.get("load"):
        frequency, phase = float(load["frequency"]), float(load["phase"])
        if frequency:
            ops.timeSeries("Trig", 1, 0.0, 1e9, 2 * math.pi / frequency, "-shift", math.pi / 2 - phase)
        else:
            ops.timeSeries("Constant", 1, "-factor", math.cos(phase))
        ops.pattern("Plain", 1, 1)
        for i, amplitude in enumerate(load["amplitude"]):
            ops.load(i + 2, float(amplitude))
    if ground := text.get("ground"):
        ops.timeSeries("Path", 2, "-dt", float(ground["dt"]), "-values", *map(float, ground["acceleration"]))
        ops.pattern("UniformExcitation", 2, 1, "-accel", 2)


def step(problem, scheme, dt, steps, started=True, integrators=INTEGRATORS):
    """Displacement, velocity and acceleration at the start and after every step, each (steps + 1, n)."""
    if scheme["family"] not in integrators or np.any(problem.mass != np.diag(np.diag(problem.mass))):
        raise NotImplementedError("it has no such integrator, or no full mass matrix")
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    integrator = integrators[scheme["family"]](**numbers)
    if integrator == ("TRBDF2",) and (numbers["gamma"], numbers["rho_inf"]) != (0.5, 0.0):
        raise NotImplementedError("its TRBDF2 has two equal sub-steps")
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    nodes = range(2, len(problem.u0) + 2)
    for node in (1, *nodes):
        ops.node(node, 0.0)
    ops.fix(1, 1)
    for node, mass in zip(nodes, np.diag(problem.mass).tolist(), strict=True):
        ops.mass(node, mass)
    _springs(problem.text)
    _loads(problem.text)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-12, 50)
    ops.algorithm("Linear" if "Explicit" in integrator[0] or "Difference" in integrator[0] else "Newton")
    ops.integrator(*integrator)
    ops.analysis("Transient")
    a = np.linalg.solve(problem.mass, problem.load(0.0) - problem.damping @ problem.v0 - problem.force(problem.u0))
    for node, *values in zip(nodes, problem.u0.tolist(), problem.v0.tolist(), (a * started).tolist(), strict=True):
        for setter, value in zip((ops.setNodeDisp, ops.setNodeVel, ops.setNodeAccel), values, strict=True):
            setter(node, 1, value, "-commit")
    read = (ops.nodeDisp, ops.nodeVel, ops.nodeAccel)
    rows = [[[one(node, 1) for node in nodes] for one in read]]
    for number, size in enumerate(np.broadcast_to(dt, steps).tolist()):
        if ops.analyze(1, size):
            raise ArithmeticError(f"step {number + 1} fails")
        rows.append([[one(node, 1) for node in nodes] for one in read])
    return [np.array([row[i] for row in rows]) for i in range(3)]


from_zero = partial(step, started=False)
others = partial(step, integrators=OTHERS)
more = partial(step, integrators=MORE)
