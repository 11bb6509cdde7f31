"""A pendulum that swings far beyond the linear range: almost eleven periods, from an angle of 150 degrees.

    study assess examples/pendulum.py:pendulum --duration 120 --output pendulum

A free oscillator of one unknown is also judged by its period, its phase and its amplitude.
"""

import jax.numpy as jnp
import numpy as np

import study

pendulum = study.Problem(
    force=jnp.sin,
    potential=lambda angle: 1 - jnp.cos(angle),
    u0=np.radians(150.0),
    title="pendulum from 150 degrees",
)

if __name__ == "__main__":
    ds = study.assess(pendulum, duration=120.0)
    for quantity in ds.quantity.values:
        print(study.recommend(ds, allowed_error=0.01, quantity=quantity).head(3), "\n")
