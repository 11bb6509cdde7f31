"""Models of OpenSees for the problems of the kit: springs and dashpots between nodes on a line."""

import math

import numpy as np


def build(ops, problem):
    """Start a model of OpenSees with the masses, springs, dashpots and loads of a problem; node 1 is fixed."""
    text, nodes = problem.text, range(2, len(problem.u0) + 2)
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (1, *nodes):
        ops.node(node, 0.0)
    ops.fix(1, 1)
    for node, mass in zip(nodes, np.diag(problem.mass).tolist(), strict=True):
        ops.mass(node, mass)
    form, n = text["form"], len(text["u0"])
    numbers = {name: np.array(value, float) for name, value in text["parameters"].items()}
    stiffness = numbers["stiffness"] if form == "linear" else np.zeros((n, n))
    tag = 0
    for i in range(n):
        for j in range(-1, i):
            # the sum of a row is the stiffness or damping to the fixed node
            k, c = (m[i].sum() if j < 0 else -m[i, j] for m in (stiffness, problem.damping))
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
    _loads(ops, text)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")


def _loads(ops, text):
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
