"""Plane trusses."""

import jax.numpy as jnp
import numpy as np

from study.mechanics.definition import Problem
from study.mechanics.terms import Rayleigh, StrainEnergy
from study.problem.naming import named


def _mesh(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Joints of a mesh of unit cells, numbered along its short side.

    Returns the coordinates of the joints (joints, 2), and the numbers of both joints of each bar (bars, 2).
    """
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    pairs = [
        (number[:-1], number[1:]),
        (number[:, :-1], number[:, 1:]),
        (number[:-1, :-1], number[1:, 1:]),
        (number[:-1, 1:], number[1:, :-1]),
    ]
    return np.stack([x.ravel(), y.ravel()], 1), np.concatenate([np.stack([a.ravel(), b.ravel()], 1) for a, b in pairs])


def _bars(joints: np.ndarray, bars: np.ndarray, rigidity: float, free: np.ndarray) -> StrainEnergy:
    """Energy EA L/2 ε² of every bar, with Green's strain ε = (l² − L²)/(2L²), for displacements of the free joints."""
    first, second = bars.T
    edges = joints[second] - joints[first]
    squared = (edges**2).sum(axis=1)

    def strains(u):
        displacement = jnp.zeros(joints.shape).at[free].set(u.reshape(-1, 2))
        change = displacement[second] - displacement[first]
        # l² − L², without a difference of large numbers
        return jnp.sum(change * (2 * edges + change), axis=1) / (2 * squared)

    return StrainEnergy(strains, lambda e: rigidity * np.sqrt(squared) / 2 * e * e)


#: Numbers of cells along and across the trusses.
TRUSS = (24, 5)


@named(time_scale=2 * np.pi)  # one turn
def spinning_truss() -> Problem:
    """A truss of 24 by 5 cells that spins freely in its plane: 150 joints, 509 bars, 300 unknowns.

    Its cells are unit squares with both diagonals. Every joint has unit mass, and every bar EA = 10⁴ and Green's
    strain. The force is assembled from the energies of the bars by automatic differentiation. The truss starts
    undeformed, as a rigid body that turns at one radian per unit time. Its motion conserves energy, linear momentum and
    angular momentum.

    References
    ----------
    J. C. Simo, N. Tarnow, K. K. Wong, Exact energy-momentum conserving algorithms and symplectic schemes for nonlinear
    dynamics, Comput. Methods Appl. Mech. Eng. 100(1), 1992, 63-116 (the method and its test by a body that spins).
    """
    joints, bars = _mesh(*TRUSS)
    joints = joints - joints.mean(axis=0)
    velocity = np.stack([-joints[:, 1], joints[:, 0]], 1)
    return Problem(
        potential=_bars(joints, bars, 1e4, np.arange(len(joints))),
        u0=np.zeros(joints.size),
        v0=velocity.ravel(),
        tangent=2 * (TRUSS[1] + 2) + 1,
        positions=joints,
        title="spinning truss",
    )


@named(time_scale=1.0)  # about the period of its first mode
def cantilever_truss() -> Problem:
    """The truss of ``spinning_truss`` as a damped cantilever with a constant transverse load at its free end.

    It has 288 unknowns and Rayleigh damping C = 0.02 M + 0.0005 K. A load of 0.5 acts at every joint of the free end,
    and the motion starts from rest.
    """
    joints, bars = _mesh(*TRUSS)
    free = np.flatnonzero(joints[:, 0] > 0)
    load = np.zeros((len(free), 2))
    load[joints[free, 0] == TRUSS[0], 1] = -0.5
    flat = load.ravel()
    zero = np.zeros(2 * len(free))
    return Problem(
        potential=_bars(joints, bars, 1e4, free),
        u0=zero,
        v0=zero,
        damping=Rayleigh(a=0.02, b=0.0005),
        load=lambda t: jnp.asarray(flat),
        tangent=2 * (TRUSS[1] + 2) + 1,
        title="cantilever truss",
    )
