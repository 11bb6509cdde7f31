"""Expected values and the values of a code, side by side."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

#: Displacement ``u``, velocity ``v`` and acceleration ``a`` at the start and after every step, each (steps + 1, n).
#: Velocity and acceleration may be None.
Motion = Mapping[str, np.ndarray | None]

#: Largest rounding error of a stored value of a variant, relative to the largest value.
STORED = 1e-11


class Compared(NamedTuple):
    """One list of expected values and the values of the code, for one quantity of one unknown at the steps ``at``."""

    quantity: str
    unknown: int
    at: list[int]
    expected: np.ndarray
    values: np.ndarray
    tolerance: float
    scale: float

    @property
    def agrees(self) -> bool:
        """Whether all values agree within the tolerance."""
        return bool(np.all(np.abs(self.values - self.expected) <= self.tolerance))


def where(pairs: Sequence[Compared]) -> str:
    """A sentence that states which of u, v and a agree, and from which step on the others differ."""
    parts = []
    for name in dict.fromkeys(pair.quantity for pair in pairs):
        wrong = [
            step
            for pair in pairs
            if pair.quantity == name
            for step, is_wrong in zip(pair.at, np.abs(pair.values - pair.expected) > pair.tolerance, strict=True)
            if is_wrong
        ]
        parts.append(f"{name} differs from step {min(wrong)} on" if wrong else f"{name} agrees")
    return ", ".join(parts)


def same(pairs: Sequence[Compared], values: Sequence[np.ndarray]) -> bool:
    """Whether the values of the code are these values, within the tolerance of the case and rounding."""
    return all(
        bool(np.all(np.abs(pair.values - x) <= pair.tolerance + STORED * max(pair.scale, np.max(np.abs(x), initial=0))))
        for pair, x in zip(pairs, values, strict=True)
    )


def values_of(pairs: Sequence[Compared], motion: Motion) -> list[np.ndarray]:
    """Values of a motion at the places of the pairs."""
    return [motion[pair.quantity][pair.at, pair.unknown] for pair in pairs]  # type: ignore[index]
