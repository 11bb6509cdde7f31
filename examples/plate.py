"""A cantilever plate of plane elements that hits ten stops, with sparse matrices.

    python examples/plate.py

The elements have four nodes and bilinear displacements. Their stiffness is assembled once. Newton's iterations
differentiate only the force of the stops, which grows with the cube of the displacement.
"""

import jax.numpy as jnp
import numpy as np
from scipy import sparse

import study

#: Young's modulus in Pa, Poisson's ratio, density in kg/m³, thickness and length of an element's side in m.
YOUNG, POISSON, DENSITY, THICKNESS, SIDE = 2.1e11, 0.3, 7850.0, 0.01, 0.1

#: Force of a stop at a displacement of one metre, in N, and number of stops.
STOP, STOPS = 1e15, 10


def element():
    """Stiffness (8, 8) of a square element under plane stress, by two times two Gauss points."""
    elasticity = YOUNG / (1 - POISSON**2) * np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, (1 - POISSON) / 2]])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    stiffness = np.zeros((8, 8))
    for x, y in corners / np.sqrt(3):
        slopes = corners * (1 + corners[:, ::-1] * [y, x]) / (2 * SIDE)  # ∂/∂x and ∂/∂y of the shape functions
        strains = np.zeros((3, 8))
        strains[0, 0::2], strains[1, 1::2] = slopes.T
        strains[2, 0::2], strains[2, 1::2] = slopes.T[::-1]
        stiffness += strains.T @ elasticity @ strains * THICKNESS * SIDE**2 / 4
    return (stiffness + stiffness.T) / 2


def cantilever(length, height, title="cantilever plate"):
    """A plate of ``length`` by ``height`` elements, clamped at its left end; its right end starts upwards at 1 m/s."""
    nodes = np.arange((length + 1) * (height + 1)).reshape(length + 1, height + 1)
    corners = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]], axis=-1).reshape(-1, 4)
    unknowns = np.stack([2 * corners, 2 * corners + 1], axis=-1).reshape(-1, 8)
    places = np.repeat(unknowns, 8, axis=1).ravel(), np.tile(unknowns, 8).ravel()
    whole = sparse.csc_array((np.tile(element().ravel(), len(corners)), places), shape=(2 * nodes.size,) * 2)
    mass = np.bincount(np.repeat(corners.ravel(), 2), minlength=nodes.size) / 2 * DENSITY * THICKNESS * SIDE**2 / 4

    free = np.arange(2 * (height + 1), 2 * nodes.size)
    v0 = np.zeros(2 * nodes.size)
    v0[2 * nodes[-1] + 1] = 1.0
    stops = 2 * np.linspace(0, free.size // 2 - 1, STOPS + 1).astype(int)[1:] + 1

    return study.Problem(
        lambda u: jnp.zeros_like(u).at[stops].set(STOP * u[stops] ** 3),
        u0=np.zeros(free.size),
        v0=v0[free],
        potential=lambda u: STOP / 4 * jnp.sum(u[stops] ** 4),
        stiffness=whole[free][:, free],
        mass=np.repeat(mass, 2)[free],
        title=title,
    )


plate = cantilever(100, 9)

if __name__ == "__main__":
    ds = study.run(plate, "average_acceleration", dt=5e-5, steps=400, observe=["max_energy_error", "newton_iterations"])
    print(ds)
