r"""Exact motions of linear oscillators under records, from sample to sample.

Between two samples of the record the load is linear in time, and the motion has the closed form of
:mod:`reference.bilinear` on one piece.
"""

import numpy as np
from scipy.linalg import expm

from reference.bilinear import Lanes, Rows, motion_after, time_of


def motions(acceleration: Rows, dt: float, stiffness: Lanes, damping: Lanes) -> tuple[Lanes, Rows]:
    """Largest absolute displacement of unit masses that start at rest, and the displacement at every sample.

    Parameters
    ----------
    acceleration, dt
        Acceleration of the ground of each oscillator, linear between its samples, and the time between two samples.
    stiffness, damping
        Stiffness k and damping c, underdamped. Half of the damped period must be longer than ``dt``, because an
        interval with two turning points would hide a peak.
    """
    load, slope = -acceleration[:, :-1], -np.diff(acceleration) / dt
    generators = np.zeros((len(stiffness), 4, 4))
    generators[:, 0, 1] = generators[:, 1, 2] = generators[:, 2, 3] = 1.0
    generators[:, 1, 0], generators[:, 1, 1] = -stiffness, -damping
    step = expm(dt * generators)
    increments = np.einsum("lij,ljt->tli", step[:, :2, 2:], np.stack([load, slope], axis=1))
    state = np.zeros((acceleration.shape[1], len(stiffness), 2))
    for i, increment in enumerate(increments):
        state[i + 1] = np.einsum("lij,lj->li", step[:, :2, :2], state[i]) + increment
    u, v = np.moveaxis(state, 2, 0).transpose(0, 2, 1)
    lane, sample = np.nonzero(v[:, :-1] * v[:, 1:] < 0)
    k, c = stiffness[lane], damping[lane]
    start = np.array([u[lane, sample], v[lane, sample], c, k, load[lane, sample], slope[lane, sample]])
    turning = np.abs(motion_after(time_of(0.0, 1, np.full(len(lane), dt), start), *start)[0])
    peak = np.abs(u).max(axis=1)
    np.maximum.at(peak, lane, turning)
    return peak, u
