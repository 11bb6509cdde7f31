"""A shallow truss of two bars under a sudden load, close to snapping through.

    study assess examples/truss.py:truss --duration 2 --output truss

The bars meet at a mass and have Green's strain. u holds the displacements of the mass, sideways and down.
"""

import jax.numpy as jnp
import numpy as np

import study

#: Half the span and the rise in m, axial stiffness in N, mass in kg and load in N.
SPAN, RISE, STIFFNESS, MASS, LOAD = 1.0, 0.2, 1e6, 10.0, 800.0

#: Vectors from each support to the mass.
BARS = np.array([[SPAN, -RISE], [-SPAN, -RISE]])


def energy(u):
    """Strain energy of both bars in J."""
    length = np.hypot(SPAN, RISE)
    strains = ((BARS + u[None]) ** 2).sum(axis=1) / (2 * length**2) - 0.5
    return jnp.sum(STIFFNESS * length / 2 * strains**2)


truss = study.Problem(
    potential=energy,
    u0=[0.001, 0.0],  # a start off the axis of symmetry, so that the mass also moves sideways
    mass=MASS,
    damping=10.0,
    load=lambda t: jnp.array([0.0, LOAD]),
    title="shallow truss",
)

if __name__ == "__main__":
    ds = study.assess(truss, duration=2.0)
    print(study.recommend(ds, allowed_error=0.01, quantity="displacement"))
    print(*ds.failure.values, sep="\n")
