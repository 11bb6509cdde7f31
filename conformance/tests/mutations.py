"""Mistakes for the programs in NumPy and C: a text of the source, its replacement, and words of the reported cause."""

PYTHON = [
    ('numbers["beta"] if', '1e-3 + numbers["beta"] if', "beta is off by about 0.001"),
    ('numbers.get("gamma", 0.5)', 'numbers.get("gamma", 0.5) + 1e-3', "gamma is off by about 0.001"),
    (
        'numbers.get("theta", 1.0)',
        'numbers.get("theta", 1.0) + 1e-3 * ("theta" in numbers)',
        "theta is off by about 0.001",
    ),
    ('-numbers.get("alpha", 0.0)', '-1.01 * numbers.get("alpha", 0.0)', "alpha is off by about -0.001"),
    (
        "a = np.linalg.solve(M, problem.load(0.0) - C @ v - problem.force(u))",
        "a = 0 * u",
        "acceleration at the start is zero",
    ),
    ("problem.load(0.0) - C @ v - problem", "problem.load(0.0) - problem", "leaves out the damping"),
    ("problem.load(0.0) - C @ v", "-C @ v", "leaves out the load"),
    ("u, v = problem.u0, problem.v0", "u, v = problem.u0, 0 * problem.v0", "velocity at the start is ignored"),
    ("problem.load(t + part * tau)", "problem.load(t)", "load is that of the start"),
    ("problem.load(t + part * tau)", "problem.load(t + part * dt)", "load is that of the end"),
    ("problem.load(t + part * tau)", "problem.load(t + tau)", "load is that of the end"),
    ("problem.load(t + part * tau)", "problem.load(t + tau / 2)", "load is that of the middle"),
    ("problem.load(t + part * tau)", "problem.load(t + dt + part * tau)", "one step too late"),
    ("problem.load(t + part * tau)", "problem.load(t + 0.3 * tau)", "another point of the step, t + 0.3 Δt"),
    ("problem.load(t + part * tau)", "problem.load(t + alpha_f * tau)", "another point of the step, t + 0.4444 Δt"),
    ("problem.load(t + part * tau)", "0 * u", "f(t) in the balance has the factor 0"),
    (
        "residual + problem.force(at) - load",
        "residual + problem.force(at) + load",
        "f(t) in the balance has the factor -1",
    ),
    ("C @ (part * v_new + alpha_f * v)", "C @ v", "velocity at the start of the step"),
    ("C @ (part * v_new + alpha_f * v)", "C @ v_new", "velocity at the end of the step"),
    ("range(50)", "range(1)", "stops after one iteration"),
    ('gamma, theta = numbers.get("gamma", 0.5)', "gamma, theta = 0.5", "γ is 1/2"),
    ("v = v + dt * ((1 - gamma) * a + gamma * new)", "v = v + dt * (1 - gamma) * a", "leaves out the new acceleration"),
    ("new = a + (new - a) / theta", "new = new", "not interpolated back"),
    (
        'theta = numbers.get("gamma", 0.5), numbers.get("theta", 1.0)',
        'theta = numbers.get("gamma", 0.5), 1.0',
        "θ is 1",
    ),
    ('numbers.get("alpha_m", 0.0)', "0.0", "α_m is missing"),
    ("at = part * x + alpha_f * u", "at = x", "internal force is that of the end"),
    ("problem.commit(u)", "pass", "not remembered"),
    (
        "rows.append((u, v, a))",
        "rows.append((u, v - gamma * dt * (a - sum(row[2] for row in rows[-1:])), a))",
        "u agrees, v differs from step 1 on",
    ),
    (
        "M, C = problem.mass, problem.damping",
        "M, C = np.diag(np.diag(problem.mass)), problem.damping",
        "masses that couple unknowns",
    ),
    (
        "M, C = problem.mass, problem.damping",
        "M, C = 1.001 * problem.mass, problem.damping",
        "the mass is 1.001 times",
    ),
    ("1e-14 * np.abs(x).max()", "1e-4 * np.abs(x).max()", "ends early"),
    ("rows = [(u, v, a)]", "rows = [(u, v, a), (u, v, a)]; steps -= 1", "one step late"),
    (
        "rows = [(u, v, a)]",
        """rows = [(u, v, a)]
    if family == "central_difference":
        a = np.linalg.solve(M + dt / 2 * C, M @ a)
        v = v + dt / 2 * a""",
        "taken for that of half a step before",
    ),
    (
        "a = new\n",
        "a = np.linalg.solve(M, problem.load(t + dt) - C @ v - problem.force(u))\n",
        "derived from the equation",
    ),
    ("- sizes, sizes, strict=True)", "- sizes, [sizes[0], *sizes[:-1]], strict=True)", "size of the one before"),
]

#: Source text and replacement of a valid change: the carried acceleration is moved to each new step, so that the
#: generalized-α method stays of second order on unequal steps.
MOVED = (
    "        tau = theta * dt\n",
    """        if t > 0:
            a = a + (alpha_m - alpha_f) * (dt / before - 1) * (a - used)
        tau, before, used = theta * dt, dt, a
""",
)

C = [
    ("0.5 - beta) * a, v_ahead", "0.5 - beta - 1e-3) * a, v_ahead", ""),
    ("double a = (load(0) - c * v - force(u)) / m;", "double a = 0;", "acceleration at the start is zero"),
    ("force(at) - load(t)", "force(at) - load(t - dt)", "load is that of the start"),
    ("c * (v_ahead + gamma * dt * a)", "c * v", "velocity at the start of the step"),
    ("j < 50", "j < 1", "stops after one iteration"),
    ('number("\\"gamma\\"", 0.5)', "0.5", "γ is 1/2"),
    ('phase = number("\\"phase\\"", 0)', "phase = 0", "phase of the load is missing"),
    ("frequency * t - phase", "frequency * t + phase", "phase of the load has the opposite sign"),
    ("A * cos(", "A * sin(", "a sine instead of a cosine"),
    ("A * cos(frequency", "A * cos(2 * 3.14159265358979 * frequency", "taken in cycles"),
    ("S1 * u * (1 + S2 * u * u)", "(S1 * u + S2 * u * u * u)", "leaves out S1"),
    ('number("\\"dt\\"", 0)', '1.001 * number("\\"dt\\"", 0)', "the step size is 1.001 times"),
]
