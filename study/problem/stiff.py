"""Systems of two unknowns with a stiff mode."""

import jax.numpy as jnp
import numpy as np

from study.mechanics.definition import Problem
from study.mechanics.loads import HarmonicLoad
from study.mechanics.terms import StrainEnergy
from study.problem.naming import named

#: Period of the motion of the support.
SUPPORT_PERIOD = 2 * np.pi / 1.2


@named(time_scale=SUPPORT_PERIOD, time_scale_name="period of the support")
def stiff_soft(soft_energy=lambda stretch: stretch * stretch / 2, title: str = "stiff and soft springs") -> Problem:
    r"""The problem of Bathe and Noh with three degrees of freedom: two masses in a row on a moving support.

    A stiff spring connects the support and the first mass, and a soft spring connects the two masses.

    .. math::

        \ddot u_2 + k_1 (u_2 - u_1) - k_2 (u_3 - u_2) &= 0 \\
        \ddot u_3 + k_2 (u_3 - u_2) &= 0, \quad u_1 = \sin(1.2 t)

    with u = (u₂, u₃) from rest, k₁ = 10⁷ and k₂ = 1. The motion u₁ of the support enters as the load k₁ u₁. The first
    mass follows the support. Its own mode on the stiff spring, of period 0.002, represents the rigid links of a
    structure.

    References
    ----------
    K. J. Bathe, G. Noh, Insight into an implicit time integration scheme for structural dynamics, Comput. Struct.
    98-99, 2012, 1-6.
    """
    stiffness = 1e7
    energy = StrainEnergy(
        strains=lambda u: jnp.stack([u[0], u[1] - u[0]]),
        density=lambda e: jnp.stack([stiffness * e[0] ** 2 / 2, soft_energy(e[1])]),
    )
    load = HarmonicLoad(np.array([stiffness, 0.0]), frequency=1.2, phase=np.pi / 2)
    return Problem(potential=energy, u0=np.zeros(2), v0=np.zeros(2), load=load, title=title)


@named(time_scale=SUPPORT_PERIOD, time_scale_name="period of the support")
def stiff_soft_sine() -> Problem:
    """The system of ``stiff_soft`` with the soft spring k₂ sin δ, δ = u₃ − u₂."""
    return stiff_soft(lambda stretch: 1 - jnp.cos(stretch), title="stiff and sine springs")


@named(time_scale=2 * np.pi * 3.0443 / 7.72, time_scale_name="turn")
def elastic_pendulum() -> Problem:
    r"""A mass that circles about a fixed point on a stiff elastic bar.

    .. math::

        V = \frac{EA}{8 L^3} (x^2 + y^2 - L^2)^2

    The motion u = (x, y) starts from (L, 0) with the velocity (0, v₀). With L = 3.0443, m = 10, EA = 10¹⁰ and v₀ = 7.72
    the period of a turn is 2.48, and the period of the axial mode of the bar is 3.5e-4.

    References
    ----------
    D. Kuhl, M. A. Crisfield, Energy-conserving and decaying algorithms in non-linear structural dynamics, Int. J.
    Numer. Methods Eng. 45(5), 1999, 569-599.
    """
    length, mass, rigidity = 3.0443, 10.0, 1e10
    energy = StrainEnergy(
        strains=lambda u: (jnp.vdot(u, u) - length**2)[None],
        density=lambda e: rigidity / (8 * length**3) * e**2,
    )
    return Problem(
        potential=energy,
        u0=[length, 0.0],
        v0=[0.0, 7.72],
        mass=mass,
        positions=np.zeros((1, 2)),
        title="elastic pendulum",
    )
