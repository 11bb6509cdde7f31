"""Rigid links in a row, whose inertia depends on their angles."""

from pathlib import Path

import jax.numpy as jnp
import numpy as np

from study.algebra.elimination import solve
from study.algebra.matrices import Banded, shifted, times
from study.io import read
from study.mechanics.definition import Problem
from study.problem.naming import Known, named

#: Angles of the double pendulum at t = 10.
_TEN = Known(10.0, "Taylor series of 30 digits", u=np.array([1.679122797382449963, 0.993117806437825879]))


@named(time_scale=2 * np.pi, known=_TEN)
def double_pendulum() -> Problem:
    r"""The plane double pendulum of two unit masses on massless rods of unit length, under unit gravity.

    .. math::

        \begin{bmatrix} 2 & c \\ c & 1 \end{bmatrix} \ddot\theta
            + s \begin{bmatrix} \dot\theta_2^2 \\ -\dot\theta_1^2 \end{bmatrix}
            + \begin{bmatrix} 2\sin\theta_1 \\ \sin\theta_2 \end{bmatrix} = 0, \quad
        c = \cos(\theta_1 - \theta_2), \quad s = \sin(\theta_1 - \theta_2)

    The angles u = (θ₁, θ₂) are those of the rods to the vertical. Both start at π/2, at rest. The equation is solved
    for the acceleration, so that the force depends on the velocity and has no potential.

    References
    ----------
    T. Shinbrot, C. Grebogi, J. Wisdom, J. A. Yorke, Chaos in a double pendulum, Am. J. Phys. 60(6), 1992, 491-499.
    """

    def force(u, v):
        difference = u[0] - u[1]
        c, s = jnp.cos(difference), jnp.sin(difference)
        first = s * v[1] ** 2 + 2 * jnp.sin(u[0])
        second = -s * v[0] ** 2 + jnp.sin(u[1])
        return jnp.stack([first - c * second, 2 * second - c * first]) / (2 - c * c)

    return Problem(force, u0=[np.pi / 2, np.pi / 2], title="double pendulum")


#: Number of angles of the elastic beam.
ANGLES = 40


def _printed_angles() -> np.ndarray:
    return read(Path(__file__).with_name("elastic_beam.csv")).angle.to_numpy(float)


@named(time_scale=np.pi, known=Known(5.0, "Mazzia and Magherini (2008), Beam", _printed_angles(), np.eye(40, 41)))
def elastic_beam() -> Problem:
    r"""An elastic beam as 40 rigid links, held at one end and pulled at the other: BEAM of the Bari test set.

    .. math::

        \ddot\theta &= C g + D w, \quad C w = D g + \dot\theta^2 \\
        g_k &= n^4 (\theta_{k-1} - 2\theta_k + \theta_{k+1}) + n^2 (F_y \cos\theta_k - F_x \sin\theta_k)

    with n = 40, θ₀ = −θ₁ and θ₄₁ = θ₄₀. The tridiagonal C has the diagonal (1, 2, ..., 2, 3) and the entries
    −cos(θ_k − θ_{k−1}) at (k, k − 1) and (k − 1, k). D has a zero diagonal, −sin(θ_k − θ_{k−1}) at (k, k − 1) and
    +sin(θ_k − θ_{k−1}) at (k − 1, k). The force at the end is F_y = −F_x = 1.5 sin²t up to t = π and zero after. The
    links start in a row at rest. The highest circular frequency of their small motions is 6400. The force depends on
    the angles, their velocities and time. Time is therefore the last unknown, with zero acceleration and unit velocity.

    References
    ----------
    E. Hairer, G. Wanner, Solving ordinary differential equations II, 2nd ed., Springer, 1996, section IV.10.
    F. Mazzia, C. Magherini, Test set for initial value problem solvers, Release 2.4, Department of Mathematics,
    University of Bari, 2008.
    """
    n = ANGLES
    diagonal = jnp.full(n, 2.0).at[0].set(1.0).at[-1].set(3.0)

    def force(u, v):
        angle, t = u[:n], u[n]
        turn = jnp.diff(angle)
        cos, sin = (jnp.append(0.0, function(turn)) for function in (jnp.cos, jnp.sin))
        c = Banded((-cos, diagonal, -shifted(cos, 1)))
        d = Banded((-sin, jnp.zeros(n), shifted(sin, 1)))
        bent = jnp.concatenate([-angle[:1], angle, angle[-1:]])
        pull = jnp.where(t < jnp.pi, 1.5 * jnp.sin(t) ** 2, 0.0)
        g = n**4 * jnp.diff(bent, 2) + n**2 * pull * (jnp.cos(angle) + jnp.sin(angle))
        w = solve(c, times(d, g) + v[:n] ** 2)
        return jnp.append(-(times(c, g) + times(d, w)), 0.0)

    return Problem(force, u0=np.zeros(n + 1), v0=np.append(np.zeros(n), 1.0), tangent="dense", title="elastic beam")
