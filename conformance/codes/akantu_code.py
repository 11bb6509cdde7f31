"""Akantu, a code of finite elements: ``conform conformance.codes.akantu_code:step`` with the package ``akantu``.

A bar of one element with E = k is a spring of stiffness k, without a damper. Akantu names Newmark's method by its
parameters. The acceleration at the start is set.
"""

import tempfile
from pathlib import Path

import akantu as aka
import numpy as np

_NAMES = {"0.25": "trapezoidal_rule_2", f"{1 / 6:.12g}": "linear_acceleration", f"{1 / 12:.12g}": "fox_goodwin"}


def _kind(scheme):
    """Akantu's name of a scheme; None if it has none."""
    if scheme["family"] == "newmark" and scheme["gamma"] == "0.5":
        return _NAMES.get(f"{float(scheme['beta']):.12g}")
    return "central_difference" if scheme["family"] == "central_difference" else None


def _model(density, stiffness):
    """Model of the bar, whose node 1 is free."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "material.dat")
        file.write_text(f"material elastic [ name = bar\n rho = {density!r}\n E = {stiffness!r}\n nu = 0.0\n]\n")
        aka.parseInput(str(file))
    mesh = aka.Mesh(1)
    access = aka.MeshAccessor(mesh)
    access.resizeNodes(2)
    mesh.getNodes()[:, 0] = 0.0, 1.0
    mesh.addConnectivityType(aka._segment_2)
    access.resizeConnectivity(1, aka._segment_2)
    mesh.getConnectivity(aka._segment_2)[0] = 0, 1
    access.makeReady()
    return mesh, aka.SolidMechanicsModel(mesh)


def step(problem, scheme, dt, steps):
    """Displacement, velocity and acceleration at the start and after every step, each (steps + 1, 1)."""
    kind, linear = _kind(scheme), problem.text["form"] == "linear" and len(problem.u0) == 1
    if kind is None or not linear or problem.damping.any():
        raise NotImplementedError("it has no such scheme, or is run with one linear spring without a damper")
    explicit, mass, stiffness = kind == "central_difference", problem.mass.item(), problem.tangent(problem.u0).item()
    # the free node has half of the lumped mass of the bar, or a third of the consistent mass
    _mesh, model = _model((2 if explicit else 3) * mass, stiffness)
    model.initFull(_analysis_method=aka._explicit_lumped_mass if explicit else aka._static)
    name = "explicit_lumped" if explicit else "implicit"
    if not explicit:
        model.getNewSolver(name, aka.TimeStepSolverType.dynamic, aka.NonLinearSolverType.newton_raphson)
        scheme_type = getattr(aka.IntegrationSchemeType, kind)
        model.setIntegrationScheme(name, "displacement", scheme_type, aka.IntegrationScheme._displacement)
        newton = model.getNonLinearSolver(name)
        newton.set("max_iterations", 50)
        newton.set("threshold", 1e-12 * stiffness)
        newton.set("convergence_type", aka.SolveConvergenceCriteria.residual)
    model.getBlockedDOFs()[0, 0] = True
    motion = model.getDisplacement(), model.getVelocity(), model.getAcceleration()
    a = (problem.load(0.0) - problem.force(problem.u0)) / mass
    for values, value in zip(motion, (problem.u0, problem.v0, a), strict=True):
        values[1] = value
    t, rows = 0.0, [[values[1, 0] for values in motion]]
    for size in np.broadcast_to(dt, steps).tolist():
        t += size
        model.setTimeStep(size, name)
        model.getExternalForce()[1] = problem.load(t)
        model.solveStep(name)
        rows.append([values[1, 0] for values in motion])
    return [np.array(rows)[:, [i]] for i in range(3)]
