"""A driven Duffing oscillator, assessed by its amplitude, its acceleration and its last state.

    study assess examples/driven.py:driven --quantities examples/driven.py:quantities --duration 100 --output driven

The oscillator ü + 0.1 u̇ + u + u³ = 0.5 cos 1.2 t starts from rest at u = 0.
"""

import jax.numpy as jnp

import study

driven = study.Problem(
    force=lambda u: u + u**3,
    potential=lambda u: u**2 / 2 + u**4 / 4,
    u0=0.0,
    damping=0.1,
    load=lambda t: 0.5 * jnp.cos(1.2 * t),
    title="driven Duffing oscillator",
)

quantities = {
    "amplitude": study.Quantity(lambda u: u, reduce="peak"),
    "acceleration": study.Quantity(lambda a: a, reduce="rms", units="s-2"),
    "last state": study.Quantity(lambda u, v: jnp.stack([u, v]), reduce="final"),
}

if __name__ == "__main__":
    ds = study.assess(driven, duration=100.0, quantities=quantities)
    print(study.recommend(ds, allowed_error=0.01, quantity="acceleration"))
