"""Likely cause of values that differ from the expected ones: a change of the scheme that reproduces the code's values.

A cause is named only if the changed scheme gives all values of the code within the tolerance of the case. Changes
without a number are tried first, then changes with a number, such as the point of the step at which a load is taken,
whose number is fitted.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from conformance.changes import March, fixed, twice
from conformance.compared import Compared, same, values_of
from conformance.fitted import Change, numbered

#: Largest unexplained fraction of the difference at which a wrong parameter is named as the likely cause.
UNEXPLAINED = 0.01

#: Largest error of a parameter, or of a factor, whose effect its derivative predicts.
SLIGHT = 0.1

#: Relative difference below which single precision or an iteration that ends early is the likely cause.
EARLY = 1e-5

#: Largest size of a fitted number. Other numbers reproduce the values of single cases only.
LARGEST = 4.0

#: Largest number of corrections of a fitted number, and step of the differences that correct it.
CORRECTIONS, APART = 12, 1e-6

#: Texts and numbers of the changes that explain other cases of the same code; the number is empty if it was fitted.
Known = set[tuple[str, str]]


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
            pair._replace(at=pair.at[:number], expected=pair.expected[:number], values=pair.values[:number])
            for pair in pairs
            for number in [sum(step <= self.first for step in pair.at)]
        ]

    def gives(self, motion: March) -> bool:
        """Whether a changed scheme gives all values of the code; False if it fails."""
        try:
            return all(
                same(pairs, values_of(pairs, motion(steps)))
                for pairs, steps in ((self.few, self.first), (self.pairs, self.steps))
            )
        except (ArithmeticError, np.linalg.LinAlgError):
            return False

    def differences(self, motion: March) -> np.ndarray:
        """Differences from the values of the code up to the first wrong one, relative to the scale; inf if it fails."""
        try:
            values = values_of(self.few, motion(self.first))
        except (ArithmeticError, np.linalg.LinAlgError):
            return np.full(1, math.inf)
        return np.concatenate([(x - pair.values) / pair.scale for pair, x in zip(self.few, values, strict=True)])

    def fitted(self, change: Change) -> float | None:
        """The number with which a change gives the values of the code; None if there is none."""
        x, errors = change.neutral, self.differences(partial(change.motion, change.neutral))
        for _ in range(CORRECTIONS):
            slope = (self.differences(partial(change.motion, x + APART)) - errors) / APART
            if slope.shape != errors.shape or not 0 < (size := float(slope @ slope)) < math.inf:
                return None
            next_errors = self.differences(partial(change.motion, x - float(errors @ slope) / size))
            if not np.linalg.norm(next_errors) < np.linalg.norm(errors):
                break
            x, errors = x - float(errors @ slope) / size, next_errors
        is_likely = round(x, 4) != change.neutral and abs(x) <= LARGEST
        return x if is_likely and self.gives(partial(change.motion, x)) else None

    def numbered(self, known: Known) -> str:
        """Text of a change with a number, such as 0, β/γ or 0.3, that gives the values of the code; or empty."""
        changes = [*numbered(self.case, self.dt)]
        likely = [(change, name, x) for change in changes for name, x in change.likely.items()]
        for change, name, x in sorted(likely, key=lambda entry: (entry[0].text, entry[1]) not in known):
            if self.gives(partial(change.motion, x)):
                known.add((change.text, name))
                return change.text.format(name)
        for change in sorted(changes, key=lambda change: (change.text, "") not in known):
            if (number := self.fitted(change)) is not None:
                name = f"{round(number, 4):g}"
                known.update([(change.text, name), (change.text, "")])
                return change.text.format(name)
        return ""


@np.errstate(all="ignore")  # the code or a changed scheme may be unstable
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
        if same(pairs, values):
            return verdict, text
    for verdict, text, motion in fixed(case, search.dt):
        if search.gives(motion):
            return verdict, text
    if text := search.numbered(known) or _slope(case, pairs):
        return "fail", text
    for text, motion in twice(case, search.dt):
        if search.gives(motion):
            return "fail", text
    if max(float(np.max(np.abs(pair.values - pair.expected))) / pair.scale for pair in pairs) <= EARLY:
        early = "" if case["problem"]["form"] == "linear" else ", or an iteration ends early"
        return "fail", f"numbers are in single precision{early}"
    return "fail", "not known"


def _stored(case: Mapping[str, Any], pairs: Sequence[Compared]) -> Iterator[tuple[str, str, list[np.ndarray]]]:
    """Variants whose values are in the case; none for a case that holds no values."""
    listed = [(expected.get("quantity"), expected.get("unknown")) for expected in case["expect"]]
    for variant in case.get("variants", ()):
        values = [variant["values"][listed.index((pair.quantity, pair.unknown))] for pair in pairs]
        yield variant["verdict"], variant["text"], [np.array([*map(float, texts)]) for texts in values]


def _slope(case: Mapping[str, Any], pairs: Sequence[Compared]) -> str:
    """A sentence if a slightly wrong parameter explains almost all of the difference; empty otherwise."""
    scales = np.concatenate([np.full(len(pair.values), pair.scale) for pair in pairs])
    differences = np.concatenate([pair.values - pair.expected for pair in pairs]) / scales
    listed = [(expected.get("quantity"), expected.get("unknown")) for expected in case["expect"]]
    fits = []
    for slope in case.get("slopes", ()):
        parts = [slope["slopes"][listed.index((pair.quantity, pair.unknown))] for pair in pairs]
        direction = np.concatenate([np.array([*map(float, part)]) for part in parts]) / scales
        if (size := direction @ direction) > 0:
            change = float(differences @ direction / size)
            rest = float(np.linalg.norm(differences - change * direction) / np.linalg.norm(differences))
            fits.append((rest, slope["number"], change))
    if fits and min(fits)[0] <= UNEXPLAINED and abs(min(fits)[2]) <= SLIGHT:
        return f"{min(fits)[1]} is off by about {min(fits)[2]:.2g}"
    return ""
