"""Newmark's family in NumPy, an example of a code that the kit runs.

``conform conformance.examples.newmark:step`` judges Newmark's method, central difference,
Wilson's θ-method, HHT-α and generalized-α on every problem of the kit.
"""

import numpy as np

FAMILIES = ("newmark", "central_difference", "hht", "generalized_alpha", "wilson")


def step(problem, scheme, dt, steps):
    """Displacement, velocity and acceleration at the start and after every step, each (steps + 1, n)."""
    family = scheme["family"]
    if family not in FAMILIES:
        raise NotImplementedError(f"it has no {family}")
    numbers = {name: float(value) for name, value in scheme.items() if name != "family"}
    beta = numbers["beta"] if "beta" in numbers else {"central_difference": 0.0, "wilson": 1 / 6}[family]
    gamma, theta = numbers.get("gamma", 0.5), numbers.get("theta", 1.0)
    alpha_m, alpha_f = numbers.get("alpha_m", 0.0), numbers.get("alpha_f", -numbers.get("alpha", 0.0))
    part = 1 - alpha_f
    M, C = problem.mass, problem.damping
    u, v = problem.u0, problem.v0
    a = np.linalg.solve(M, problem.load(0.0) - C @ v - problem.force(u))
    rows = [(u, v, a)]
    sizes = np.broadcast_to(dt, steps)
    for t, dt in zip(np.cumsum(sizes) - sizes, sizes, strict=True):
        tau = theta * dt
        load = problem.load(t + part * tau)
        u_ahead = u + tau * v + tau**2 * (0.5 - beta) * a
        v_ahead = v + tau * (1 - gamma) * a
        if beta == 0:
            new = np.linalg.solve(M + gamma * dt * C, load - C @ v_ahead - problem.force(u_ahead))
        else:
            x = u
            for _ in range(50):
                new = (x - u_ahead) / (beta * tau**2)
                v_new = v_ahead + gamma * tau * new
                at = part * x + alpha_f * u
                residual = M @ ((1 - alpha_m) * new + alpha_m * a) + C @ (part * v_new + alpha_f * v)
                residual = residual + problem.force(at) - load
                slope = (1 - alpha_m) * M / (beta * tau**2) + part * (C * gamma / (beta * tau) + problem.tangent(at))
                change = np.linalg.solve(slope, residual)
                x = x - change
                if np.abs(change).max() <= 1e-14 * np.abs(x).max():
                    break
            new = (x - u_ahead) / (beta * tau**2)
        new = a + (new - a) / theta
        u = u + dt * v + dt**2 * ((0.5 - beta) * a + beta * new)
        v = v + dt * ((1 - gamma) * a + gamma * new)
        a = new
        problem.commit(u)
        rows.append((u, v, a))
    return [np.array(history) for history in zip(*rows, strict=True)]
