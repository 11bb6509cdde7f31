"""Verdict on a case: whether the motions of a code agree with the expected ones, and the likely cause if not."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from conformance.problem import Problem
from conformance.schemes import POINT, run
from conformance.variants import LATER, VARIANTS

CASES = Path(__file__).parent / "cases"

#: Largest number of digits reported, the digits of double precision.
DIGITS = 16.0

#: Largest rounding error of a stored value of a variant, relative to the largest value.
STORED = 1e-11

#: Largest unexplained fraction of the difference at which a wrong parameter is named as the likely cause.
UNEXPLAINED = 0.01

#: Relative difference below which single precision or an iteration that ends early is the likely cause.
EARLY = 1e-5

#: Number of corrections of the point of the step at which a load is sought, and the difference of its derivative, in
#: units of the step size.
CORRECTIONS, APART = 8, 1e-6

#: Displacement ``u``, velocity ``v`` and acceleration ``a`` at the start and after every step, each (steps + 1, n).
#: Velocity and acceleration may be None.
Motion = Mapping[str, np.ndarray | None]


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
    """

    name: str
    verdict: str
    digits: float | None = None
    cause: str = ""


def judge(case: Mapping[str, Any], motion: Callable[[int], Motion]) -> Verdict:
    """Verdict on one case.

    Parameters
    ----------
    motion
        Function of a whole number ``part``. It returns the motion of the code with the step size Δt/part and ``part``
        times the number of steps of the case. It raises ``Unsupported`` to skip the case, and ``ValueError`` with a
        sentence to fail it.
    """
    name, expected = case["name"], case["expect"]
    try:
        if expected[0]["kind"] == "order":
            return _order(case, motion)
        if expected[0]["kind"] == "bound":
            return _bound(case, motion(1))
        return _identical(case, motion(1))
    except Unsupported as reason:
        return Verdict(name, "skip", cause=str(reason))
    except ValueError as error:
        return Verdict(name, "fail", cause=str(error))


def _numbers(texts: list) -> np.ndarray:
    return np.array([float(text) for text in texts])


def _order(case: Mapping[str, Any], motion: Callable[[int], Motion]) -> Verdict:
    (expected,) = case["expect"]
    end, halvings = float(expected["value"]), range(4)
    ends = [_finite(motion(2**k)["u"])[-1, expected["unknown"]] for k in halvings]
    errors = np.maximum(np.abs(np.array(ends) - end), np.finfo(float).tiny)
    slope = -float(np.polyfit(halvings, np.log2(errors), 1)[0])
    if abs(slope - int(expected["order"])) <= float(expected["tolerance"]):
        return Verdict(case["name"], "pass", _digits(errors[-1], abs(end)))
    return Verdict(
        case["name"], "fail", _digits(errors[-1], abs(end)), f"the order is {slope:.2f}, not {expected['order']}"
    )


def _bound(case: Mapping[str, Any], motion: Motion) -> Verdict:
    (expected,), problem = case["expect"], Problem(case["problem"])
    if motion["v"] is None:
        raise Unsupported("an energy needs the velocity")
    moved = zip(_finite(motion["u"]), _finite(motion["v"]), strict=True)
    energies = np.array([problem.energy(u, v) for u, v in moved])
    largest = float(max(energies) / energies[0])
    if largest <= float(expected["limit"]):
        return Verdict(case["name"], "pass")
    cause = f"the energy grows to {largest:.3g} times its value at the start; {expected['limit']} is the limit"
    return Verdict(case["name"], "fail", cause=cause)


def _finite(values: Any) -> np.ndarray:
    if not np.isfinite(values).all():
        raise ValueError(f"values are not finite from step {int(np.argmin(np.isfinite(values).all(axis=1)))} on")
    return values


def _digits(error: float, scale: float) -> float:
    return round(min(DIGITS, max(0.0, -math.log10(max(error / scale, 1e-300)))), 1)


class _Compared(NamedTuple):
    """One list of expected values, and the values of the code."""

    expected: np.ndarray
    found: np.ndarray
    tolerance: float
    scale: float


def _identical(case: Mapping[str, Any], motion: Motion) -> Verdict:
    given = [one for one in case["expect"] if motion[one["quantity"]] is not None]
    pairs = [
        _Compared(
            _numbers(one["values"]),
            _finite(motion[one["quantity"]])[one["at"], one["unknown"]],
            float(one["tolerance"]),
            float(one["scale"]),
        )
        for one in given
    ]
    digits = min(_digits(float(max(abs(one.found - one.expected))), one.scale) for one in pairs)
    if all(max(abs(one.found - one.expected)) <= one.tolerance for one in pairs):
        return Verdict(case["name"], "pass", digits)
    # variants and slopes have no accelerations; in the list of expected values accelerations are last
    moved = [pair for pair, one in zip(pairs, given, strict=True) if one["quantity"] != "a"]
    places = [
        i for i, one in enumerate(case["expect"]) if motion[one["quantity"]] is not None and one["quantity"] != "a"
    ]
    verdict, cause = _explained(case, moved, places, motion)
    return Verdict(case["name"], verdict, digits, cause)


