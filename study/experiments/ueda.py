"""The largest Lyapunov exponent and the mean square of Ueda's oscillator by scheme and step size."""

from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Ge, Le

from study.declaration.experiment import experiment, progress
from study.declaration.options import Count, RisingCounts, Schemes
from study.experiments import coordinates
from study.marching.run import sweep
from study.observer.base import Observer
from study.observer.motion import Quantity
from study.problem.named import problems, time_scales
from study.problem.oscillators import UEDA_EXPONENT

OBSERVED: list[str | Observer] = ["lyapunov_exponent", Quantity(lambda u: u, name="root_mean_square", reduce="rms")]


@experiment("ueda")
def ueda(
    schemes: Schemes,
    steps_per_period: RisingCounts,
    periods: Count,
    runs: Annotated[int, Ge(2), Le(64)],
) -> xr.Dataset:
    """Measure the largest Lyapunov exponent and the mean square displacement of the numerical map of Ueda's oscillator.

    Both are measured over the second half of each run. Their means and standard errors are over ``runs`` initial
    displacements. The motion is chaotic: orbits are lost after some periods, statistics need not be.

    Parameters
    ----------
    steps_per_period, periods
        Steps in a period of the load, and the length of a run in periods.

    Returns
    -------
    xarray.Dataset
        ``exponent``, ``mean_square`` and their standard errors, of shape (scheme, steps_per_period), NaN where a run
        failed.
    """
    problem, period = problems["ueda"], time_scales["ueda"]
    u0 = problem.u0 + np.linspace(0.0, 1.0, runs)
    means, errors = np.empty((2, 2, len(schemes), len(steps_per_period)))
    for s, scheme in enumerate(schemes):
        progress(f"exponent of {scheme}")
        for k, parts in enumerate(steps_per_period):
            steps = periods * parts
            half, whole = (
                sweep(problem, scheme, dt=period / parts, steps=n, u0=u0, observe=OBSERVED) for n in (steps // 2, steps)
            )
            rate = (steps * whole.lyapunov_exponent - steps // 2 * half.lyapunov_exponent) / (steps - steps // 2)
            square = 2 * whole.root_mean_square**2 - half.root_mean_square**2
            for q, value in enumerate((rate, square)):
                means[q, s, k] = value.mean(skipna=False)
                errors[q, s, k] = value.std(ddof=1, skipna=False) / np.sqrt(runs)
    dims = ("scheme", "steps_per_period")
    return xr.Dataset(
        {
            "exponent": (dims, means[0], {"long_name": "largest Lyapunov exponent", "units": "s-1"}),
            "uncertainty": (dims, errors[0], {"long_name": "standard error of the exponent", "units": "s-1"}),
            "mean_square": (dims, means[1], {"long_name": "mean square of the displacement", "units": "1"}),
            "mean_square_uncertainty": (
                dims,
                errors[1],
                {"long_name": "standard error of the mean square", "units": "1"},
            ),
            "printed_exponent": ((), UEDA_EXPONENT, {"long_name": "exponent of Sprott (2003)", "units": "s-1"}),
            "period": ((), period, {"long_name": "period of the load", "units": "s"}),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
        },
        attrs={
            "title": "Lyapunov exponent and mean square of Ueda's oscillator by scheme and step",
            "periods": periods,
        },
    )
