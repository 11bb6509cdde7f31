"""Likely cause of values that differ from the expected ones: a change of the scheme that reproduces the code's values.

A cause is named only if the changed scheme gives all values of the code within the tolerance of the case. Changes
without a number are tried first, then changes with a number, such as the point of the step at which a load is taken,
whose number is fitted.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from conformance import coefficients
from conformance.problem import Problem
from conformance.schemes import DELAY, POINT, SOME, START, run
from conformance.variants import LATER, VARIANTS

#: Displacement ``u``, velocity ``v`` and acceleration ``a`` at the start and after every step, each (steps + 1, n).
#: Velocity and acceleration may be None.
Motion = Mapping[str, np.ndarray | None]

#: Largest rounding error of a stored value of a variant, relative to the largest value.
STORED = 1e-11

#: Largest unexplained fraction of the difference at which a wrong parameter is named as the likely cause.
UNEXPLAINED = 0.01

#: Relative difference below which single precision or an iteration that ends early is the likely cause.
EARLY = 1e-5

#: Numbers of a change that are tried before its number is fitted: a term is omitted, reversed, doubled or halved.
USUAL = (0.0, -1.0, 2.0, 0.5)

#: Largest size of a fitted number. Other numbers reproduce the values of single cases only.
LARGEST = 4.0

#: Largest number of corrections of a fitted number, and step of the differences that correct it.
CORRECTIONS, APART = 12, 1e-6


class Compared(NamedTuple):
    """One list of expected values and the values of the code, for one quantity of one unknown at the steps ``at``."""

    quantity: str
    unknown: int
    at: list[int]
    expected: np.ndarray
    found: np.ndarray
    tolerance: float
    scale: float

    @property
    def agrees(self) -> bool:
        """Whether all values agree within the tolerance."""
        return bool(np.all(np.abs(self.found - self.expected) <= self.tolerance))


#: Texts and numbers of the changes that explain other cases of the same code; the number is empty if it was fitted.
Known = set[tuple[str, str]]

#: Function of a number of steps that returns the motion of a changed scheme.
March = Callable[[int], Motion]


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
    usual
        Numbers that are tried before the number is fitted.
    """

    text: str
    motion: Callable[[float, int], Motion]
    neutral: float = 1.0
    usual: tuple[float, ...] = USUAL


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


def where(pairs: Sequence[Compared]) -> str:
    """A sentence that states which of u, v and a agree, and from which step on the others differ."""
    parts = []
    for name in dict.fromkeys(pair.quantity for pair in pairs):
        wrong = [
            step
            for pair in pairs
            if pair.quantity == name
            for step, off in zip(pair.at, np.abs(pair.found - pair.expected) > pair.tolerance, strict=True)
            if off
        ]
        parts.append(f"{name} differs from step {min(wrong)} on" if wrong else f"{name} agrees")
    return ", ".join(parts)


