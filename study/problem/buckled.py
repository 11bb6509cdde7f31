"""A buckled beam under a harmonic load."""

import jax.numpy as jnp
import numpy as np

from study.mechanics.definition import Problem
from study.mechanics.loads import HarmonicLoad
from study.problem.naming import named


@named(time_scale=np.pi)  # period of the load
def buckled_beam() -> Problem:
    r"""A simply supported beam under three times its critical axial load, in three modes, with a load at a quarter.

    .. math::

        \ddot u_i + 0.3\,\dot u_i + i^2 \Big(i^2 - 3 + \sum_j j^2 u_j^2\Big) u_i
        = \frac{\sin(i \pi/4)}{\sin(\pi/4)} \cos 2t, \quad i = 1, 2, 3

    from u₁ = 1 at rest. The deflection is the sum of u_i sin(iπx), and the sum over j stretches the axis. The beam is
    straight at the top of the hill between two wells at u₁ = ±√2, where small motions have the circular frequencies 2,
    3.46 and 8.49. The motion is chaotic, and the second mode takes part in it.

    References
    ----------
    W.-Y. Tseng, J. Dugundji, Nonlinear vibrations of a buckled beam under harmonic excitation, J. Appl. Mech. 38(2),
    1971, 467-476.
    """
    squares = np.arange(1.0, 4.0) ** 2

    def potential(u):
        stretch = jnp.sum(squares * u * u)
        return jnp.sum(squares * (squares - 3) * u * u) / 2 + stretch * stretch / 4

    return Problem(
        potential=potential,
        u0=[1.0, 0.0, 0.0],
        damping=0.3,
        load=HarmonicLoad(np.array([1.0, np.sqrt(2), 1.0]), frequency=2.0, phase=0.0),
        title="buckled beam",
    )
