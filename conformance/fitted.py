"""Changes of a scheme with a number, such as the point of the step at which a load is taken."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from conformance import coefficients
from conformance.changes import first_sizes
from conformance.compared import Motion
from conformance.problem import Problem
from conformance.schemes import DELAY, POINT, START, run
from conformance.variants import CARRIED

#: Factors that are tried before a factor is fitted: a term is omitted, reversed, doubled or halved.
FACTORS = (0.0, -1.0, 2.0, 0.5)


class Change(NamedTuple):
    """A change of a scheme with one number.

    Attributes
    ----------
    text
        Text for the report, with a place ``{}`` for the number.
    motion
        Function of the number and of the number of steps that returns the changed motion.
    neutral
        Number with which nothing changes.
    likely
        Numbers that are tried before the number is fitted, by their names.
    """

    text: str
    motion: Callable[[float, int], Motion]
    neutral: float
    likely: Mapping[str, float]


class Changed(Problem):
    """A problem in which a part has a factor, or whose time starts elsewhere."""

    def __init__(self, text: Mapping[str, Any], factor: Mapping[str, float]):
        super().__init__(text)
        self.factor = {"force": 1.0, "load": 1.0, "time": 0.0, **factor}
        self.mass, self.damping = factor.get("mass", 1.0) * self.mass, factor.get("damping", 1.0) * self.damping
        self.u0, self.v0 = factor.get("u0", 1.0) * self.u0, factor.get("v0", 1.0) * self.v0

    def force(self, u: np.ndarray) -> np.ndarray:
        """p(u) times its factor."""
        return self.factor["force"] * super().force(u)

    def tangent(self, u: np.ndarray) -> np.ndarray:
        """∂p/∂u times its factor."""
        return self.factor["force"] * super().tangent(u)

    def load(self, t: Any) -> np.ndarray:
        """f(t) times its factor, at a shifted time."""
        return self.factor["load"] * super().load(t + self.factor["time"])


#: Symbols of the parameters of schemes, the parameter that a code may confuse with each, and parameters of Newmark's
#: family that a case does not state.
_SYMBOLS = {"alpha": "α", "beta": "β", "gamma": "γ", "alpha_m": "α_m", "alpha_f": "α_f", "theta": "θ"}
_PARTNERS = {"β": "γ", "γ": "β", "α_m": "α_f", "α_f": "α_m"}
_DEFAULTS = {
    "central_difference": {"beta": "0", "gamma": "0.5"},
    "wilson": {"beta": str(1 / 6), "gamma": "0.5"},
    "hht": {"alpha_m": "0"},
}

#: Parts of a problem that may have a factor.
_PARTS = {
    "mass": "the mass",
    "damping": "the damping",
    "force": "the internal force",
    "load": "the load",
    "u0": "the displacement at the start",
    "v0": "the velocity at the start",
}


def numbered(case: Mapping[str, Any], dt: Any) -> Iterator[Change]:
    """Changes with a number that is fitted: time, parameters, parts of the problem, terms of Newmark's family."""
    text, scheme, loaded = case["problem"], case["scheme"], {"load", "ground"} & case["problem"].keys()
    factors = _named(*FACTORS) | _replacements(case, dt)

    def with_words(word: str) -> Callable[[float, int], Motion]:
        return lambda x, steps: run(Problem(text), scheme, first_sizes(dt, steps), steps, (f"{word}{x!r}",))

    def with_parameter(name: str, value: float) -> Callable[[float, int], Motion]:
        return lambda x, steps: run(Problem(text), {**scheme, name: repr(value + x)}, first_sizes(dt, steps), steps)

    def with_size(x: float, steps: int) -> Motion:
        return run(Problem(text), scheme, x * np.asarray(first_sizes(dt, steps)), steps)

    def with_terms(names: tuple[str, ...]) -> Callable[[float, int], Motion]:
        return lambda x, steps: coefficients.run(
            Problem(text), scheme, first_sizes(dt, steps), steps, dict.fromkeys(names, x)
        )

    def with_factors(**scales: float) -> Callable[[float, int], Motion]:
        return lambda x, steps: run(
            Changed(text, {name: x * scale for name, scale in scales.items()}), scheme, first_sizes(dt, steps), steps
        )

    def factor(name: str, motion: Callable[[float, int], Motion]) -> Change:
        return Change(name, motion, 1.0, factors)

    if loaded:
        size = float(np.min(dt))
        point = "the load is that of another point of the step, t + {} Δt"
        yield Change(point, with_words(POINT), 0.5, _named(0.0, 1.0))
        yield Change("each load is that of {} Δt later", with_words(DELAY), 0.0, _named(0.5, -0.5, -1.0))
        time = "the time of the load starts at {} Δt"
        yield Change(time, with_factors(time=size), 0.0, _named(1.0, -1.0, 0.5, -0.5))
    for name in ("gamma",) if scheme["family"] == "central_difference" else scheme:
        if name not in ("family", "start"):
            yield Change(f"{name} is off by about {{}}", with_parameter(name, float(scheme.get(name, 0.5))), 0.0, {})
    yield factor("the step size is {} times that of the case", with_size)
    for name, part in _PARTS.items():
        if name != "load" or loaded:
            yield factor(f"{part} is {{}} times that of the case", with_factors(**{name: 1.0}))
    if scheme["family"] in CARRIED:
        yield factor("the acceleration at the start is {} times that of the equation of motion", with_words(START))
    if scheme["family"] in coefficients.FAMILIES:
        for names, term in coefficients.TERMS.items():
            yield factor(f"the term {term} has the factor {{}}", with_terms(names))


