"""Linear theory of the schemes: spectral radius, period, damping, overshoot, order and stability limit."""

from collections.abc import Sequence
from typing import Annotated

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study.algebra.jit import short_runs
from study.analysis.linear_theory import LinearTheory, oscillator
from study.declaration.experiment import experiment, progress
from study.declaration.options import IN_ORDER, DampingRatios, Schemes, section
from study.experiments import coordinates
from study.mechanics.state import Motion
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name
from study.scheme.rederived import Rederived

#: Long name of the order with the acceleration rederived.
_REDERIVED = (
    "this order with the acceleration from the equation of motion after every step; NaN if the scheme carries no "
    "acceleration"
)


def _order_rederived(scheme: Scheme, step_size_over_period: np.ndarray, damping_ratio: float) -> float:
    if not isinstance(jax.eval_shape(lambda: scheme.start(oscillator(), jnp.ones(()), jnp.zeros(()), 1.0)[0]), Motion):
        return np.nan
    return LinearTheory(Rederived(scheme=scheme), step_size_over_period, damping_ratio).order()


def _theory_of_scheme(scheme: Scheme, step_size_over_period: np.ndarray, damping_ratios: Sequence[float]) -> xr.Dataset:
    by_damping = [LinearTheory(scheme, step_size_over_period, ratio).dataset() for ratio in damping_ratios]
    rederived = [_order_rederived(scheme, step_size_over_period, ratio) for ratio in damping_ratios]
    theory = xr.concat(by_damping, "damping_ratio").assign(
        order_rederived=("damping_ratio", rederived, {"long_name": _REDERIVED, "units": "1"})
    )
    return theory.assign(memory=theory.memory.isel(damping_ratio=0))


@section
class _Exponents(TypedDict):
    first: Annotated[float, Ge(-9), Le(9)]
    last: Annotated[float, Ge(-9), Le(9)]
    per_decade: Annotated[int, Ge(1), Le(1000)]


@experiment("spectral")
@short_runs()
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
        Variables of shape (scheme, step_size_over_period, damping_ratio) or (scheme, damping_ratio), and ``memory`` of
        shape (scheme,).
    """
    decades = exponents["last"] - exponents["first"]
    step_size_over_period = np.logspace(
        exponents["first"], exponents["last"], round(decades * exponents["per_decade"]) + 1
    )
    theories = []
    for name in schemes:
        progress(f"linear theory of {name}")
        theories.append(_theory_of_scheme(schemes_by_name[name], step_size_over_period, damping_ratios))
    return (
        xr.concat(theories, "scheme")
        .assign_coords(
            **coordinates.scheme_coordinates(schemes), **coordinates.forces_coordinates(schemes, several=True)
        )
        .assign_attrs(title="Linear theory of the schemes, from the derivative of their steps")
        .transpose("scheme", "step_size_over_period", "damping_ratio")
    )
