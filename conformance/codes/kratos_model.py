"""A mass with a spring, a dashpot and a load in Kratos, for ``kratos_code``."""

import KratosMultiphysics as K
import KratosMultiphysics.StructuralMechanicsApplication as S

_MODEL = K.Model()
K.Logger.GetDefaultOutput().SetSeverity(K.Logger.Severity.WARNING)

#: Displacement, velocity and acceleration along x.
MOTION = (K.DISPLACEMENT_X, K.VELOCITY_X, K.ACCELERATION_X)

_VARIABLES = (K.DISPLACEMENT, K.VELOCITY, K.ACCELERATION, K.REACTION, K.VOLUME_ACCELERATION, S.POINT_LOAD)

#: Variables that the explicit scheme needs.
EXPLICIT = (S.MIDDLE_VELOCITY, K.NODAL_MASS, K.FORCE_RESIDUAL, K.RESIDUAL_VECTOR)


def part_of(problem, *more):
    """Model part with one node, and the node. ``more`` are further variables."""
    if _MODEL.HasModelPart("main"):
        _MODEL.DeleteModelPart("main")
    part = _MODEL.CreateModelPart("main", 2)
    part.ProcessInfo[K.DOMAIN_SIZE] = 3
    for variable in (*_VARIABLES, *more):
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
    a = (problem.load(0.0) - problem.damping @ problem.v0 - problem.force(problem.u0)) / problem.mass[0, 0]
    for variable, value in zip(MOTION, (problem.u0, problem.v0, a), strict=True):
        node.SetSolutionStepValue(variable, float(value[0]))
    return part, node
