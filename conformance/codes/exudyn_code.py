"""Exudyn, a multibody code: ``conform conformance.codes.exudyn_code:step``.

Its generalized-α method takes ρ∞ alone, and its Newmark method takes β and γ. Forces other than K u are user functions,
whose tangent Exudyn computes by differences.
"""

from typing import Any

import exudyn
import numpy as np
from exudyn.utilities import NodeGenericODE2, ObjectGenericODE2, SensorNode


def _settings(scheme, dt, steps):
    """Simulation settings and solver of a scheme; the solver is None if Exudyn does not have the scheme."""
    settings: Any = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime = steps, dt * steps
    integration.verboseMode = 0
    integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-13
    integration.newton.useModifiedNewton = False
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = dt / 2  # shorter than a step, so that every step is written
    alpha = integration.generalizedAlpha
    alpha.computeInitialAccelerations = True
    family, solvers = scheme["family"], exudyn.DynamicSolverType
    if family == "newmark":
        alpha.useNewmark, alpha.newmarkBeta, alpha.newmarkGamma = True, float(scheme["beta"]), float(scheme["gamma"])
        return settings, solvers.GeneralizedAlpha
    if family == "generalized_alpha":
        alpha_m, alpha_f = float(scheme["alpha_m"]), float(scheme["alpha_f"])
        alpha.spectralRadius = alpha_f / (1 - alpha_f)
        if abs(alpha_m - (2 * alpha.spectralRadius - 1) / (alpha.spectralRadius + 1)) < 1e-12:
            return settings, solvers.GeneralizedAlpha
    integration.automaticStepSize = False
    integration.explicitIntegration.computeEndOfStepAccelerations = True
    explicit = {"rk4": solvers.RK44, "central_difference": solvers.VelocityVerlet}
    return settings, explicit.get(family)


def step(problem, scheme, dt, steps):
    """Displacement, velocity and, except for Runge-Kutta, acceleration at 0, dt, 2 dt, ..., each (steps + 1, n)."""
    if np.ndim(dt):
        raise NotImplementedError("its steps are equal")
    settings, solver = _settings(scheme, dt, steps)
    if solver is None or problem.text["form"] == "elastoplastic":
        raise NotImplementedError("it has no such integrator or spring")
    n, linear = len(problem.u0), problem.text["form"] == "linear"
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * n,
            initialCoordinates=problem.u0.tolist(),
            initialCoordinates_t=problem.v0.tolist(),
            numberOfODE2Coordinates=n,
        )
    )

    def force(system, t, item, q, q_t):
        internal = 0.0 if linear else problem.force(np.array(q))
        return problem.load(t) - internal

    system.AddObject(
        ObjectGenericODE2(
            nodeNumbers=[node],
            massMatrix=problem.mass,
            dampingMatrix=problem.damping,
            stiffnessMatrix=problem.tangent(problem.u0) if linear else np.zeros((n, n)),
            forceUserFunction=force,
        )
    )
    outputs = exudyn.OutputVariableType
    kinds = (outputs.Coordinates, outputs.Coordinates_t, outputs.Coordinates_tt)
    sensors = [
        system.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind)) for kind in kinds
    ]
    system.Assemble()
    system.SolveDynamic(settings, solverType=solver)
    return [system.GetSensorStoredData(sensor)[:, 1:] for sensor in sensors[: 2 if scheme["family"] == "rk4" else 3]]
