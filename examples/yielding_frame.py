r"""A frame of three storeys that yield, with fluid dampers, under the record of El Centro.

study assess examples/yielding_frame.py:frame --quantities examples/yielding_frame.py:quantities --duration 12 \
        --allowed-error 0.01 --output yielding_frame
"""

import jax.numpy as jnp
import numpy as np

import study
from study import materials


def drifts(u):
    """Drift of each storey."""
    return u - jnp.pad(u[:-1], (1, 0))


# units: stiffness in N/m, yield force in N, coefficient of the dampers in N √(s/m), mass in kg
storeys = materials.elements(
    materials.elastoplastic(
        stiffness=np.array([4.0e7, 3.5e7, 3.0e7]), yield_force=np.array([4.0e5, 3.0e5, 2.0e5]), hardening=0.05
    ),
    drifts,
    3,
)
dampers = materials.elements(materials.viscous_damper(coefficient=5.0e4, exponent=0.5), drifts, 3)


def force(u, v, history):
    """Sum of the forces of storeys and dampers, and the updated history of the storeys."""
    storey_forces, history = storeys(u, v, history)
    return storey_forces + dampers(u, v), history


frame = study.Problem(
    force,
    u0=np.zeros(3),
    history=storeys.history,
    mass=np.array([1.0e5, 1.0e5, 0.8e5]),
    ground=study.GroundMotion.el_centro(),
    title="yielding frame",
)
quantities = {
    "peak drift": study.Quantity(drifts, reduce="peak"),
    "residual drift": study.Quantity(drifts, reduce="final"),
}

if __name__ == "__main__":
    drift = study.Quantity(drifts, name="drift", reduce="peak")
    ds = study.run(frame, "average_acceleration", dt=0.005, steps=2400, observe=[drift, "energy_balance"])
    print("largest drift of each storey in mm:", (1e3 * ds.drift.values).round(1))
    print(f"dissipated: {ds.dissipated_energy.item() / 1e3:.0f} of {ds.work_of_load.item() / 1e3:.0f} kJ")
