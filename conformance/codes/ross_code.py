"""ROSS, a code for rotors: ``conform conformance.codes.ross_code:step`` with the package ``ross-rotordynamics``.

Its function ``newmark`` starts at rest at zero. A linear problem therefore moves as w = u − u₀, under f − K u₀.
Problems with an initial velocity are left out. A nonlinear force can only be the force at the start of a step there.
"""

import numpy as np
from ross.utils import newmark

#: Tolerance of the residual, which ROSS takes as a force.
_TOLERANCE = 1e-12


def step(problem, scheme, dt, steps):
    """Displacement at the start and after every step, (steps + 1, n); ROSS returns no velocity."""
    linear = problem.text["form"] == "linear"
    if scheme["family"] != "newmark" or not linear or problem.v0.any():
        raise NotImplementedError("it has Newmark's method for linear problems from rest")
    stiffness, times = problem.tangent(problem.u0), np.append(0.0, np.cumsum(np.broadcast_to(dt, steps)))

    def system(i, **state):
        return problem.mass, problem.damping, stiffness, problem.load(times[i]) - stiffness @ problem.u0

    tolerance = _TOLERANCE * np.abs(stiffness).max()
    w = newmark(system, times, len(problem.u0), beta=float(scheme["beta"]), gamma=float(scheme["gamma"]), tol=tolerance)
    return problem.u0 + w, None
