"""SciPy's bilinear transform, which is average acceleration for linear problems.

``conform conformance.codes.scipy_code:step``. SciPy has no other scheme of the kit.
"""

import numpy as np
from scipy.signal import cont2discrete


def step(problem, scheme, dt, steps):
    """Displacement and velocity at 0, dt, 2 dt, ..., each (steps + 1, n)."""
    average = scheme["family"] == "newmark" and (scheme["beta"], scheme["gamma"]) == ("0.25", "0.5")
    if not average or problem.text["form"] != "linear" or np.ndim(dt):
        raise NotImplementedError("it is average acceleration with equal steps on linear problems only")
    n = len(problem.u0)
    slope = np.linalg.solve(problem.mass, np.hstack([problem.tangent(problem.u0), problem.damping]))
    a = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), -slope])
    b = np.vstack([np.zeros((n, n)), np.linalg.inv(problem.mass)])
    a, b, c, d, _ = cont2discrete((a, b, np.eye(2 * n), np.zeros((2 * n, n))), dt, method="bilinear")
    # the output of the discrete system is (u, v); its internal state x differs from (u, v)
    load = problem.load(0.0)
    x = np.linalg.solve(c, np.concatenate([problem.u0, problem.v0]) - d @ load)
    rows = [c @ x + d @ load]
    for i in range(1, steps + 1):
        x, load = a @ x + b @ load, problem.load(i * dt)
        rows.append(c @ x + d @ load)
    return np.array(rows)[:, :n], np.array(rows)[:, n:]
