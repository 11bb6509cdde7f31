"""A step of Newmark's family in which every term has a factor, to find the factor that a code uses.

Newmark's method, central difference, Wilson's θ-method, HHT-α and generalized-α are one step with other parameters:

    u* = u₀ + τ v₀ + τ² (½ − β) a₀,  v* = v₀ + τ (1 − γ) a₀,  τ = θ Δt,
    M (a₀ + m (a − a₀)) + C (v₀ + w (v − v₀)) + p(u₀ + w (u − u₀)) = f(t₀ + w τ),  m = 1 − α_m,  w = 1 − α_f,

with u = u* + τ² β a and v = v* + τ γ a. Then a₁ = a₀ + (a − a₀) / θ, and u₁ and v₁ follow from the first line with Δt
instead of τ. A mistake in a code often changes one term of these formulas, by a factor or a sign, or omits it.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from conformance.problem import Problem

#: Families of schemes that are one step with other parameters.
FAMILIES = ("newmark", "central_difference", "hht", "generalized_alpha", "wilson")

#: Terms with a factor, which is 1 in the scheme: names in the formulas below, and the text for the report. A text may
#: belong to several names, which then have the same factor.
TERMS: dict[tuple[str, ...], str] = {
    ("u*u", "u1u"): "u₀ in the displacement",
    ("u*v", "u1v"): "Δt v₀ in the displacement",
    ("u*a", "u1a"): "Δt² (½ − β) a₀ in the displacement",
    ("u*n", "u1n"): "Δt² β a₁ in the displacement",
    ("u*a", "u*n", "u1a", "u1n"): "Δt² ((½ − β) a₀ + β a₁) in the displacement",
    ("u1v", "u1a", "u1n"): "u₁ − u₀ in the displacement, after the balance alone",
    ("u1a", "u1n"): "Δt² ((½ − β) a₀ + β a₁) in the displacement, after the balance alone",
    ("v*a", "v*n", "v1a", "v1n"): "Δt ((1 − γ) a₀ + γ a₁) in the velocity",
    ("v1a", "v1n"): "Δt ((1 − γ) a₀ + γ a₁) in the velocity, after the balance alone",
    ("u*v", "u*a"): "Δt v₀ + Δt² (½ − β) a₀ in the displacement, for the balance alone",
    ("u*u", "u*v", "u*a"): "u₀ + Δt v₀ + Δt² (½ − β) a₀ in the displacement, for the balance alone",
    ("v*v", "v*a"): "v₀ + Δt (1 − γ) a₀ in the velocity, for the balance alone",
    ("v*v", "v1v"): "v₀ in the velocity",
    ("v*a", "v1a"): "Δt (1 − γ) a₀ in the velocity",
    ("v*n", "v1n"): "Δt γ a₁ in the velocity",
    **{
        (f"{letter}{side}{term}",): f"{text} in the {quantity}, {place}"
        for side, place in (("*", "for the balance alone"), ("1", "after the balance alone"))
        for quantity, letter, terms in (
            ("displacement", "u", {"u": "u₀", "v": "Δt v₀", "a": "Δt² (½ − β) a₀", "n": "Δt² β a₁"}),
            ("velocity", "v", {"v": "v₀", "a": "Δt (1 − γ) a₀", "n": "Δt γ a₁"}),
        )
        for term, text in terms.items()
    },
    ("inertia",): "M a in the balance",
    ("inertia of a0",): "α_m M a₀ in the balance",
    ("inertia of a1",): "(1 − α_m) M a₁ in the balance",
    ("damping",): "C v in the balance",
    ("damping of v0",): "α_f C v₀ in the balance",
    ("damping of v1",): "(1 − α_f) C v₁ in the balance",
    ("point of force",): "1 − α_f in p(u)",
    ("point of damping",): "1 − α_f in C v",
    ("point of inertia",): "1 − α_m in M a",
    ("point of load",): "1 − α_f in f(t)",
    ("point of force", "point of damping", "point of load"): "1 − α_f in the balance",
    ("force of u1", "damping of v1", "point of load"): "1 − α_f in the balance, for the end of the step alone",
    ("force",): "p(u) in the balance",
    ("force of u0",): "α_f u₀ in p(u)",
    ("force of u1",): "(1 − α_f) u₁ in p(u)",
    ("load",): "f(t) in the balance",
    ("theta",): "1/θ in the interpolation of the acceleration",
    ("theta of a0",): "a₀/θ in the interpolation of the acceleration",
    ("start load",): "f(0) in the acceleration at the start",
    ("start damping",): "C v₀ in the acceleration at the start",
    ("start force",): "p(u₀) in the acceleration at the start",
}

#: Largest number of iterations of a step.
_ITERATIONS = 30


def run(
    problem: Problem, scheme: Mapping[str, Any], dt: Any, steps: int, factors: Mapping[str, float]
) -> dict[str, np.ndarray]:
    """Motion with the factors of some terms; all other factors are 1. The arguments are those of ``schemes.run``.

    Raises
    ------
    ArithmeticError
        If an iteration does not end.
    """
    family, k = scheme["family"], lambda name: factors.get(name, 1.0)
    numbers = {name: float(value) for name, value in scheme.items() if name != "family"}
    beta = numbers.get("beta", {"central_difference": 0.0, "wilson": 1 / 6}.get(family, 0.0))
    gamma, theta = numbers.get("gamma", 0.5), numbers.get("theta", 1.0)
    alpha_m, alpha_f = numbers.get("alpha_m", 0.0), numbers.get("alpha_f", -numbers.get("alpha", 0.0))
    w, mass, damping, t, u, v = 1 - alpha_f, problem.mass, problem.damping, 0.0, problem.u0, problem.v0

    def moved(side, u, v, a, tau):
        """Displacement and velocity as functions of a₁, each as a pair of constant and slope."""
        place = k(f"u{side}u") * u + k(f"u{side}v") * tau * v + k(f"u{side}a") * tau**2 * (0.5 - beta) * a
        speed = k(f"v{side}v") * v + k(f"v{side}a") * tau * (1 - gamma) * a
        return (place, k(f"u{side}n") * beta * tau**2), (speed, k(f"v{side}n") * gamma * tau)

    start = k("start load") * problem.load(0.0) - k("start damping") * damping @ v
    a = np.linalg.solve(mass, start - k("start force") * problem.force(u))
    rows = [(u, v, a)]
    for size in np.broadcast_to(dt, steps).tolist():
        tau, x = theta * size, a
        place, speed = moved("*", u, v, a, tau)
        m1, c1, p1 = ((1 - alpha_m) * k("point of inertia"), w * k("point of damping"), w * k("point of force"))
        m0, c0, p0 = (k("inertia of a0") * (1 - m1), k("damping of v0") * (1 - c1), k("force of u0") * (1 - p1))
        m1, c1, p1 = k("inertia of a1") * m1, k("damping of v1") * c1, k("force of u1") * p1
        m0, m1, c0, c1 = k("inertia") * m0, k("inertia") * m1, k("damping") * c0, k("damping") * c1
        rest = (
            m0 * mass @ a
            + damping @ (c0 * v + c1 * speed[0])
            - k("load") * problem.load(t + k("point of load") * w * tau)
        )
        for _ in range(_ITERATIONS):
            u_point = p0 * u + p1 * (place[0] + place[1] * x)
            residual = m1 * mass @ x + c1 * speed[1] * damping @ x + k("force") * problem.force(u_point) + rest
            slope = m1 * mass + c1 * speed[1] * damping
            change = np.linalg.solve(slope + k("force") * p1 * place[1] * problem.tangent(u_point), residual)
            x = x - change
            if abs(change).max() <= 1e-13 * (abs(x).max() + abs(a).max()):
                break
        else:
            raise ArithmeticError("the iteration does not end")
        new = a + k("theta") * (x - k("theta of a0") * a) / theta
        place, speed = moved("1", u, v, a, size)
        t, u, v, a = t + size, place[0] + place[1] * new, speed[0] + speed[1] * new, new
        problem.commit(u)
        rows.append((u, v, a))
    return {name: np.array([row[i] for row in rows]) for i, name in enumerate("uva")}