class Search:
    """Search for a change of the scheme that gives the values of the code.

    Parameters
    ----------
    case
        The case, which may hold the values of some changes.
    pairs
        Expected values and values of the code, without accelerations; some differ.
    dt, steps
        Step size and number of steps of the run.
    """

    def __init__(self, case: Mapping[str, Any], pairs: Sequence[Compared], dt: Any, steps: int):
        self.case, self.pairs, self.dt, self.steps = case, pairs, dt, steps
        # the first step with a wrong value; a start that is wrong needs a step, too
        self.first = max(
            1,
            min(step for pair in pairs for step, x, y in zip(*pair[2:5], strict=True) if abs(x - y) > pair.tolerance),
        )
        # a change that does not give the values up to the first wrong one need not run further
        self.few = [
            pair._replace(at=pair.at[:number], expected=pair.expected[:number], found=pair.found[:number])
            for pair in pairs
            for number in [sum(step <= self.first for step in pair.at)]
        ]

    def gives(self, motion: March) -> bool:
        """Whether a changed scheme gives all values of the code; False if it fails."""
        try:
            with np.errstate(all="ignore"):  # a changed scheme may be unstable
                return all(
                    _same(pairs, _values(pairs, motion(steps)))
                    for pairs, steps in ((self.few, self.first), (self.pairs, self.steps))
                )
        except (ArithmeticError, np.linalg.LinAlgError):
            return False

    def off(self, motion: March) -> np.ndarray:
        """Differences from the values of the code up to the first wrong one, relative to the scale; inf if it fails."""
        try:
            with np.errstate(all="ignore"):
                values = _values(self.few, motion(self.first))
        except (ArithmeticError, np.linalg.LinAlgError):
            return np.full(1, math.inf)
        return np.concatenate([(x - pair.found) / pair.scale for pair, x in zip(self.few, values, strict=True)])

    def fitted(self, change: Change) -> float | None:
        """The number with which a change gives the values of the code; None if there is none."""
        x, here = change.neutral, self.off(partial(change.motion, change.neutral))
        for _ in range(CORRECTIONS):
            slope = (self.off(partial(change.motion, x + APART)) - here) / APART
            if slope.shape != here.shape or not 0 < (size := float(slope @ slope)) < math.inf:
                return None
            there = self.off(partial(change.motion, x - float(here @ slope) / size))
            if not np.linalg.norm(there) < np.linalg.norm(here):
                break
            x, here = x - float(here @ slope) / size, there
        likely = round(x, 4) != change.neutral and abs(x) <= LARGEST
        return x if likely and self.gives(partial(change.motion, x)) else None

    def numbered(self, known: Known) -> str:
        """Text of a change with a number, such as 0, β/γ or 0.3, that gives the values of the code; or empty."""
        changes, sizes = [*_numbered(self.case, self.dt)], _sizes(self.case, self.dt)
        likely = [(one, name, x) for one in changes for name, x in self.likely(one, sizes)]
        for change, name, x in sorted(likely, key=lambda one: (one[0].text, one[1]) not in known):
            if self.gives(partial(change.motion, x)):
                known.add((change.text, name))
                return change.text.format(name)
        for change in sorted(changes, key=lambda one: (one.text, "") not in known):
            if (number := self.fitted(change)) is not None:
                name = f"{round(number, 4):g}"
                known.update([(change.text, name), (change.text, "")])
                return change.text.format(name)
        return ""

    @staticmethod
    def likely(change: Change, sizes: Mapping[str, float]) -> list[tuple[str, float]]:
        """Numbers that are tried before a number is fitted, with their names."""
        numbers = [(f"{x:g}", x) for x in change.usual]
        return numbers + ([*sizes.items()] if change.neutral == 1 else [])


def explained(search: Search, known: Known) -> tuple[str, str]:
    """Verdict and cause for displacements and velocities that differ from the expected ones.

    Parameters
    ----------
    known
        Texts and numbers of changes that explain other cases of the same code. They are tried first, and a change that
        is found is added.
    """
    case, pairs = search.case, search.pairs
    for verdict, text, values in _stored(case, pairs):
        if _same(pairs, values):
            return verdict, text
    for verdict, text, motion in _fixed(case, search.dt):
        if search.gives(motion):
            return verdict, text
    if text := search.numbered(known) or _slope(case, pairs):
        return "fail", text
    for text, motion in _twice(case, search.dt):
        if search.gives(motion):
            return "fail", text
    if max(float(np.max(np.abs(pair.found - pair.expected))) / pair.scale for pair in pairs) <= EARLY:
        early = "" if case["problem"]["form"] == "linear" else ", or an iteration ends early"
        return "fail", f"numbers are in single precision{early}"
    return "fail", "not known"


def _same(pairs: Sequence[Compared], values: Sequence[np.ndarray]) -> bool:
    return all(
        bool(np.all(np.abs(pair.found - x) <= pair.tolerance + STORED * max(pair.scale, np.max(np.abs(x), initial=0))))
        for pair, x in zip(pairs, values, strict=True)
    )


def _values(pairs: Sequence[Compared], motion: Motion) -> list[np.ndarray]:
    return [motion[pair.quantity][pair.at, pair.unknown] for pair in pairs]  # type: ignore[index]


def _stored(case: Mapping[str, Any], pairs: Sequence[Compared]) -> Iterator[tuple[str, str, list[np.ndarray]]]:
    """Variants whose values are in the case; none for a case that holds no values."""
    listed = [(one.get("quantity"), one.get("unknown")) for one in case["expect"]]
    for variant in case.get("variants", ()):
        values = [variant["values"][listed.index((pair.quantity, pair.unknown))] for pair in pairs]
        yield variant["verdict"], variant["text"], [np.array([*map(float, one)]) for one in values]


def _march(text: Mapping[str, Any], scheme: Mapping[str, Any], dt: Any, words: Sequence[str]) -> March:
    return lambda steps: run(Problem(text), scheme, _first(dt, steps), steps, words)


