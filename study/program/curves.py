"""Quantities of a program's runs, and their differences between runs at different steps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

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
    """A quantity along its times, of shape (t, ...), or a single number, of shape (), without times."""

    t: Times
    values: Values

    @property
    def size(self) -> float:
        """The largest absolute value."""
        return float(np.abs(self.values).max())

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
        return Curve(self.t[shared], self.values[shared])

    def difference(self, finer: Curve) -> Values:
        """Values of this curve minus values of a finer one, at the times of this curve that the finer one covers."""
        shared = self.within(finer)
        return shared.values - finer.at(shared.t)

    def distance(self, finer: Curve) -> float:
        """Largest absolute value of the ``difference`` from a finer curve."""
        return float(np.abs(self.difference(finer)).max(initial=0.0))

    def between(self) -> float:
        """Estimated error of interpolation between the times: half of the error if only every second time is used.

        It is infinite for a curve of fewer than ``FEWEST`` times, and zero for a single number.
        """
        if not self.values.ndim:
            return 0.0
        return self.distance(Curve(self.t[::2], self.values[::2])) / 2 if len(self.t) >= FEWEST else np.inf


def curves(run: Run) -> dict[str, Curve]:
    """The quantities of a run as curves, by name."""
    return {name: Curve(run.t if one.ndim else np.empty(0), one) for name, one in run.values.items()}
