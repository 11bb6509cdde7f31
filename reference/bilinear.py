r"""Exact motions of many oscillators on bilinear springs under records, from event to event.

An event is a yield point, a turning point of the motion or a sample of the record. Between two events the motion obeys

.. math::

    \ddot u + c \dot u + k u = q_0 + q_1 \tau

with the stiffness k of the piece. The solution has a closed form, so that all oscillators advance at once, each from
its own event to the next. :mod:`reference.piecewise` solves for one oscillator of any damping by matrix exponentials.
"""

import numpy as np
from jaxtyping import Float

from reference.solution import RouteFailed

#: Array with one number for each oscillator.
Lanes = Float[np.ndarray, "lanes"]

#: Array with one row of samples for each oscillator.
Rows = Float[np.ndarray, "lanes samples"]

#: Tolerance of the time of an event: its last correction, relative to the interval in which the event is sought.
CONVERGED = 1e-9

#: Number of corrections of the time of an event by Newton's iteration, and after them by bisection. Bisection ends also
#: where the round-off of a small velocity is larger than the tolerance.
NEWTON, BISECTIONS = 30, 31


def motion_after(
    tau: Lanes, u: Lanes, v: Lanes, c: Lanes, k: Lanes, q0: Lanes, q1: Lanes
) -> tuple[Lanes, Lanes, Lanes]:
    """Displacement, velocity and acceleration of underdamped oscillators after a time τ under the load q₀ + q₁ τ."""
    rate, frequency = q1 / k, np.sqrt(k - c**2 / 4)
    steady = (q0 - c * rate) / k
    cosine, sine = u - steady, (v - rate + c * (u - steady) / 2) / frequency
    decay, cos, sin = np.exp(-c * tau / 2), np.cos(frequency * tau), np.sin(frequency * tau)
    free, turned = decay * (cosine * cos + sine * sin), decay * (sine * cos - cosine * sin)
    u, v = steady + rate * tau + free, rate - c * free / 2 + frequency * turned
    return u, v, q0 + q1 * tau - c * v - k * u


def time_of(level: Lanes | float, derivative: int, end: Lanes, start: np.ndarray) -> Lanes:
    """Time up to ``end`` at which displacement (``derivative`` 0) or velocity (1) passes a level.

    The time is found by Newton's iteration. A correction that leaves the bracket is replaced by a bisection, as are all
    corrections after the first ``NEWTON``.
    """
    low, high, tau = np.zeros_like(end), end, end / 2
    rises = motion_after(end, *start)[derivative] > level
    for correction in range(NEWTON + BISECTIONS):
        value, slope = motion_after(tau, *start)[derivative : derivative + 2]
        before = (value > level) != rises
        low, high = np.where(before, tau, low), np.where(before, high, tau)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = tau - (value - level) / slope
        within = (correction < NEWTON) & (low <= newton) & (newton <= high)
        tau, last = np.where(within, newton, (low + high) / 2), tau
        if np.all(np.abs(tau - last) <= CONVERGED * end):
            return tau
    raise RouteFailed("the time of an event was not found.")


def motions(
    acceleration: Rows,
    dt: Lanes | float,
    stiffness: Lanes,
    damping: Lanes,
    yield_force: Lanes,
    hardening: float,
    places: np.ndarray | int,
) -> tuple[Lanes, Rows]:
    """Largest absolute displacement of unit masses that start at rest, and the displacement at every sample.

    Both are exact up to round-off.

    Parameters
    ----------
    acceleration, dt
        Acceleration of the ground of each oscillator, linear between its samples, and the time between two samples. NaN
        follows the last sample of a record that is shorter than the longest.
    stiffness, damping, yield_force, hardening
        Stiffness k, damping c, force at yield, and the ratio of the stiffness after yield to k. The oscillator must
        stay underdamped after yield.
    places
        Number of equal parts of every interval between two samples. An event in a part is detected from the
        motion at the end of the part. Two turning points within one part are missed, so the difference of the peaks
        with two values of ``places`` estimates the uncertainty of the peaks.
    """
    dt, places = (np.broadcast_to(values, stiffness.shape) for values in (dt, places))
    bound, slope, part = yield_force / stiffness, np.diff(acceleration) / dt[:, None], dt / places
    parts = places * np.isfinite(slope).sum(axis=1)
    # ``side``: direction of yield, zero while elastic; ``passed``: time since the start of the current part
    u, v, plastic, side, passed, peak = np.zeros((6, len(acceleration)))
    place, at_samples = np.zeros(len(acceleration), int), np.zeros(acceleration.shape)
    while (lanes := np.flatnonzero(place < parts)).size:
        sample, number = np.divmod(place[lanes], places[lanes])
        yields = side[lanes] != 0
        k = np.where(yields, hardening, 1.0) * stiffness[lanes]
        rest = np.where(yields, side[lanes] * bound[lanes], -plastic[lanes])
        q1 = -slope[lanes, sample]
        elapsed = number * part[lanes] + passed[lanes]
        q0 = -acceleration[lanes, sample] + q1 * elapsed - (1 - hardening) * stiffness[lanes] * rest
        start = np.array([u[lanes], v[lanes], damping[lanes], k, q0, q1])
        remaining = part[lanes] - passed[lanes]
        tau = remaining.copy()
        u_end, v_end, _ = motion_after(remaining, *start)
        turns = v[lanes] * v_end < 0
        tau[turns] = time_of(0.0, 1, remaining[turns], start[:, turns])
        u_end[turns], v_end[turns] = motion_after(tau[turns], *start[:, turns])[0], 0.0
        # up to ``tau`` the motion has one direction, so it leaves the elastic range at most once
        direction = np.sign(u_end - u[lanes])
        limit = plastic[lanes] + direction * bound[lanes]
        leaves = ~yields & (direction * (u_end - limit) > 0)
        tau[leaves] = time_of(limit[leaves], 0, tau[leaves], start[:, leaves])
        u_end[leaves], v_end[leaves] = limit[leaves], motion_after(tau[leaves], *start[:, leaves])[1]
        u[lanes], v[lanes], peak[lanes] = u_end, v_end, np.maximum(peak[lanes], np.abs(u_end))
        unloads = lanes[turns & yields]
        plastic[unloads] = u[unloads] - side[unloads] * bound[unloads]
        side[unloads], side[lanes[leaves]] = 0.0, direction[leaves]
        ends = tau == remaining
        place[lanes] += ends
        passed[lanes] = np.where(ends, 0.0, passed[lanes] + tau)
        reached = ends & (number == places[lanes] - 1)
        at_samples[lanes[reached], sample[reached] + 1] = u[lanes[reached]]
    return peak, at_samples
