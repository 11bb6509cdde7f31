"""Quantities of a program's runs, and their differences between runs at different steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from study.observer.motion import Quantity
from study.program.attempt import Run, Times, Values

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

#: Interpolation between the steps.
INTERPOLATION = "cubic splines through the steps of the finer run"

#: Fewest points of a curve whose error of interpolation is estimated from every second point.
FEWEST = 8


#: Largest difference, relative to a step, of two times that count as equal.
SAME = 1e-6


@dataclass(frozen=True)
class Curve:
    """A quantity along its times, of shape (t, ...), or a single number, of shape (), without times.

    ``quantity`` is the quantity of a problem that the values belong to, if any; it states the scale of errors.
    """

    t: Times
    values: Values
    quantity: Quantity | None = None

    @cached_property
    def sizes(self) -> np.ndarray:
        """Largest absolute value of each component, of shape (components,)."""
        return np.abs(self.values).reshape(max(len(self.t), 1), -1).max(axis=0)

    @cached_property
    def scale(self) -> np.ndarray:
        """Scale of the error of each component, by default the largest absolute value of all, (components,)."""
        if self.quantity is None:
            return np.full(self.sizes.shape, self.sizes.max())
        return self.quantity.scales(self.sizes, self.sizes)

    @cached_property
    def _spline(self) -> CubicSpline:
        from scipy.interpolate import CubicSpline  # imported here, because only programs need it

        return CubicSpline(self.t, self.values)

    @property
    def _slack(self) -> float:
        return SAME * (self.t[1] - self.t[0])

    def holds(self, times: np.ndarray) -> bool:
        """Whether all these times are times of this curve; a single number holds any times."""
        if not self.values.ndim:
            return True
        return bool((np.abs(self.t[self._places(times)] - times) <= self._slack).all())

    def _places(self, times: np.ndarray) -> np.ndarray:
        return np.searchsorted(self.t, times - self._slack).clip(max=len(self.t) - 1)

    def at(self, times: np.ndarray) -> Values:
        """Values at some times, by a cubic spline unless all are times of this curve; a single number is constant."""
        if not self.values.ndim:
            return self.values
        # no spline is needed at the times of a run with twice the step; with many components, it would take longer
        # than the run
        return self.values[self._places(times)] if self.holds(times) else self._spline(times)

    def within(self, other: Curve) -> Curve:
        """Points of this curve at times that another curve covers."""
        if not self.values.ndim:
            return self
        shared = (self.t >= other.t[0] - self._slack) & (self.t <= other.t[-1] + self._slack)
        return Curve(self.t[shared], self.values[shared], self.quantity)

    def difference(self, finer: Curve) -> Values:
        """Values of this curve minus values of a finer one, at the times of this curve that the finer one covers."""
        shared = self.within(finer)
        return shared.values - finer.at(shared.t)

    def distance(self, finer: Curve, scale: np.ndarray) -> float:
        """Largest absolute value of the ``difference`` from a finer curve, relative to a scale, (components,)."""
        largest = np.abs(self.difference(finer)).reshape(-1, len(scale)).max(axis=0, initial=0.0)
        return float(np.divide(largest, scale, out=np.full(largest.shape, np.inf), where=scale > 0).max())

    def between(self) -> float:
        """Estimated relative error of interpolation between the times: half of the error with every second time.

        It is infinite for a curve of fewer than ``FEWEST`` times, and zero for a single number.
        """
        if not self.values.ndim:
            return 0.0
        every_second = Curve(self.t[::2], self.values[::2])
        return self.distance(every_second, self.scale) / 2 if len(self.t) >= FEWEST else np.inf


def curves(run: Run, quantities: Mapping[str, Quantity] | None = None) -> dict[str, Curve]:
    """The quantities of a run as curves, by name; ``quantities`` has those of a problem."""
    known = quantities or {}
    return {
        name: Curve(run.t if values.ndim else np.empty(0), values, known.get(name))
        for name, values in run.values.items()
    }
