"""Kratos, a code of finite elements: ``conform conformance.codes.kratos_code:step``.

It needs the package ``KratosStructuralMechanicsApplication``. An element ``NodalConcentratedDampedElement3D1N`` is a
mass with a spring and a dashpot. Its Bossak scheme has γ = ½ − α and β = b (1 − α)², with α = ``damp_factor_m`` and
b = ``newmark_beta``. ``explicit`` runs its central difference.
"""

import math

import KratosMultiphysics as K
import KratosMultiphysics.StructuralMechanicsApplication as S
import numpy as np

from conformance.codes.kratos_model import EXPLICIT, MOTION, part_of


def _bossak(scheme):
    """α and b of the Bossak scheme; None for any other scheme."""
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    alpha = numbers.get("alpha_m", 0.0)
    known = scheme["family"] in ("newmark", "generalized_alpha") and numbers.get("alpha_f", 0.0) == 0
    if not known or not math.isclose(numbers["gamma"], 0.5 - alpha):
        return None
    return alpha, numbers["beta"] / (1 - alpha) ** 2


def _marched(problem, part, node, strategy, dt, steps):
    """Displacement, velocity and acceleration at the start and after every step."""
    part.ProcessInfo[K.DELTA_TIME] = float(np.ravel(dt)[0])
    strategy.Initialize()
    t, rows = 0.0, [[node.GetSolutionStepValue(variable) for variable in MOTION]]
    for size in np.broadcast_to(dt, steps).tolist():
        t += size
        part.CloneTimeStep(t)
        part.ProcessInfo[K.DELTA_TIME] = size
        node.SetSolutionStepValue(S.POINT_LOAD_X, float(problem.load(t)[0]))
        strategy.Solve()
        rows.append([node.GetSolutionStepValue(variable) for variable in MOTION])
    return [np.array(rows)[:, [i]] for i in range(3)]


def step(problem, scheme, dt, steps):
    """Displacement, velocity and acceleration at the start and after every step, each (steps + 1, 1)."""
    numbers = _bossak(scheme)
    if numbers is None or problem.text["form"] != "linear" or len(problem.u0) > 1:
        raise NotImplementedError("it has no such scheme, or is run with one linear spring")
    part, node = part_of(problem)
    settings = K.Parameters('{"projection_variables_list": []}')
    for name, value in zip(("damp_factor_m", "newmark_beta"), numbers, strict=True):
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
    return _marched(problem, part, node, strategy, dt, steps)


def explicit(problem, scheme, dt, steps):
    """The same for central difference, the scheme ``central_differences`` of Kratos's explicit solver."""
    if scheme["family"] != "central_difference" or problem.text["form"] != "linear" or len(problem.u0) > 1:
        raise NotImplementedError("it has central difference, and is run with one linear spring")
    part, node = part_of(problem, *EXPLICIT)
    part.ProcessInfo[K.COMPUTE_LUMPED_MASS_MATRIX] = True
    part.ProcessInfo[S.RAYLEIGH_ALPHA] = part.ProcessInfo[S.RAYLEIGH_BETA] = 0.0
    node.SetSolutionStepValue(S.POINT_LOAD_X, float(problem.load(0.0)[0]))
    strategy = S.MechanicalExplicitStrategy(
        part, S.ExplicitCentralDifferencesScheme(1.0, 0.3, 0.0), False, False, False
    )
    strategy.SetRebuildLevel(0)
    return _marched(problem, part, node, strategy, dt, steps)
