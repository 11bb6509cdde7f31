"""Linear theory out of the code itself: the amplification matrix is the derivative of a scheme's step."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jax.flatten_util import ravel_pytree

from study.command import main, progress
from study.experiments import labels
from study.problem import Problem
from study.schemes import Scheme
from study.schemes import schemes as registry


def amplification_matrix(scheme: Scheme, dt_over_period, damping_ratio: float) -> jax.Array:
    """Derivative of one step on ü + 2ξ u̇ + u = 0 (ω = 1, T = 2π) with respect to the scheme's whole state."""
    oscillator = Problem(force=lambda u: u, u0=1.0, damping=2 * damping_ratio if damping_ratio else None)
    dt = 2 * jnp.pi * dt_over_period
    state, _ = scheme.start(oscillator, jnp.ones(()), jnp.zeros(()), dt)
    flat, unflatten = ravel_pytree(state)

    def step(flat):
        return ravel_pytree(scheme.step(oscillator, unflatten(flat), 0.0, dt)[0])[0]

    return jax.jacfwd(step)(flat)


def spectral(schemes: Sequence[str], exponents: dict[str, float], damping_ratios: Sequence[float]) -> xr.Dataset:
    """Spectral radius ρ = max |λ| of the amplification matrix of every scheme.

    Parameters
    ----------
    exponents
        ``first`` and ``last`` power of ten of Δt/T, and ``per_decade`` points in between.
    """
    progress("amplification matrices")
    decades = exponents["last"] - exponents["first"]
    dt_over_period = np.logspace(exponents["first"], exponents["last"], round(decades * exponents["per_decade"]) + 1)
    radius = np.empty((len(schemes), len(dt_over_period), len(damping_ratios)))
    for s, name in enumerate(schemes):
        for d, damping_ratio in enumerate(damping_ratios):
            matrices = jax.vmap(lambda r, s=registry[name], d=damping_ratio: amplification_matrix(s, r, d))(
                jnp.asarray(dt_over_period)
            )
            radius[s, :, d] = np.abs(np.linalg.eigvals(np.asarray(matrices))).max(axis=-1)
    return xr.Dataset(
        {
            "spectral_radius": (
                ("scheme", "dt_over_period", "damping_ratio"),
                radius,
                {"long_name": "spectral radius of the amplification matrix", "units": "1"},
            )
        },
        coords={
            **labels.scheme_coordinates(schemes),
            "dt_over_period": ("dt_over_period", dt_over_period, {"long_name": "step size over period", "units": "1"}),
            "damping_ratio": (
                "damping_ratio",
                list(damping_ratios),
                {"long_name": "damping ratio of the oscillator", "units": "1"},
            ),
        },
        attrs={"title": "Spectral radius of the schemes on the linear oscillator"},
    )


if __name__ == "__main__":
    main(spectral)