def _named(*numbers: float) -> dict[str, float]:
    return {f"{x:g}": x for x in numbers}


def _replacements(case: Mapping[str, Any], dt: Any) -> dict[str, float]:
    """Factors of a term with another number in its place, without a number or with a wrong sign, by their formulas."""
    family = case["scheme"]["family"]
    parameters = {
        name: float(x) for name, x in (_DEFAULTS.get(family, {}) | case["scheme"]).items() if name in _SYMBOLS
    }
    numbers = {_SYMBOLS[name]: x for name, x in parameters.items()}
    if "α" in numbers:
        numbers["α_f"] = -numbers.pop("α")
    factors = {} if np.ndim(dt) else {"Δt": dt, "1/Δt": 1 / dt, "1/Δt²": 1 / dt**2}
    factors |= {f"1/{name}": 1 / x for name, x in numbers.items() if x}
    for name, x in numbers.items():
        # the weights are ½ − β, 1 − γ, 1 − α_m and 1 − α_f
        total, size = ("½", 0.5) if name == "β" else ("1", 1.0)
        if name == "θ" or x == size:
            continue
        weight = f"({total} − {name})"
        factors |= {f"1/{weight}": 1 / (size - x), f"{total}/{weight}": size / (size - x)}
        factors[f"({total} + {name})/{weight}"] = (size + x) / (size - x)
        if (partner := _PARTNERS[name]) in numbers:
            factors[f"({total} − {partner})/{weight}"] = (size - numbers[partner]) / (size - x)
            factors |= {f"{partner}/{name}": numbers[partner] / x} if x else {}
    if len(case["problem"]["u0"]) == 1:
        parts = {"M": float(case["problem"]["mass"][0][0]), "C": float(case["problem"]["damping"][0][0])}
        factors |= {f"1/{name}": 1 / x for name, x in parts.items() if x}
    return {name: x for name, x in factors.items() if x != 1}


def ambiguity(case: Mapping[str, Any]) -> int:
    """Number of the named factors that have the same value as another one, so that a cause may get a wrong name."""
    factors = [*(_named(*FACTORS) | _replacements(case, float(case["run"].get("dt", 1.0)))).values()]
    return len(factors) - len({round(x, 9) for x in factors})
