"""Quantities of runs at different steps, compared."""

from typing import NamedTuple

import numpy as np

from study.program.attempt import Run, Times, Values

#: How values between the steps are had.
INTERPOLATION = "cubic splines through the steps of the finer run"

#: Fewest points of a curve, of which every second one says how far its interpolation is to be trusted.
FEWEST = 8


class Curve(NamedTuple):
    """A quantity along its times, of shape (t, ...); or a single number, of shape (), without times."""

    t: Times
    values: Values

    @property
    def size(self) -> float:
        """The largest size."""
        return float(np.abs(self.values).max())

    def at(self, times: np.ndarray) -> Values:
        """Values at some times, by a cubic spline; of a single number, itself."""
        from scipy.interpolate import CubicSpline  # here, because problems without a program do without it

        return CubicSpline(self.t, self.values)(times) if self.values.ndim else self.values

    def within(self, other: "Curve") -> "Curve":
        """The part of it at times that another curve covers."""
        if not self.values.ndim:
            return self
        slack = 1e-6 * (self.t[1] - self.t[0])
        shared = (self.t >= other.t[0] - slack) & (self.t <= other.t[-1] + slack)
        return Curve(self.t[shared], self.values[shared])

    def from_(self, finer: "Curve") -> Values:
        """Difference from a finer curve at the times of this one that the finer one covers."""
        shared = self.within(finer)
        return shared.values - finer.at(shared.t)

    def distance(self, finer: "Curve") -> float:
        """Largest difference from a finer curve."""
        return float(np.abs(self.from_(finer)).max(initial=0.0))

    def between(self) -> float:
        """Error of the values between its steps: half of that between every second one."""
        if len(self.t) < FEWEST:
            return 0.0
        return self.distance(Curve(self.t[::2], self.values[::2])) / 2


def curves(run: Run) -> dict[str, Curve]:
    """The quantities of a run by name."""
    return {name: Curve(run.t if one.ndim else np.empty(0), one) for name, one in run.values.items()}