def _fixed(case: Mapping[str, Any], dt: Any) -> Iterator[tuple[str, str, March]]:
    """Changes without a number whose values are not in the case."""
    text, scheme = case["problem"], case["scheme"]
    for one in VARIANTS if "sizes" in case["run"] or "variants" not in case else ():
        if scheme["family"] in one.families:
            yield one.verdict, one.text, _march(text, {**scheme, **one.change(scheme)}, dt, one.words)
    for name, words, change in LATER:
        yield "fail", name, _march(change(text), scheme, dt, words)
    for name, words, families in _STARTS:
        if scheme["family"] in families:
            yield "fail", name, _march(text, scheme, dt, words)
    for number in (2, 3):
        yield (
            "fail",
            f"Newton's iteration stops after {number} iterations",
            _march(text, scheme, dt, [f"{SOME}{number}"]),
        )
    for name, output in _OUTPUTS.items():
        yield "fail", name, partial(_output, text, scheme, dt, output)


def _late(rows: np.ndarray) -> np.ndarray:
    return np.concatenate([rows[:1], rows[:-1]])


def _early(rows: np.ndarray) -> np.ndarray:
    return np.concatenate([rows[1:], rows[-1:]])


#: Mistakes that some code makes at its start, with their words and families of schemes.
_STARTS = (
    (
        "the velocity is (3 u₁ − 4 u₀ + u₋₁) / (2 Δt)",
        ("three displacements",),
        ("central_difference",),
    ),
    (
        "the displacement before the start is taken for that of the start",
        ("three displacements", "start forgotten"),
        ("central_difference",),
    ),
    (
        "the acceleration at the start is twice the one that two half steps of backward Euler give",
        ("start by backward Euler",),
        ("newmark", "hht", "generalized_alpha"),
    ),
    (
        "the first step leaves out the forces of the start, v₀ in the acceleration and a₀ in the velocity",
        ("start forgotten", "two forces", "mean of loads"),
        ("hht", "generalized_alpha"),
    ),
)


def _sizes(case: Mapping[str, Any], dt: Any) -> dict[str, float]:
    """Factors of a term if another number of the case is in its place, or a number is missing, by their formulas."""
    given = {name: float(x) for name, x in case["scheme"].items() if name not in ("family", "start")}
    given |= {"γ": 0.5} if case["scheme"]["family"] == "central_difference" else {}
    symbols = {"beta": "β", "gamma": "γ", "alpha_m": "α_m", "alpha_f": "α_f", "theta": "θ"}
    numbers = {symbols.get(name, name): x for name, x in given.items()}
    if "alpha" in numbers:
        numbers["α_f"] = -numbers.pop("alpha")
    found = {}
    if np.ndim(dt) == 0:
        found = {"Δt": dt, "1/Δt": 1 / dt, "1/Δt²": 1 / dt**2}
    weights = numbers | {f"(1 − {name})": 1 - x for name, x in numbers.items() if name != "θ"}
    found |= {f"1/{name}": 1 / x for name, x in weights.items() if x}
    for pair in (("β", "γ"), ("α_m", "α_f"), ("(1 − β)", "(1 − γ)"), ("(1 − α_m)", "(1 − α_f)")):
        for first, second in (pair, pair[::-1]):
            if weights.get(first) and weights.get(second):
                found[f"{first}/{second}"] = weights[first] / weights[second]
    if len(case["problem"]["u0"]) == 1:
        parts = {"M": float(case["problem"]["mass"][0][0]), "C": float(case["problem"]["damping"][0][0])}
        found |= {f"1/{name}": 1 / x for name, x in parts.items() if x}
    return {name: x for name, x in found.items() if x != 1}


#: Mistakes of the output: functions of u, v and the step sizes (steps, 1) of a motion that has one step more.
_OUTPUTS: dict[str, Callable[..., tuple[np.ndarray, np.ndarray]]] = {
    "values are right but one step late": lambda u, v, dt: (_late(u), _late(v)),
    "values are right but one step early": lambda u, v, dt: (_early(u), _early(v)),
    "the velocity is one step late": lambda u, v, dt: (u, _late(v)),
    "the velocity is one step early": lambda u, v, dt: (u, _early(v)),
    "the velocity is that of half a step before, (u₁ − u₀)/Δt": lambda u, v, dt: (
        u,
        np.concatenate([v[:1], np.diff(u, axis=0) / dt]),
    ),
    "the velocity is that of half a step later, (u₂ − u₁)/Δt": lambda u, v, dt: (
        u,
        np.concatenate([np.diff(u, axis=0) / dt, v[-1:]]),
    ),
    "the displacement is one step late": lambda u, v, dt: (_late(u), v),
    "the displacement is one step early": lambda u, v, dt: (_early(u), v),
}


def _output(text: Mapping[str, Any], scheme: Mapping[str, Any], dt: Any, change: Callable, steps: int) -> Motion:
    """The right motion with a mistake of the output."""
    sizes = np.append(np.broadcast_to(_first(dt, steps), steps), np.max(dt))
    right = run(Problem(text), scheme, sizes, steps + 1)
    return dict(zip("uv", change(right["u"], right["v"], sizes[:, None]), strict=True))


