"""A solution between the points of its grid."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from study.algebra.elementwise import quintic, value

#: Places 0 < s < 1 in an interval at which the interpolant is compared with another solution. The error of the
#: interpolant in u is about proportional to s³(1 − s)³, and its error in u̇ to the derivative of this function. The
#: derivative is zero at s = 1/2, so a single place could miss an error.
BETWEEN = (0.25, 0.6)

#: Largest number of parts into which an interval is divided at once.
MOST_PARTS = 16

#: Largest number of points of a solution.
MOST_POINTS = 200_000

#: Times in seconds.
Times = Float[np.ndarray, "t"]

#: Displacements or velocities along time.
History = Float[np.ndarray, "t *n"]


class DenseSolution(NamedTuple):
    """Displacement and velocity on a grid, interpolated between its points by the quintic through u, u̇ and ü.

    Attributes
    ----------
    t
        Times, including all kinks of load and force.
    u, v, a
        Displacement, velocity and acceleration, of shape (t, ...).
    """

    t: Times
    u: History
    v: History
    a: History

    def at(self, times: Times) -> tuple[History, History]:
        """Displacement and velocity at the given times."""
        i = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 2)
        h = self.t[i + 1] - self.t[i]
        s = np.clip((times - self.t[i]) / h, 0.0, 1.0)
        h, s = (x.reshape(-1, *(1,) * (self.u.ndim - 1)) for x in (h, s))
        ends = (self.u[i], self.v[i], self.a[i]), (self.u[i + 1], self.v[i + 1], self.a[i + 1])
        return value(quintic(*ends, h), s), value(quintic(*ends, h, derivative=True), s) / h

    def until(self, end: float) -> "DenseSolution":
        """The solution up to a time of its grid."""
        count = int(np.searchsorted(self.t, end, side="right"))
        return DenseSolution(*(part[:count] for part in self))

    def refined(self, other: "DenseSolution", goal: float) -> Times:
        """The grid, refined where the error of the interpolant exceeds a goal, relative to the largest value.

        The grid is returned unchanged if the refined one would have more than ``MOST_POINTS`` intervals, or if the two
        solutions are not finite.

        Parameters
        ----------
        other
            A solution at the points of this grid and at points in between.
        """
        errors = np.zeros(len(self.t) - 1)
        for values, other_values in zip(self.at(other.t), (other.u, other.v), strict=True):
            differences = np.abs(values - other_values).reshape(len(other.t), -1).max(axis=1) / (
                np.abs(other_values).max() or 1.0
            )
            points, between = np.split(differences[:-1].reshape(len(errors), -1), [1], axis=1)
            # the difference of the two solutions at the points of this grid is not an error of the interpolant
            end_differences = np.maximum(points[:, 0], np.append(points[1:, 0], differences[-1]))
            np.maximum(errors, between.max(axis=1) - end_differences, out=errors)
        if not np.isfinite(errors).all():  # an unbounded motion, which the caller reports
            return self.t
        # the interpolant of u̇ is of fifth order
        parts = np.ceil(np.clip(errors / goal, 1.0, None) ** 0.2).astype(int)
        parts = np.minimum(parts, MOST_PARTS)
        if parts.sum() > MOST_POINTS:
            return self.t
        places = np.repeat(np.arange(len(parts)), parts)
        inside = np.arange(len(places)) - np.repeat(np.cumsum(parts) - parts, parts)
        return np.append(self.t[places] + inside * (np.diff(self.t) / parts)[places], self.t[-1])


def with_points_between(grid: Times) -> Times:
    """The grid with points added in each of its intervals, at places where the interpolant has large errors."""
    return np.append((grid[:-1, None] + np.diff(grid)[:, None] * (0.0, *BETWEEN)).ravel(), grid[-1])
