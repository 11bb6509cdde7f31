"""Kratos, a code of finite elements: ``conform conformance.codes.kratos_code:step``.

It needs the package ``KratosStructuralMechanicsApplication``. An element ``NodalConcentratedDampedElement3D1N`` is a
mass with a spring and a dashpot. Its Bossak scheme has γ = ½ − α and β = b (1 − α)², with α = ``damp_factor_m`` and
b = ``newmark_beta``.
"""

import math

import KratosMultiphysics as K
import KratosMultiphysics.StructuralMechanicsApplication as S
import numpy as np

_MODEL = K.Model()
K.Logger.GetDefaultOutput().SetSeverity(K.Logger.Severity.WARNING)


def _bossak(scheme):
    """α and b of the Bossak scheme; None for any other scheme."""
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    alpha = numbers.get("alpha_m", 0.0)
    known = scheme["family"] in ("newmark", "generalized_alpha") and numbers.get("alpha_f", 0.0) == 0
    if not known or not math.isclose(numbers["gamma"], 0.5 - alpha):
        return None
    return alpha, numbers["beta"] / (1 - alpha) ** 2


def _part(problem):
    """Model part with one node, its mass, spring, dashpot and load along x."""
    part = _MODEL.CreateModelPart("main", 2)
    part.ProcessInfo[K.DOMAIN_SIZE] = 3
    for variable in (K.DISPLACEMENT, K.VELOCITY, K.ACCELERATION, K.REACTION, K.VOLUME_ACCELERATION, S.POINT_LOAD):
        part.AddNodalSolutionStepVariable(variable)
    node = part.CreateNewNode(1, 0.0, 0.0, 0.0)
    properties = part.CreateNewProperties(0)
    element = part.CreateNewElement("NodalConcentratedDampedElement3D1N", 1, [1], properties)
    part.CreateNewCondition("PointLoadCondition3D1N", 1, [1], properties)
    for variable, reaction in zip((K.DISPLACEMENT_X, K.DISPLACEMENT_Y, K.DISPLACEMENT_Z), "XYZ", strict=True):
        node.AddDof(variable, getattr(K, f"REACTION_{reaction}"))
        node.Fix(variable) if reaction != "X" else None
    element.SetValue(K.NODAL_MASS, problem.mass[0, 0])
    element.SetValue(S.NODAL_DISPLACEMENT_STIFFNESS, [problem.tangent(problem.u0)[0, 0], 0.0, 0.0])
    element.SetValue(S.NODAL_DAMPING_RATIO, [problem.damping[0, 0], 0.0, 0.0])
    return part, node


def step(problem, scheme, dt, steps):
    """Displacement, velocity and acceleration at the start and after every step, each (steps + 1, 1)."""
    found = _bossak(scheme)
    if found is None or problem.text["form"] != "linear" or len(problem.u0) > 1:
        raise NotImplementedError("it has no such scheme, or is run with one linear spring")
    part, node = _part(problem)
    settings = K.Parameters('{"projection_variables_list": []}')
    for name, value in zip(("damp_factor_m", "newmark_beta"), found, strict=True):
        settings.AddDouble(name, value)
    strategy = K.ResidualBasedNewtonRaphsonStrategy(
        part,
        S.StructuralMechanicsBossakScheme(settings),
        K.ResidualCriteria(1e-14, 1e-13),
        K.ResidualBasedBlockBuilderAndSolver(K.SkylineLUFactorizationSolver()),
        20,
        False,
        False,
        True,
    )
    a = (problem.load(0.0) - problem.damping @ problem.v0 - problem.force(problem.u0)) / problem.mass[0, 0]
    for variable, value in ((K.DISPLACEMENT_X, problem.u0), (K.VELOCITY_X, problem.v0), (K.ACCELERATION_X, a)):
        node.SetSolutionStepValue(variable, float(value[0]))
    strategy.Initialize()
    t, read = 0.0, (K.DISPLACEMENT_X, K.VELOCITY_X, K.ACCELERATION_X)
    rows = [[node.GetSolutionStepValue(variable) for variable in read]]
    for size in np.broadcast_to(dt, steps).tolist():
        t += size
        part.CloneTimeStep(t)
        part.ProcessInfo[K.DELTA_TIME] = size
        node.SetSolutionStepValue(S.POINT_LOAD_X, float(problem.load(t)[0]))
        strategy.Solve()
        rows.append([node.GetSolutionStepValue(variable) for variable in read])
    _MODEL.DeleteModelPart("main")
    return [np.array(rows)[:, [i]] for i in range(3)]
