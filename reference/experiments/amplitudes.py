"""Exact periods of the springs over decades of amplitude, for the maps of stability."""

from collections.abc import Mapping

import jax
import numpy as np
import xarray as xr
from jaxtyping import Float

from reference import closed_form
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Springs
from study.mechanics.definition import Problem
from study.problem.named import problems as problems_by_name

#: Number of decimal digits of the arithmetic, more than the sixteen that are stored. With this number, a hundred exact
#: periods are computed in a second.
DIGITS = 20
#: Array with one value for each motion.
_ByAmplitude = Float[np.ndarray, "amplitudes"]
#: Array with the two turning points of each motion.
_TurningPoints = Float[np.ndarray, "amplitudes 2"]


def _turning_points(problem: Problem, u0: _ByAmplitude) -> _TurningPoints:
    """Least and largest displacement of each motion."""
    return np.array([closed_form.turning_points(problem, value) for value in u0])


def _highest_frequency(problem: Problem, ends: _TurningPoints) -> _ByAmplitude:
    """√(max p′(u)) between the turning points of each motion."""
    places = ends[:, :1] + np.diff(ends) * np.linspace(0, 1, 1001)
    return np.sqrt(
        np.asarray(jax.jit(jax.vmap(jax.grad(problem.static_force)))(places.ravel())).reshape(places.shape).max(1)
    )


def _options(configuration: Mapping) -> Options:
    return {"problems": configuration["atlas"]["problems"], "exponents": configuration["atlas"]["amplitudes"]}


@experiment("reference/amplitudes", section="atlas", options=_options)
def amplitudes(problems: Springs, exponents: dict[str, float]) -> xr.Dataset:
    """Compute the exact period of every spring over decades of amplitude.

    The springs are released from rest at u₀ 10ˣ, with the initial displacement u₀ of the problem. Variables have the
    shape (problem, amplitude).

    Parameters
    ----------
    exponents
        ``count`` values of x from ``first`` to ``last``.

    Raises
    ------
    ValueError
        If a period has no closed form, for instance if a double well is released at the top of its barrier, u = 0.
    """
    x = np.linspace(exponents["first"], exponents["last"], int(exponents["count"]))
    u0 = np.stack([float(problems_by_name[problem].u0) * 10**x for problem in problems])
    period, highest = np.empty_like(u0), np.empty_like(u0)
    for p, problem in enumerate(problems):
        progress(f"periods of {problem}")
        definition = problems_by_name[problem]
        period[p] = [float(closed_form.period(definition, value, DIGITS)) for value in u0[p]]
        highest[p] = _highest_frequency(definition, _turning_points(definition, u0[p]))
    dims = ("problem", "amplitude")
    return xr.Dataset(
        {
            "u0": (dims, u0, {"long_name": "initial displacement", "units": "1"}),
            "period": (dims, period, {"long_name": "exact period", "units": "s"}),
            "period_uncertainty": (
                dims,
                np.spacing(period) / 2,
                {"long_name": "uncertainty of the period as stored", "units": "s"},
            ),
            "highest_frequency": (
                dims,
                highest,
                {"long_name": "largest circular frequency of the tangent along the motion", "units": "s-1"},
            ),
        },
        coords={
            "problem": ("problem", list(problems), {"long_name": "problem"}),
            "amplitude": (
                "amplitude",
                10**x,
                {"long_name": "initial displacement over the problem's own", "units": "1"},
            ),
        },
        attrs={"title": "Exact periods of the springs over decades of amplitude"},
    )