def _numbered(case: Mapping[str, Any], dt: Any) -> Iterator[Change]:
    """Changes with a number that is fitted: time, parameters, parts of the problem, terms of Newmark's family."""
    text, scheme, loaded = case["problem"], case["scheme"], {"load", "ground"} & case["problem"].keys()

    def with_words(word: str) -> Callable[[float, int], Motion]:
        return lambda x, steps: run(Problem(text), scheme, _first(dt, steps), steps, (f"{word}{x!r}",))

    def with_parameter(name: str, value: float) -> Callable[[float, int], Motion]:
        return lambda x, steps: run(Problem(text), {**scheme, name: repr(value + x)}, _first(dt, steps), steps)

    def with_terms(names: tuple[str, ...]) -> Callable[[float, int], Motion]:
        return lambda x, steps: coefficients.run(
            Problem(text), scheme, _first(dt, steps), steps, {name: x for name in names}
        )

    def with_factor(**names: float) -> Callable[[float, int], Motion]:
        return lambda x, steps: run(
            Changed(text, {name: x * size for name, size in names.items()}), scheme, _first(dt, steps), steps
        )

    if loaded:
        yield Change("the load is that of another point of the step, t + {} Δt", with_words(POINT), 0.5, (0.0, 1.0))
        yield Change("each load is that of {} Δt later", with_words(DELAY), 0.0, (0.5, -0.5, -1.0))
        size = float(np.min(dt))
        yield Change("the time of the load starts at {} Δt", with_factor(time=size), 0.0, (1.0, -1.0, 0.5, -0.5))
    for name in scheme:
        if name not in ("family", "start"):
            yield Change(f"{name} is off by about {{}}", with_parameter(name, float(scheme[name])), 0.0, ())
    yield Change(
        "the step size is {} times that of the case",
        lambda x, steps: run(Problem(text), scheme, x * np.asarray(_first(dt, steps)), steps),
    )
    for name, part in _PARTS.items():
        if name != "load" or loaded:
            yield Change(f"{part} is {{}} times that of the case", with_factor(**{name: 1.0}))
    if scheme["family"] not in ("rk4", "midpoint", "symplectic_euler"):
        yield Change("the acceleration at the start is {} times that of the equation of motion", with_words(START))
    if scheme["family"] in coefficients.FAMILIES:
        for names, term in coefficients.TERMS.items():
            yield Change(f"the term {term} has the factor {{}}", with_terms(names))


#: Parts of a problem that may have a factor.
_PARTS = {
    "mass": "the mass",
    "damping": "the damping",
    "force": "the internal force",
    "load": "the load",
    "u0": "the displacement at the start",
    "v0": "the velocity at the start",
}


def _first(dt: Any, steps: int) -> Any:
    return dt if np.ndim(dt) == 0 else dt[:steps]


def _slope(case: Mapping[str, Any], pairs: Sequence[Compared]) -> str:
    """A sentence if a slightly wrong parameter explains almost all of the difference; empty otherwise."""
    scales = np.concatenate([np.full(len(pair.found), pair.scale) for pair in pairs])
    off = np.concatenate([pair.found - pair.expected for pair in pairs]) / scales
    listed = [(one.get("quantity"), one.get("unknown")) for one in case["expect"]]
    fits = []
    for slope in case.get("slopes", ()):
        parts = [slope["slopes"][listed.index((pair.quantity, pair.unknown))] for pair in pairs]
        direction = np.concatenate([np.array([*map(float, part)]) for part in parts]) / scales
        if (size := direction @ direction) > 0:
            change = float(off @ direction / size)
            rest = float(np.linalg.norm(off - change * direction) / np.linalg.norm(off))
            fits.append((rest, slope["number"], change))
    if fits and min(fits)[0] <= UNEXPLAINED:
        return f"{min(fits)[1]} is off by about {min(fits)[2]:.2g}"
    return ""


def _twice(case: Mapping[str, Any], dt: Any) -> Iterator[tuple[str, March]]:
    """A wrong start together with each variant, and each alternative together with each mistake."""
    text, scheme = case["problem"], case["scheme"]
    known = [one for one in VARIANTS if scheme["family"] in one.families]
    firsts = [one for one in known if one.verdict == "differs" or set(one.words) & {"a0 = 0", "no v0"}]
    for first in firsts:
        for one in known:
            if one is not first:
                changed = {**scheme, **first.change(scheme)}
                changed |= one.change(changed)
                yield f"{first.text}, and {one.text}", _march(text, changed, dt, (*first.words, *one.words))
