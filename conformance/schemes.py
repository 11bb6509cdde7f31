"""Formulas of the schemes, in double precision or with mpmath, which give the values of the cases.

The implicit schemes solve for the displacement, as textbooks on finite elements do. The formulas share no code with the
schemes of the study. Words such as ``no load`` change a scheme into a legitimate alternative or into a scheme with a
mistake.
"""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from conformance.problem import Problem, solve

#: Largest number of Newton iterations.
ITERATIONS = 60

#: Beginning of the word that evaluates every load at one point of the step; the point in units of Δt follows.
POINT = "load at point "

#: Beginning of the word that takes every load of the steps later; the delay in units of Δt follows.
DELAY = "load later by "

#: Beginning of the word that multiplies the acceleration at the start; the factor follows.
START = "start times "

#: Beginning of the word that stops Newton's iteration; the number of iterations from the last displacement follows.
SOME = "iterations "


def _number(words: Collection[str], beginning: str, absent: Any) -> Any:
    """The number after the beginning of a word; ``absent`` without such a word."""
    return next((float(word.removeprefix(beginning)) for word in words if word.startswith(beginning)), absent)


class March:
    """State of a run: t, u, v and the carried acceleration a. The method with the name of a family makes a step."""

    def __init__(self, problem: Problem, scheme: Mapping[str, Any], dt: Any, words: Collection[str]):
        self.problem, self.dt, self.words = problem, dt, words
        self.numbers = {
            name: problem.numbers.mpf(value) for name, value in scheme.items() if name not in ("family", "start")
        }
        self.t, self.u, self.v = 0 * dt, problem.u0, 0 * problem.v0 if "no v0" in words else problem.v0
        self.rows: list[tuple] = []
        resisted = not {"a0 without damping", "no damping"} & set(words)
        force = (
            self.signed(problem.load(self.t)) * ("a0 without load" not in words) - problem.damping @ self.v * resisted
        )
        self.a = solve(problem.mass, force - problem.force(self.u)) * ("a0 = 0" not in words)
        self.a = self.a * _number(words, START, 1)
        if "start by backward Euler" in words:
            self.a = self.twice_by_half_steps()
        self.before, self.half = self.a, self.v
        self.start = scheme.get("start", "")
        self.past = self.fictitious(self.start) if scheme["family"] == "houbolt" else []

    def next_size(self, size: Any) -> None:
        """Set the size of the next step; two alternatives also correct the carried acceleration, to keep second order.

        The acceleration of generalized-α belongs to t₁ + (α_m − α_f) Δt, with the size Δt of the step that ends at t₁.
        """
        change = size / self.dt - 1
        if "corrected for step" in self.words:
            alpha_m, alpha_f = (
                self.numbers.get("alpha_m", 0),
                self.numbers.get("alpha_f", -self.numbers.get("alpha", 0)),
            )
            self.a = self.a + (alpha_m - alpha_f) * change * (self.a - self.before)
        elif "scaled for step" in self.words:
            self.a = self.a + change * (self.a - self.acceleration(0, self.u, self.v))
        self.dt, self.before = size, self.a

    def twice_by_half_steps(self) -> np.ndarray:
        """Accelerations of two half steps of backward Euler, extrapolated to the start without a division by two."""
        u, v, h, speeds = self.u, self.v, self.dt / 2, [self.v]
        for part in (1 / self.problem.numbers.mpf(2), 1):
            a = self.balanced((u + h * v, h**2 / 2), (v, h), (0 * v, 1), self.load(part))
            u, v = u + h * v + h**2 / 2 * a, v + h * a
            speeds.append(v)
        return (4 * speeds[1] - 3 * speeds[0] - speeds[2]) / h

    def signed(self, load: np.ndarray) -> np.ndarray:
        """The load that the scheme applies: a scheme with a mistake may omit it or reverse its sign."""
        return load * (0 if "no load" in self.words else -1 if "sign of load" in self.words else 1)

    def load(self, part: Any) -> np.ndarray:
        """f(t₀ + part Δt)."""
        words, load = self.words, self.problem.load
        if "mean of loads" in words:
            return (1 - part) * load(self.t) + part * load(self.t + self.dt)
        places = {"load at start": 0, "load at end": 1, "load at half": 1 / self.problem.numbers.mpf(2)}
        part = next((place for word, place in places.items() if word in words), part)
        part = _number(words, POINT, part)
        later = ("load early" in words) + _number(words, DELAY, 0)
        return self.signed(load(self.t + (part + later) * self.dt))

    def acceleration(self, part: Any, u: np.ndarray, v: np.ndarray, lag: Any = 0, force: Any = None) -> np.ndarray:
        """The acceleration a that solves M a + C (v + lag a) + p(u) = f(t₀ + part Δt).

        A given ``force`` takes the place of p(u).
        """
        damping = self.problem.damping * ("no damping" not in self.words)
        if "damping at start" in self.words:
            v, lag = self.v, 0
        force = self.problem.force(u) if force is None else force
        return solve(self.problem.mass + lag * damping, self.load(part) - damping @ v - force)

    def balanced(self, place, damping, inertia, load, weight=1, rest=0) -> np.ndarray:
        """The solution x of M (a + a′x) + C (v + v′x) + w p(u + u′x) + rest = f, by Newton's iteration.

        ``place``, ``damping`` and ``inertia`` are the pairs (u, u′), (v, v′) and (a, a′). ``load`` is f.
        ``weight`` is w.
        """
        problem, words = self.problem, self.words
        viscous = problem.damping * ("no damping" not in words)
        if "damping at start" in words:
            damping = (self.v, 0)
        constant = inertia[1] * problem.mass + damping[1] * viscous
        limit = 1 if {"one iteration", "one iteration from a"} & set(words) else int(_number(words, SOME, 0))
        x = self.u if "one iteration from a" not in words else self.u + self.dt * self.v + self.dt**2 / 2 * self.a
        for _ in range(limit or ITERATIONS):
            u = place[0] + place[1] * x
            residual = problem.mass @ (inertia[0] + inertia[1] * x) + viscous @ (damping[0] + damping[1] * x)
            residual = residual + weight * problem.force(u) + rest - load
            change = solve(constant + weight * place[1] * problem.tangent(u), residual)
            if "commit in iterations" in words:
                problem.commit(u)
            x = x - change
            if max(abs(change)) <= 8 * problem.numbers.eps * (max(abs(x)) + max(abs(self.u))):
                break
        else:
            if not limit:
                raise ArithmeticError(f"Newton's iteration did not end at t = {self.t}.")
        if "commit at balance" in words:
            problem.commit(place[0] + place[1] * x)
        return x

    def move(self, u: np.ndarray, v: np.ndarray, a: np.ndarray | None = None) -> None:
        """Advance to t₁, commit the history there and store the motion; the equation of motion gives a missing a."""
        self.u, self.v, self.t = u, v, self.t + self.dt
        self.a = self.acceleration(0, u, v) if a is None or "rederived" in self.words else a
        if not {"no commit", "commit at balance", "commit in iterations"} & set(self.words):
            self.problem.commit(u)
        self.rows.append((self.u, self.v, self.a))

    def fictitious(self, start: str) -> list:
        """Displacements at −2Δt, −Δt and 0 for Houbolt's method; u₀ alone if another scheme makes two steps first."""
        if "two steps" in start:
            return [self.u]
        u, v, a, dt = self.u, self.v, self.a, self.dt
        if start == "taylor":
            return [u - 2 * dt * v + 2 * dt**2 * a, u - dt * v + dt**2 / 2 * a, u]
        velocity, inertia = self.newmark_place(self.problem.numbers.mpf(1) / 6)
        first = self.balanced((0 * u, 1), velocity, inertia, self.load(1))
        before = dt**2 * a - first + 2 * u
        return [6 * dt * v - 2 * first - 3 * u + 6 * before, before, u]

    def newmark_place(self, beta: Any, gamma: Any = None) -> tuple:
        """v₁ and a₁ as linear functions of u₁, each as a pair of constant and slope, by Newmark's formulas."""
        u, v, a, dt = self.u, self.v, self.a, self.dt
        gamma = self.problem.numbers.mpf(1) / 2 if gamma is None else gamma
        new = -(u + dt * v) / (beta * dt**2) - (1 / (2 * beta) - 1) * a, 1 / (beta * dt**2)
        return (v + dt * ((1 - gamma) * a + gamma * new[0]), dt * gamma * new[1]), new

    def generalized_alpha(self, alpha_m: Any, alpha_f: Any, beta: Any, gamma: Any) -> None:
        """Generalized-α; Newmark's method for α_m = α_f = 0."""
        u, part = self.u, 1 - alpha_f
        velocity, inertia = self.newmark_place(beta, gamma)
        if "start forgotten" in self.words and len(self.rows) == 1:
            velocity = velocity[0] - self.dt * (1 - gamma / (2 * beta)) * self.a, velocity[1]
            inertia = inertia[0] + self.v / (beta * self.dt), inertia[1]
            weighted = (1 - alpha_m) * inertia[0] + alpha_m * self.a, (1 - alpha_m) * inertia[1]
            load = part * self.signed(self.problem.load(self.t + self.dt))
            x = self.balanced((0 * u, 1), (part * velocity[0], part * velocity[1]), weighted, load, weight=part)
            self.move(x, velocity[0] + velocity[1] * x, inertia[0] + inertia[1] * x)
            return
        inertia = (1 - alpha_m) * inertia[0] + alpha_m * self.a, (1 - alpha_m) * inertia[1]
        damping = part * velocity[0] + alpha_f * self.v, part * velocity[1]
        if "damping at end" in self.words:
            damping = velocity
        if "force at end" in self.words:
            x = self.balanced((0 * u, 1), damping, inertia, self.load(part))
        elif "two forces" in self.words:
            rest = alpha_f * self.problem.force(u)
            x = self.balanced((0 * u, 1), damping, inertia, self.load(part), weight=part, rest=rest)
        else:
            x = self.balanced((alpha_f * u, part), damping, inertia, self.load(part))
        new_velocity, new = self.newmark_place(beta, gamma)
        v = self.v + self.dt * (1 - gamma) * self.a if "no new a in v" in self.words else None
        self.move(x, new_velocity[0] + new_velocity[1] * x if v is None else v, new[0] + new[1] * x)

    def newmark(self, beta: Any, gamma: Any) -> None:
        """Newmark's method."""
        if beta == 0:
            self.central_difference(gamma)
        else:
            self.generalized_alpha(0, 0, beta, gamma)

    def hht(self, alpha: Any, beta: Any, gamma: Any) -> None:
        """The α-method of Hilber, Hughes and Taylor, with the force at the weighted displacement."""
        self.generalized_alpha(0, -alpha, beta, gamma)

    def hht_1996(self, alpha: Any, beta: Any, gamma: Any) -> None:
        """HHT-α with the weighted forces of both ends of the step; neither damping nor load is weighted."""
        self.words = {*self.words, "two forces", "damping at end", "load at end"}
        self.hht(alpha, beta, gamma)

    def central_difference(self, gamma: Any = None) -> None:
        """Newmark's method with β = 0, and γ = ½ by default."""
        dt, gamma = self.dt, self.problem.numbers.mpf(1) / 2 if gamma is None else gamma
        for word, changed in (
            ("three displacements", self.three_displacements),
            ("predicted damping", self.predicted_damping),
            ("late leapfrog", self.late_leapfrog),
        ):
            if word in self.words:
                changed()
                return
        if "start at half" in self.words and len(self.rows) == 1:
            self.a = self.acceleration(0, self.u, self.v, dt / 2)
            self.v = self.v + dt / 2 * self.a
        half = self.v + dt * (1 - gamma) * self.a
        u = self.u + dt * self.v + dt**2 / 2 * self.a
        lag = 0 if "damping at half" in self.words else gamma * dt
        a = self.acceleration(1, u, half, lag)
        self.move(u, half + gamma * dt * a, a)
        if "velocity at half" in self.words:
            self.rows[-1] = (u, half, a)

    def three_displacements(self) -> None:
        """Central difference with the displacements of two steps, and velocities by backward differences."""
        dt, u, problem = self.dt, self.u, self.problem
        if not self.past:
            self.past = [u if "start forgotten" in self.words else u - dt * self.v + dt**2 / 2 * self.a]
        (before,) = self.past
        viscous = problem.damping / (2 * dt)
        right = self.load(0) - problem.force(u) + problem.mass @ (2 * u - before) / dt**2 + viscous @ before
        new = solve(problem.mass / dt**2 + viscous, right)
        v = (3 * new - 4 * u + before) / (2 * dt)
        self.past = [u]
        self.move(new, v, (v - self.v) / dt)

    def predicted_damping(self) -> None:
        """Central difference whose damping acts on v₀ + Δt a₀, and whose displacement takes the load of t₁."""
        dt, u, v, a = self.dt, self.u, self.v, self.a
        u = u + dt * v - dt**2 / 2 * a + dt**2 * self.acceleration(1, u, v)
        new = self.acceleration(1, u, v + dt * a)
        self.move(u, v + dt / 2 * (a + new), new)

    def late_leapfrog(self) -> None:
        """Central difference with velocities of half steps, whose output has the velocity of the step before.

        Each step takes its own size for that of the step before.
        """
        a = self.acceleration(1, self.u, self.v)
        v = self.half + self.dt / 2 * a if len(self.rows) > 1 else self.v
        self.half = v + self.dt / 2 * a
        self.move(self.u + self.dt * self.half, v, a)

    def wilson(self, theta: Any) -> None:
        """Wilson's θ-method with a linear acceleration."""
        u, v, a, tau = self.u, self.v, self.a, theta * self.dt
        inertia = -6 / tau**2 * (u + tau * v) - 2 * a, 6 / tau**2
        x = self.balanced((0 * u, 1), (-3 / tau * u - 2 * v - tau / 2 * a, 3 / tau), inertia, self.load(theta))
        ahead, dt = inertia[0] + inertia[1] * x, self.dt
        new = ahead if "no interpolation" in self.words else a + (ahead - a) / theta
        self.move(u + dt * v + dt**2 / 6 * (2 * a + new), v + dt / 2 * (a + new), new)

    def houbolt(self) -> None:
        """Houbolt's method, started by fictitious displacements or by two steps of another scheme."""
        if len(self.past) < 3:
            if self.start == "two steps of average acceleration":
                quarter = self.problem.numbers.mpf(1) / 4
                self.generalized_alpha(0, 0, quarter, 2 * quarter)
            else:
                self.central_difference()
        else:
            (u2, u1, u0), dt = self.past, self.dt
            inertia = (-5 * u0 + 4 * u1 - u2) / dt**2, 2 / dt**2
            damping = (-18 * u0 + 9 * u1 - 2 * u2) / (6 * dt), 11 / (6 * dt)
            x = self.balanced((0 * u0, 1), damping, inertia, self.load(1))
            self.move(x, damping[0] + damping[1] * x, inertia[0] + inertia[1] * x)
        self.past = [*self.past[-2:], self.u]

    def bathe(self, gamma: Any, rho_inf: Any) -> None:
        """The composite method: the trapezoidal rule to t₀ + γΔt, then a formula through three points."""
        u, v, a, whole = self.u, self.v, self.a, self.dt * (1 + ("sub-steps" in self.words))
        part, self.dt = gamma * whole, whole
        place = -2 / part * u - v, 2 / part
        inertia = 2 / part * (place[0] - v) - a, (2 / part) ** 2
        middle = self.balanced((0 * u, 1), place, inertia, self.load(1 if "first load at end" in self.words else gamma))
        v_middle, a_middle = (pair[0] + pair[1] * middle for pair in (place, inertia))
        if "sub-steps" in self.words:
            self.rows.append((middle, v_middle, a_middle))
        if "no commit" not in self.words:
            self.problem.commit(middle)
        q1 = (1 + rho_inf) / (2 * gamma * (rho_inf - 1) + 4)
        q0, q2 = (gamma - 1) * q1 + self.problem.numbers.mpf(1) / 2, self.problem.numbers.mpf(1) / 2 - gamma * q1
        place = -(u + whole * (q0 * v + q1 * v_middle)) / (q2 * whole), 1 / (q2 * whole)
        inertia = (place[0] - v - whole * (q0 * a + q1 * a_middle)) / (q2 * whole), (1 / (q2 * whole)) ** 2
        x = self.balanced((0 * u, 1), place, inertia, self.load(1))
        self.move(x, place[0] + place[1] * x, inertia[0] + inertia[1] * x)
        self.dt = whole / (1 + ("sub-steps" in self.words))

    def rk4(self) -> None:
        """The classical Runge-Kutta method."""
        dt, half = self.dt, self.problem.numbers.mpf(1) / 2
        stages: list[tuple] = []
        for part in (0 * half, half, half, 2 * half):
            u, v = self.u, self.v
            if stages:
                u, v = u + part * dt * stages[-1][0], v + part * dt * stages[-1][1]
            stages.append((v, self.acceleration(part, u, v)))
        weights = (1, 1, 1, 1) if "equal weights" in self.words else (1, 2, 2, 1)
        change = [
            dt * sum(w * stage[i] for w, stage in zip(weights, stages, strict=True)) / sum(weights) for i in (0, 1)
        ]
        self.move(self.u + change[0], self.v + change[1])

    def midpoint(self) -> None:
        """The implicit midpoint rule."""
        u, v, half = self.u, self.v, self.dt / 2
        load = self.load(1 / self.problem.numbers.mpf(2))
        x = self.balanced((0 * u, 1), (-u / half, 1 / half), (-(u / half + v) / half, 1 / half**2), load)
        self.move(2 * x - u, 2 * (x - u) / half - v)

    def symplectic_euler(self) -> None:
        """A kick, then a drift; the damping acts on the mean of the velocities before and after the kick."""
        dt, u = self.dt, self.u
        if "drift first" in self.words:
            u = u + dt * self.v
            v = self.v + dt * self.acceleration(1, u, self.v, dt / 2)
        else:
            v = self.v + dt * self.acceleration(0, u, self.v, dt / 2)
            u = u + dt * v
        self.move(u, v)

    def kr_alpha(self, rho_inf: Any) -> None:
        """The explicit method of Kolay and Ricles, whose coefficients contain the stiffness at u = 0."""
        dt, problem = self.dt, self.problem
        alpha_m, alpha_f = (2 * rho_inf - 1) / (rho_inf + 1), rho_inf / (rho_inf + 1)
        gamma = problem.numbers.mpf(1) / 2 - alpha_m + alpha_f
        beta, part = (gamma + problem.numbers.mpf(1) / 2) ** 2 / 4, 1 - alpha_f
        model = gamma * dt * problem.damping + beta * dt**2 * problem.tangent(0 * self.u)
        effective = problem.mass + model
        first = solve(effective, problem.mass @ self.a)
        factor = 1 / problem.numbers.mpf(2) if "no gamma in u" in self.words else gamma + problem.numbers.mpf(1) / 2
        u, v = self.u + dt * self.v + factor * dt**2 * first, self.v + dt * first
        force = part * problem.force(u) + alpha_f * problem.force(self.u) if "two forces" in self.words else None
        ahead = self.acceleration(part, part * u + alpha_f * self.u, part * v + alpha_f * self.v, force=force)
        right = effective @ ahead - (alpha_m * problem.mass + alpha_f * model) @ self.a
        self.move(u, v, solve((1 - alpha_m) * problem.mass + part * model, right))

    def noh_bathe(self, p: Any) -> None:
        """The explicit method of Noh and Bathe with two sub-steps."""
        u, v, a, h, k = self.u, self.v, self.a, p * self.dt, (1 - p) * self.dt
        half = 1 / self.problem.numbers.mpf(2)
        q1 = (1 - 2 * p) / (2 * p * (1 - p))
        q2 = half - p * q1
        middle = u + h * v + h**2 / 2 * a
        a_middle = self.acceleration(p, middle, v + h * a)
        v_middle = v + h / 2 * (a + a_middle)
        self.problem.commit(middle)
        new = middle + k * v_middle + k**2 / 2 * a_middle
        a_new = self.acceleration(1, new, v_middle + k * a_middle)
        self.move(new, v_middle + k * ((half - q1 - q2) * a + (half + q1) * a_middle + q2 * a_new), a_new)

    def tchamwa_wielgosz(self, phi: Any) -> None:
        """The explicit method of Tchamwa and Wielgosz."""
        u, v = self.u + self.dt * self.v + phi * self.dt**2 * self.a, self.v + self.dt * self.a
        self.move(u, v, self.acceleration(1, u, v))


def run(
    problem: Problem, scheme: Mapping[str, Any], dt: Any, steps: int, words: Collection[str] = ()
) -> dict[str, np.ndarray]:
    """Displacement u, velocity v and carried acceleration a at t = 0 and after each step, each (steps + 1, n).

    Parameters
    ----------
    scheme
        The part ``scheme`` of a case.
    dt
        Common size of all steps, or an array with the size of each step.
    words
        Changes of the scheme, listed in ``variants.py``.
    """
    sizes = [dt] * steps if np.ndim(dt) == 0 else [*dt]
    if "late sizes" in words:
        sizes = [sizes[0], *sizes[:-1]]
    march = March(problem, scheme, sizes[0], words)
    march.rows.append((march.u, march.v, march.a))
    while len(march.rows) <= steps:
        march.next_size(sizes[len(march.rows) - 1])
        getattr(march, scheme["family"])(**march.numbers)
    return {name: np.array([row[i] for row in march.rows[: steps + 1]]) for i, name in enumerate("uva")}
