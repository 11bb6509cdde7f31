"""Verdict on a case: whether the motions of a code agree with the expected ones, and the likely cause if not."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from conformance.causes import Known, Search, explained
from conformance.compared import Compared, Motion, where
from conformance.fitted import ambiguity
from conformance.problem import Problem
from conformance.schemes import run

CASES = Path(__file__).parent / "cases"

#: Largest number of digits reported, the digits of double precision.
DIGITS = 16.0

#: Number of steps, and tolerance relative to the largest value, with which the cause of a wrong order or of a growing
#: energy is sought.
FIRST, SAME = 3, 1e-9


class Unsupported(Exception):
    """The code has no such scheme or problem."""


class Verdict(NamedTuple):
    """Outcome of one case.

    Attributes
    ----------
    verdict
        ``pass``, ``differs`` (the values agree with an alternative, or only the acceleration differs), ``fail`` or
        ``skip``.
    digits
        Number of correct digits of the worst value, relative to the largest value of its quantity. In a case of the
        kind ``order``, number of correct digits of the last displacement with the smallest steps. None if no values are
        compared.
    cause
        What differs, the likely cause of a failure, or the reason of a skipped case; empty for a pass.
    where
        Which of u, v and a agree, and from which step on the others differ; empty if they are not compared.
    finding
        The wrong order, or the energy that grows, in a case of the kind ``order`` or ``bound``; empty otherwise.
    order
        The wrong order with two decimals; None if the order is right or not measured.
    """

    name: str
    verdict: str
    digits: float | None = None
    cause: str = ""
    where: str = ""
    finding: str = ""
    order: float | None = None

    @property
    def sentence(self) -> str:
        """What is wrong and its cause, as far as there are any."""
        return ": ".join(filter(None, (self.finding, self.cause)))


def judged(cases: Sequence[Mapping[str, Any]], runner: Callable[[Mapping[str, Any], int], Motion]) -> list[Verdict]:
    """Verdicts on the cases of one code, in their order.

    Cases in which a cause has one name are judged first. A cause with several names, such as the factors 2 and γ/β of
    average acceleration, then has the name that it has there.
    """
    known: Known = set()
    verdicts = {case["name"]: judge(case, partial(runner, case), known) for case in sorted(cases, key=ambiguity)}
    return [verdicts[case["name"]] for case in cases]


def judge(case: Mapping[str, Any], motion: Callable[[int], Motion], known: Known | None = None) -> Verdict:
    """Verdict on one case.

    Parameters
    ----------
    motion
        Function of a whole number ``part``. It returns the motion of the code with the step size Δt/part and ``part``
        times the number of steps of the case. It raises ``Unsupported`` to skip the case, and ``ValueError`` with a
        sentence to fail it.
    known
        Causes found in other cases of the same code, which are tried first; a new cause is added.
    """
    known = set() if known is None else known
    name, expected = case["name"], case["expect"]
    try:
        if expected[0]["kind"] == "order":
            return _order(case, motion, known)
        if expected[0]["kind"] == "bound":
            return _bound(case, motion(1), known)
        return _identical(case, motion(1), known)
    except Unsupported as reason:
        return Verdict(name, "skip", cause=str(reason))
    except ValueError as error:
        return Verdict(name, "fail", cause=str(error))


def _order(case: Mapping[str, Any], motion: Callable[[int], Motion], known: Known) -> Verdict:
    (expected,) = case["expect"]
    end, halvings = float(expected["value"]), range(4)
    motions = [motion(2**k) for k in halvings]
    ends = [_finite(result, "u")[-1, expected["unknown"]] for result in motions]
    errors = np.maximum(np.abs(np.array(ends) - end), np.finfo(float).tiny)
    slope, digits = -float(np.polyfit(halvings, np.log2(errors), 1)[0]), _digits(errors[-1], abs(end))
    if abs(slope - int(expected["order"])) <= float(expected["tolerance"]):
        return Verdict(case["name"], "pass", digits)
    verdict = _failed(case, motions[0], known, f"the order is {slope:.2f}, not {expected['order']}", digits)
    return verdict._replace(order=round(slope, 2))


def _bound(case: Mapping[str, Any], motion: Motion, known: Known) -> Verdict:
    (expected,), problem = case["expect"], Problem(case["problem"])
    if motion["v"] is None:
        raise Unsupported("an energy needs the velocity")
    states = zip(_finite(motion, "u"), _finite(motion, "v"), strict=True)
    energies = np.array([problem.energy(u, v) for u, v in states])
    largest = float(max(energies) / energies[0])
    if largest <= float(expected["limit"]):
        return Verdict(case["name"], "pass")
    limit = expected["limit"]
    finding = f"the energy grows to {largest:.3g} times its value at the start; {limit} is the limit"
    return _failed(case, motion, known, finding)


def _failed(
    case: Mapping[str, Any], motion: Motion, known: Known, finding: str, digits: float | None = None
) -> Verdict:
    """Failure of a case that states no values. The first steps of the scheme, computed here, show the cause."""
    dt, _ = times(case)
    right = run(Problem(case["problem"]), case["scheme"], dt, FIRST)
    pairs = [
        Compared(name, i, [*range(FIRST + 1)], values[:, i], moved[: FIRST + 1, i], SAME * scale, scale)
        for name, values in right.items()
        for moved in [motion[name]]
        if name != "a" and moved is not None
        for i in range(values.shape[1])
        for scale in [float(np.max(np.abs(values[:, i])))]
    ]
    if all(pair.agrees for pair in pairs):
        return Verdict(case["name"], "fail", digits, "", where(pairs), finding)
    _, cause = explained(Search(case, pairs, dt, FIRST), known)
    return Verdict(case["name"], "fail", digits, cause, where(pairs), finding)


def _finite(motion: Motion, name: str) -> np.ndarray:
    values = np.asarray(motion[name])
    if not np.isfinite(values).all():
        raise ValueError(f"{name} is not finite from step {int(np.argmin(np.isfinite(values).all(axis=1)))} on")
    return values


def _digits(error: float, scale: float) -> float:
    return round(min(DIGITS, max(0.0, -math.log10(max(error / scale, 1e-300)))), 1)


def _identical(case: Mapping[str, Any], motion: Motion, known: Known) -> Verdict:
    pairs = [
        Compared(
            expected["quantity"],
            expected["unknown"],
            expected["at"],
            np.array([float(text) for text in expected["values"]]),
            _finite(motion, expected["quantity"])[expected["at"], expected["unknown"]],
            float(expected["tolerance"]),
            float(expected["scale"]),
        )
        for expected in case["expect"]
        if motion[expected["quantity"]] is not None
    ]
    digits = min(_digits(float(max(abs(pair.values - pair.expected))), pair.scale) for pair in pairs)
    if all(pair.agrees for pair in pairs):
        return Verdict(case["name"], "pass", digits)
    moving = [pair for pair in pairs if pair.quantity != "a"]
    if all(pair.agrees for pair in moving):
        text = "displacement and velocity agree; the acceleration is not the one that the scheme carries"
        return Verdict(case["name"], "differs", digits, text, where(pairs))
    verdict, cause = explained(Search(case, moving, *times(case)), known)
    return Verdict(case["name"], verdict, digits, cause, where(pairs))


def times(case: Mapping[str, Any], part: int = 1) -> tuple[float | np.ndarray, int]:
    """The step size divided by ``part``, and the number of steps multiplied by ``part``.

    For unequal steps, the array of their sizes and their number, whatever ``part`` is.
    """
    sizes = np.array(case["run"].get("sizes", []), float)
    return (sizes, len(sizes)) if sizes.size else (float(case["run"]["dt"]) / part, case["run"]["steps"] * part)
