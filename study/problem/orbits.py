"""Motions with two unknowns and a conserved energy: Arenstorf's orbit, and Hénon and Heiles' star in a galaxy."""

import math

import jax.numpy as jnp
import numpy as np

from study.mechanics.definition import Problem
from study.problem.naming import Known, named

#: Mass of the moon relative to the mass of earth and moon together, and period of the orbit, as printed.
MOON, PERIOD = 0.012277471, 17.0652165601579626
_START = np.array([0.994, 0.0])


@named(time_scale=PERIOD, known=Known(PERIOD, "Hairer et al. (1993), II.0", u=_START))
def arenstorf() -> Problem:
    r"""Arenstorf's orbit: a massless body that moves periodically around earth and moon, in their rotating frame.

    .. math::

        \ddot x - 2\dot y &= -\partial V/\partial x, \quad \ddot y + 2\dot x = -\partial V/\partial y \\
        V &= -\frac{x^2 + y^2}{2} - \frac{1 - \mu}{\sqrt{(x + \mu)^2 + y^2}}
            - \frac{\mu}{\sqrt{(x - 1 + \mu)^2 + y^2}}

    u = (x, y), μ = 0.012277471. The unit of length is the distance from earth to moon, and a month is 2π. The Coriolis
    force is a skew damping matrix, which does no work: u̇ᵀu̇/2 + V is Jacobi's constant. From (0.994, 0) with the
    velocity (0, −2.00158510637908252240537862224) the orbit closes after 17.0652165601579625588917206249. It passes the
    moon at a distance of 0.006, where the acceleration is hundreds of times as large as on most of the orbit.

    References
    ----------
    E. Hairer, S. P. Nørsett, G. Wanner, Solving ordinary differential equations I, 2nd ed., Springer, 1993, section
    II.0.
    """

    def potential(u):
        earth, moon = (jnp.sqrt((u[0] - x) ** 2 + u[1] ** 2) for x in (-MOON, 1 - MOON))
        return -(u[0] ** 2 + u[1] ** 2) / 2 - (1 - MOON) / earth - MOON / moon

    return Problem(
        potential=potential,
        u0=_START,
        v0=[0.0, -2.00158510637908252],
        damping=np.array([[0.0, -2.0], [2.0, 0.0]]),
        title="Arenstorf's orbit",
    )


#: Unit vector of the straight motion of :func:`henon_heiles`, and the coordinates r at which this motion turns.
_LINE, _ENDS = -np.array([np.sqrt(3), 1.0]) / 2, (0.5, (1 - np.sqrt(3)) / 2)
#: Period of the straight motion, 4 √1.5 K / 3^¼. The complete elliptic integral K of the parameter 1/2 is Γ(¼)²/(4 √π).
STRAIGHT_PERIOD = np.sqrt(1.5) / 3**0.25 * math.gamma(0.25) ** 2 / math.sqrt(math.pi)


@named(
    time_scale=2 * np.pi,
    known=Known(10.5 * STRAIGHT_PERIOD, "elliptic integral", u=_ENDS[1] * _LINE),
)
def henon_heiles() -> Problem:
    r"""The star of Hénon and Heiles on a straight line of symmetry.

    .. math::

        V = \tfrac12 (x^2 + y^2) + x^2 y - \tfrac13 y^3

    u = (x, y). Below the energy 1/6 the motion stays in a triangle. The coordinate r along the line through the origin
    at an angle of 210° obeys r̈ = −r + r². From r = 1/2 at rest, with the energy 1/12, r moves between 1/2 and
    (1 − √3)/2 with the period :math:`4\sqrt{3/2}\,3^{-1/4} K = 6.9016`, where K is the complete elliptic integral of
    the first kind of the parameter 1/2.

    References
    ----------
    M. Hénon, C. Heiles, The applicability of the third integral of motion: some numerical experiments, Astron. J.
    69(1), 1964, 73-79.
    """
    return Problem(
        potential=lambda u: (u[0] ** 2 + u[1] ** 2) / 2 + u[0] ** 2 * u[1] - u[1] ** 3 / 3,
        u0=_ENDS[0] * _LINE,
        v0=np.zeros(2),
        title="Hénon-Heiles",
    )
