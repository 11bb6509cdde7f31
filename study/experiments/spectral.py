"""Linear theory of the schemes: spectral radius, period, damping, overshoot, order and stability limit."""

from typing import Annotated

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study.analysis.linear_theory import OVERSHOOT_STEPS, LinearTheory, oscillator
from study.declaration.experiment import experiment, progress
from study.declaration.options import IN_ORDER, DampingRatios, Schemes, section
from study.experiments import coordinates
from study.mechanics.state import Motion
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name
from study.scheme.rederived import Rederived

#: Variables over step sizes, with their long names.
_OVER_STEPS = {
    "spectral_radius": "spectral radius of the amplification matrix",
    "period_elongation": "relative elongation of the damped period; NaN without oscillation",
    "algorithmic_damping": "damping ratio of the numerical motion, with the oscillator's own; NaN without oscillation",
    "amplitude_decay": "relative loss of amplitude per period; NaN without oscillation",
    "displacement_overshoot": f"largest displacement of {OVERSHOOT_STEPS} steps from rest over the initial one, less "
    "one; NaN where unstable",
    "velocity_overshoot": f"largest velocity of {OVERSHOOT_STEPS} steps from rest over the undamped motion's, "
    "less one; NaN where unstable",
}
#: Variables that are one number for each damping ratio, with their long names.
_NUMBERS = {
    "stability_limit": "largest ωΔt up to which the spectral radius is at most one; infinite where it always is",
    "infinite_frequency_radius": "spectral radius at infinite frequency",
    "linear_order": "order with which the principal roots approach the exact ones",
    "order_rederived": "this order with the acceleration from the equation of motion after every step; NaN if the "
    "scheme carries no acceleration",
    "growth_u_from_u": "exponent of ωΔt with which the displacement of the first long step grows from u₀",
    "growth_v_from_u": "exponent of ωΔt with which the velocity of the first long step over ω grows from u₀",
    "growth_u_from_v": "exponent of ωΔt with which ω times the displacement of the first long step grows from u̇₀",
    "growth_v_from_v": "exponent of ωΔt with which the velocity of the first long step grows from u̇₀",
}


def _state(scheme: Scheme):
    """Shapes of the state that a step of the scheme passes to the next."""
    return jax.eval_shape(lambda: scheme.start(oscillator(), jnp.ones(()), jnp.zeros(()), 1.0)[0])


def _vectors(name: str) -> int:
    """Number of vectors of the size of u in the state that a step passes to the next."""
    return sum(leaf.size for leaf in jax.tree.leaves(_state(schemes_by_name[name])))


def _order_rederived(scheme: Scheme, dt_over_period: np.ndarray, damping_ratio: float) -> float:
    if not isinstance(_state(scheme), Motion):
        return np.nan
    return LinearTheory(Rederived(scheme=scheme), dt_over_period, damping_ratio).order()


def _of_scheme(scheme: Scheme, dt_over_period: np.ndarray, damping_ratio: float) -> dict[str, np.ndarray | float]:
    theory = LinearTheory(scheme, dt_over_period, damping_ratio)
    motion, (displacement, velocity) = theory.motion(), theory.overshoot()
    (u_from_u, v_from_u), (u_from_v, v_from_v) = theory.growth().tolist()
    return {
        "spectral_radius": theory.spectral_radius,
        "period_elongation": motion.period_elongation,
        "algorithmic_damping": motion.algorithmic_damping,
        "amplitude_decay": motion.amplitude_decay,
        "displacement_overshoot": displacement,
        "velocity_overshoot": velocity,
        "stability_limit": theory.stability_limit(),
        "infinite_frequency_radius": theory.infinite_frequency_radius(),
        "linear_order": theory.order(),
        "order_rederived": _order_rederived(scheme, dt_over_period, damping_ratio),
        "growth_u_from_u": u_from_u,
        "growth_v_from_u": v_from_u,
        "growth_u_from_v": u_from_v,
        "growth_v_from_v": v_from_v,
    }


@section
class _Exponents(TypedDict):
    first: Annotated[float, Ge(-9), Le(9)]
    last: Annotated[float, Ge(-9), Le(9)]
    per_decade: Annotated[int, Ge(1), Le(1000)]


@experiment("spectral")
def spectral(
    schemes: Schemes,
    exponents: Annotated[_Exponents, IN_ORDER],
    damping_ratios: DampingRatios,
) -> xr.Dataset:
    """Compute the linear theory of every scheme, by step size and damping of the oscillator.

    The oscillator is ü + 2ξω u̇ + ω² u = 0 with T = 2π/ω. See :class:`study.analysis.linear_theory.LinearTheory`.

    Parameters
    ----------
    exponents
        Δt/T runs from 10 to the power ``first`` to 10 to the power ``last``, with ``per_decade`` points in a decade.
    damping_ratios
        Damping ratios 0 ≤ ξ < 1.

    Returns
    -------
    xarray.Dataset
        Variables of shape (scheme, dt_over_period, damping_ratio) or (scheme, damping_ratio), and ``memory`` of shape
        (scheme,).
    """
    decades = exponents["last"] - exponents["first"]
    dt_over_period = np.logspace(exponents["first"], exponents["last"], round(decades * exponents["per_decade"]) + 1)
    found: dict[str, list] = {name: [] for name in (*_OVER_STEPS, *_NUMBERS)}
    for name in schemes:
        progress(f"linear theory of {name}")
        of_scheme = [_of_scheme(schemes_by_name[name], dt_over_period, ratio) for ratio in damping_ratios]
        for variable, values in found.items():
            values.append([of_ratio[variable] for of_ratio in of_scheme])
    dims = ("scheme", "damping_ratio")
    return xr.Dataset(
        {
            name: ((*dims, "dt_over_period"), found[name], {"long_name": text, "units": "1"})
            for name, text in _OVER_STEPS.items()
        }
        | {name: (dims, found[name], {"long_name": text, "units": "1"}) for name, text in _NUMBERS.items()}
        | {
            "memory": (
                "scheme",
                [_vectors(name) for name in schemes],
                {"long_name": "vectors of the size of u that a step passes to the next", "units": "1"},
            )
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            **coordinates.forces_coordinates(schemes),
            "dt_over_period": ("dt_over_period", dt_over_period, {"long_name": "step size over period", "units": "1"}),
            "damping_ratio": (
                "damping_ratio",
                list(damping_ratios),
                {"long_name": "damping ratio of the oscillator", "units": "1"},
            ),
        },
        attrs={"title": "Linear theory of the schemes, from the derivative of their steps"},
    ).transpose("scheme", "dt_over_period", "damping_ratio")
