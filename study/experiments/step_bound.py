"""Errors of energy and period by the modified energy, and as measured, for motions in twelve potentials."""

from collections.abc import Callable
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study.algebra.jit import short_runs
from study.analysis.modified_equation import modified_equation
from study.analysis.step_bound import largest_omega_step, orbit
from study.declaration.experiment import experiment, progress
from study.declaration.options import Count, Tolerance, section
from study.experiments import coordinates
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.observer.crossings import Oscillations
from study.observer.outcome import OutcomeObserver
from study.scheme.named import schemes

#: Title, potential and initial displacements from rest, by name; the largest displacements are near a separatrix where
#: the potential has one.
POTENTIALS: dict[str, tuple[str, Callable, tuple[float, ...]]] = {
    "cubic": ("cubic hardening", lambda u: u**2 / 2 + u**4 / 4, (0.1, 0.5, 1, 3, 10)),
    "power_5": ("fifth power", lambda u: u**6 / 6, (0.5, 5)),
    "power_11": ("linear and 11th power", lambda u: u**2 / 2 + u**12 / 12, (0.5, 0.8, 1, 1.5, 2)),
    "tanh": ("tanh softening", lambda u: jnp.logaddexp(u, -u) - jnp.log(2.0), (0.5, 1, 3, 10, 100)),
    "pendulum": ("pendulum", lambda u: 2 * jnp.sin(u / 2) ** 2, (0.5, 1.5, 2.5, 2.9671, 3.1067, 3.1241)),
    "cubic_softening": ("cubic softening", lambda u: u**2 / 2 - u**4 / 4, (0.3, 0.5, 0.9, 0.97, 0.99, 0.999)),
    "double_well": ("double well", lambda u: u**4 / 4 - u**2 / 2, (1.1, 1.3, 1.4, 1.41, 1.42, 2)),
    "toda": ("Toda", lambda u: jnp.exp(u) - u - 1, (0.2, 0.5, 1, 2, 3)),
    "morse": ("Morse", lambda u: jnp.expm1(-u) ** 2, (-0.1, -0.3, -0.5, -0.6, -0.65)),
    "lennard_jones": ("Lennard-Jones", lambda u: 4 * (u**-12 - u**-6), (1.05, 1.2, 1.35, 1.5, 2)),
    "hertz": ("Hertz contact under weight", lambda u: 0.4 * jnp.maximum(u, 0) ** 2.5 - u, (1.1, 1.3, 1.5, 1.7, 1.8)),
    "coulomb": ("spring and repulsion 1/u", lambda u: u**2 / 2 + 1 / u, (1.1, 1.5, 2, 3, 5)),
}


#: Schemes with a modified energy whose runs are compared.
SCHEMES = ("central_difference", "average_acceleration")


@section
class _StepBound(TypedDict):
    allowed_error: Tolerance
    periods: Count


@experiment("stability/step_bound", section="step_bound", model=_StepBound)
@short_runs()
def step_bound(allowed_error: Tolerance, periods: int) -> xr.Dataset:
    """Compare the errors of energy and period with those of the modified energy, at the step bound of the energy.

    Parameters
    ----------
    allowed_error
        Allowed error of the energy, over its height above rest.
    periods
        Length of the runs in exact periods.

    Returns
    -------
    xarray.Dataset
        ``coefficient`` of :func:`study.step_bound`, the ``omega_step`` at which the energy reaches the allowed error,
        and the ``measured_error``, each of shape (scheme, motion), and with the dimension ``quantity`` for energy and
        period. The error of the period is signed by its absolute value only.
    """
    motions = [(name, u0) for name, (_, _, starts) in POTENTIALS.items() for u0 in starts]
    shape, chosen = (len(SCHEMES), len(motions)), [schemes[name] for name in SCHEMES]
    coefficient, measured = np.full((*shape, 2), np.nan), np.full((*shape, 2), np.nan)
    omega_step, (period, distance) = np.full(shape, np.nan), np.full((2, len(motions)), np.nan)
    for name, (title, potential, starts) in POTENTIALS.items():
        progress(f"step bounds for {title}")
        there = [k for k, (potential_name, _) in enumerate(motions) if potential_name == name]
        definition = Problem(potential=potential, u0=starts[0], title=title)
        rest_at = OutcomeObserver.of(definition).rest_at
        orbits = [orbit(replace(definition, u0=u0)) for u0 in starts]
        period[there], distance[there], omega, described = (
            np.array([getattr(motion, field) for motion in orbits])
            for field in ("period", "separatrix_distance", "highest_frequency", "described_up_to")
        )
        initial = np.array([float(definition.stored_energy(u0)) for u0 in starts])
        height = np.array([np.max(motion.v) ** 2 / 2 for motion in orbits])
        for s, scheme in enumerate(chosen):
            energy = modified_equation(scheme).energy
            coefficient[s, there] = [motion.coefficients(energy) for motion in orbits]
            omega_step[s, there] = largest_omega_step(coefficient[s, there, 0], allowed_error, scheme, described)
            step = omega_step[s, there] / omega
            runs = sweep(
                definition,
                scheme,
                dt=step,
                steps=np.ceil(periods * period[there] / step).astype(int),
                u0=np.array(starts, float),
                observe=["max_energy_error", Oscillations(rest_at)],
            )
            measured[s, there, 0] = runs.max_energy_error.values * np.abs(initial) / height
            measured[s, there, 1] = np.abs(runs.mean_period.values / period[there] - 1)
    dims = ("scheme", "motion")
    return xr.Dataset(
        {
            "coefficient": (
                (*dims, "quantity"),
                coefficient,
                {"long_name": "predicted error over (ω Δt)²", "units": "1"},
            ),
            "omega_step": (
                dims,
                omega_step,
                {"long_name": "step bound of the energy times the highest frequency of the motion", "units": "1"},
            ),
            "measured_error": (
                (*dims, "quantity"),
                measured,
                {"long_name": "measured error at the step bound of the energy, NaN where the run failed", "units": "1"},
            ),
            "convex_coefficient": (
                "scheme",
                [modified_equation(scheme).energy.convex for scheme in chosen],
                {"long_name": "largest coefficient of the energy where the tangent is nowhere negative", "units": "1"},
            ),
        },
        coords={
            **coordinates.scheme_coordinates(SCHEMES),
            "potential": ("motion", [name for name, _ in motions], {"long_name": "name of the potential"}),
            "potential_title": ("motion", [POTENTIALS[name][0] for name, _ in motions], {"long_name": "potential"}),
            "u0": ("motion", [u0 for _, u0 in motions], {"long_name": "initial displacement", "units": "1"}),
            "period": ("motion", period, {"long_name": "exact period", "units": "s"}),
            "separatrix_distance": (
                "motion",
                distance,
                {
                    "long_name": "energy between the motion and the nearest barrier or hill over that above rest",
                    "units": "1",
                },
            ),
            "quantity": ("quantity", ["energy", "period"], {"long_name": "quantity whose error is measured"}),
            "allowed_error": ((), allowed_error, {"long_name": "allowed error of the energy", "units": "1"}),
            "periods": ((), periods, {"long_name": "length of the runs in periods", "units": "1"}),
        },
        attrs={"title": f"Step bounds and measured errors over {periods} periods in {len(POTENTIALS)} potentials"},
    )
