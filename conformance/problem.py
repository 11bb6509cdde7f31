"""Formulas of the problems of the cases, in double precision or with mpmath."""

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

#: Double-precision numbers and functions under the names of mpmath.
FLOAT = SimpleNamespace(mpf=float, cos=math.cos, sin=math.sin, tanh=math.tanh, eps=2e-16)


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solution x (n,) of a linear system by Gaussian elimination with partial pivoting."""
    rows = np.column_stack([matrix, right])
    for i in range(len(rows)):
        pivot = i + max(range(len(rows) - i), key=lambda j: abs(rows[i + j, i]))
        rows[[i, pivot]] = rows[[pivot, i]]
        rows[i] = rows[i] / rows[i, i]
        for j in range(len(rows)):
            if j != i:
                rows[j] = rows[j] - rows[j, i] * rows[i]
    return rows[:, -1]


class Problem:
    """M ü + C u̇ + p(u) = f(t) with n unknowns, as a case states it; README.md has the formulas.

    Parameters
    ----------
    text
        The part ``problem`` of a case.
    numbers
        Numbers and functions: ``FLOAT`` for double precision, or ``mpmath.mp``.

    Attributes
    ----------
    mass, damping
        M and C, each (n, n).
    u0, v0
        Displacement and velocity at t = 0, each (n,).
    """

    def __init__(self, text: Mapping[str, Any], numbers: Any = FLOAT):
        self.text, self.numbers = text, numbers
        self.u0, self.v0 = self.array(text["u0"]), self.array(text["v0"])
        self.mass, self.damping = self.array(text["mass"]), self.array(text["damping"])
        self._parameters = {name: self.array(value) for name, value in text.get("parameters", {}).items()}
        self._plastic = 0 * self.u0

    def array(self, values: Any) -> np.ndarray:
        """Decimal strings as an array."""
        flat = [self.numbers.mpf(value) for value in np.ravel(values).tolist()]
        return np.array(flat, dtype=float if self.numbers is FLOAT else object).reshape(np.shape(values))

    def _each(self, function: str, x: np.ndarray) -> np.ndarray:
        return np.array([getattr(self.numbers, function)(value) for value in x], dtype=x.dtype)

    def _elastic(self, u: np.ndarray) -> np.ndarray:
        bound = self._parameters["yield_force"] / self._parameters["k"]
        return np.minimum(np.maximum(u - self._plastic, -bound), bound)

    def force(self, u: np.ndarray) -> np.ndarray:
        """p(u), shape (n,). The force of an elastoplastic spring depends on the last ``commit``."""
        form, p = self.text["form"], self._parameters
        if form == "linear":
            return p["stiffness"] @ u
        if form == "cubic":
            return p["S1"] * u * (1 + p["S2"] * u * u)
        if form == "tanh":
            return p["S"] * self._each("tanh", u)
        if form == "pendulum":
            return p["g"] * self._each("sin", u)
        if form == "elastoplastic":
            return p["k"] * (p["hardening"] * u + (1 - p["hardening"]) * self._elastic(u))
        if form == "gap":
            return p["k"] * np.maximum(u - p["gap"], 0 * u)
        if form == "stiff_sine":
            soft = p["k2"] * self._each("sin", u[1:] - u[:1])
            return np.concatenate([p["k1"] * u[:1] - soft, soft])
        raise ValueError(f"no problem has the form {form!r}; README.md lists the forms.")

    def tangent(self, u: np.ndarray) -> np.ndarray:
        """∂p/∂u, shape (n, n)."""
        form, p = self.text["form"], self._parameters
        if form == "linear":
            return p["stiffness"]
        if form == "cubic":
            slope = p["S1"] * (1 + 3 * p["S2"] * u * u)
        elif form == "tanh":
            slope = p["S"] * (1 - self._each("tanh", u) ** 2)
        elif form == "pendulum":
            slope = p["g"] * self._each("cos", u)
        elif form == "elastoplastic":
            elastic = self._elastic(u) == u - self._plastic
            slope = p["k"] * (p["hardening"] + (1 - p["hardening"]) * elastic.astype(int))
        elif form == "gap":
            slope = p["k"] * (u > p["gap"]).astype(int)
        else:
            soft = (p["k2"] * self._each("cos", u[1:] - u[:1]))[0]
            return np.array([[p["k1"][()] + soft, -soft], [-soft, soft]])
        return np.diag(slope)

    def energy(self, u: np.ndarray, v: np.ndarray) -> Any:
        """½ u̇ᵀ M u̇ + V(u) for a linear force, or for a cubic force with one unknown."""
        p = self._parameters
        if self.text["form"] == "linear":
            return (v @ self.mass @ v + u @ p["stiffness"] @ u) / 2
        return (v @ self.mass @ v + p["S1"] * u @ u * (1 + p["S2"] * u @ u / 2)) / 2

    def commit(self, u: np.ndarray) -> None:
        """Commit u, the displacement at the end of a step, from which a spring with a memory continues."""
        if self.text["form"] == "elastoplastic":
            self._plastic = u - self._elastic(u)

    def load(self, t: Any) -> np.ndarray:
        """f(t), shape (n,): a harmonic load, plus −M 1 a_g(t).

        The ground acceleration a_g is linear between its samples, and zero before the first and after the last one.
        """
        load = 0 * self.u0
        if harmonic := self.text.get("load"):
            frequency, phase = self.array([harmonic["frequency"], harmonic["phase"]])
            load = load + self.array(harmonic["amplitude"]) * self.numbers.cos(frequency * t - phase)
        if ground := self.text.get("ground"):
            samples = self.array(ground["acceleration"])
            place = t / self.numbers.mpf(ground["dt"])
            if 0 <= place < len(samples) - 1:
                before = int(place)
                acceleration = samples[before] + (place - before) * (samples[before + 1] - samples[before])
                load = load - self.mass.sum(axis=1) * acceleration
        return load