def _explained(case: Mapping[str, Any], pairs: list[_Compared], places: list[int], motion: Motion) -> tuple[str, str]:
    """Verdict and cause for values that differ from the expected ones."""
    if all(max(abs(one.found - one.expected)) <= one.tolerance for one in pairs):
        return "differs", "displacement and velocity agree; the acceleration is not the one that the scheme carries"
    for variant in case["variants"]:
        values = [_numbers(variant["values"][i]) for i in places]
        if all(
            max(abs(one.found - value)) <= one.tolerance + STORED * max(one.scale, max(abs(value)))
            for one, value in zip(pairs, values, strict=True)
        ):
            return variant["verdict"], variant["text"]
    if late := _late(case, motion):
        return "fail", late
    if met := _met_later(case, pairs, places):
        return met
    if point := _point_of_load(case, pairs, places):
        return "fail", point
    scales = np.concatenate([np.full(len(one.found), one.scale) for one in pairs])
    off = np.concatenate([one.found - one.expected for one in pairs]) / scales
    fits = []
    for slope in case["slopes"]:
        direction = np.concatenate([_numbers(slope["slopes"][i]) for i in places]) / scales
        if (size := direction @ direction) > 0:
            change = float(off @ direction / size)
            fits.append(
                (float(np.linalg.norm(off - change * direction) / np.linalg.norm(off)), slope["number"], change)
            )
    if fits and min(fits)[0] <= UNEXPLAINED:
        return "fail", f"{min(fits)[1]} is off by about {min(fits)[2]:.2g}"
    if float(max(abs(off))) <= EARLY:
        early = "" if case["problem"]["form"] == "linear" else ", or an iteration ends early"
        return "fail", f"numbers are in single precision{early}"
    wrong = {
        quantity: [
            step
            for one in case["expect"]
            for step in one["at"]
            if one["quantity"] == quantity and _wrong(one, motion, step)
        ]
        for quantity in "uv"
    }
    if not wrong["u"]:
        return "fail", f"not known; the displacement agrees, and the velocity differs from step {min(wrong['v'])} on"
    return "fail", f"not known; values differ from step {min(wrong['u'] + wrong['v'])} on"


def _met_later(case: Mapping[str, Any], pairs: list[_Compared], places: list[int]) -> tuple[str, str] | None:
    """Verdict and text of a change that gives the code's values; None if there is no such change.

    Only changes are tried whose values are not in the case.
    """
    (dt, steps), scheme = times(case), case["scheme"]
    changes = [("fail", text, words, changed(case["problem"]), scheme) for text, words, changed in LATER]
    if "sizes" in case["run"]:
        changes += [
            (one.verdict, one.text, one.words, case["problem"], {**scheme, **one.change(scheme)})
            for one in VARIANTS
            if scheme["family"] in one.families
        ]
    for verdict, text, words, problem, other in changes:
        try:
            with np.errstate(all="ignore"):  # a changed scheme may be unstable
                motion = run(Problem(problem), other, dt, steps, words)
        except ArithmeticError:
            continue
        stated = [case["expect"][i] for i in places]
        values = [motion[one["quantity"]][one["at"], one["unknown"]] for one in stated]
        if all(max(abs(one.found - value)) <= one.tolerance for one, value in zip(pairs, values, strict=True)):
            return verdict, text
    return None


def _point_of_load(case: Mapping[str, Any], pairs: list[_Compared], places: list[int]) -> str:
    """A sentence if the values are those of a load at one other point of each step; empty otherwise."""
    if not {"load", "ground"} & case["problem"].keys():
        return ""
    (dt, steps), stated = times(case), [case["expect"][i] for i in places]
    found = np.concatenate([one.found for one in pairs])
    allowed = np.concatenate([np.full(len(one.found), one.tolerance) for one in pairs])

    def off(point: float) -> np.ndarray:
        with np.errstate(all="ignore"):
            motion = run(Problem(case["problem"]), case["scheme"], dt, steps, [f"{POINT}{point!r}"])
        return found - np.concatenate([motion[one["quantity"]][one["at"], one["unknown"]] for one in stated])

    point = 0.5
    for _ in range(CORRECTIONS):
        slope = (off(point + APART) - off(point)) / APART
        if not 0 < slope @ slope < math.inf:
            return ""
        point = float(np.clip(point - off(point) @ slope / (slope @ slope), 0, 1))
    right = np.all(np.abs(off(point)) <= allowed)
    return f"the load is that of another point of the step, t + {round(point, 4):g} Δt" if right else ""


def times(case: Mapping[str, Any], part: int = 1) -> tuple[float | np.ndarray, int]:
    """The step size divided by ``part``, and the number of steps multiplied by ``part``.

    For unequal steps, the array of their sizes and their number, whatever ``part`` is.
    """
    sizes = np.array(case["run"].get("sizes", []), float)
    return (sizes, len(sizes)) if sizes.size else (float(case["run"]["dt"]) / part, case["run"]["steps"] * part)


def _wrong(expected: Mapping[str, Any], motion: Motion, step: int) -> bool:
    values, at = motion[expected["quantity"]], expected["at"].index(step)
    if values is None:
        return False
    return bool(abs(values[step, expected["unknown"]] - float(expected["values"][at])) > float(expected["tolerance"]))


def _late(case: Mapping[str, Any], motion: Motion) -> str:
    """A sentence if the displacement of the first unknown is right but one step late or early; empty otherwise."""
    first = case["expect"][0]
    found, wanted = _finite(motion["u"])[:, first["unknown"]], _numbers(first["values"])
    for shift, word in ((1, "late"), (-1, "early")):
        pairs = [(step + shift, value) for step, value in zip(first["at"], wanted, strict=True)]
        inside = [(step, value) for step, value in pairs if 0 <= step < len(found)]
        if len(inside) > 1 and all(abs(found[step] - value) <= float(first["tolerance"]) for step, value in inside):
            return f"values are right but one step {word}"
    return ""
