"""Exact periods of the springs over decades of amplitude, which the step sizes of the stability maps are counted by."""

from collections.abc import Sequence

import jax
import numpy as np
import xarray as xr

from reference import closed_form
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.problem.definition import Problem
from study.problem.named import problems as registry

#: Decimal digits of the working: more than the sixteen that are kept, and a hundred periods a second.
DIGITS = 20
#: Points of an orbit, the first of which is also the last.
POINTS = 65


def _turning_points(problem: Problem, u0: np.ndarray) -> np.ndarray:
    """Least and largest displacement of each motion, (amplitudes, 2)."""
    return np.array([closed_form.turning_points(problem, value) for value in u0])


def _highest_frequency(problem: Problem, ends: np.ndarray) -> np.ndarray:
    """√(max p′) between the turning points of each motion, (amplitudes,)."""
    places = ends[:, :1] + np.diff(ends) * np.linspace(0, 1, 1001)
    return np.sqrt(np.asarray(jax.jit(jax.vmap(jax.grad(problem.force)))(places.ravel())).reshape(places.shape).max(1))


def _orbit(problem: Problem, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity once around each motion, (amplitudes, points), from its largest displacement."""
    angle = np.linspace(0, 2 * np.pi, POINTS)
    u = ends.mean(1, keepdims=True) + np.diff(ends) / 2 * np.cos(angle)
    potential = np.asarray(jax.jit(jax.vmap(problem.potential))(u.ravel())).reshape(u.shape)  # type: ignore[arg-type, type-var]
    speed = np.sqrt(2 * np.maximum(potential[:, :1] - potential, 0))
    return u, -np.copysign(speed, np.sin(angle))


@experiment(
    "reference/amplitudes",
    section="atlas",
    options=lambda c: {"problems": c["atlas"]["problems"], "exponents": c["atlas"]["amplitudes"]},
)
def amplitudes(problems: Sequence[str], exponents: dict[str, float]) -> xr.Dataset:
    """Period and orbit of every problem from rest at u₀ 10^x, for x from ``first`` to ``last``, ``count`` in number.

    Raises
    ------
    ValueError
        If there is no closed form for the period of a problem, as at its rest.
    """
    x = np.linspace(exponents["first"], exponents["last"], int(exponents["count"]))
    u0 = np.stack([float(registry[name].u0) * 10**x for name in problems])
    period, highest = np.empty_like(u0), np.empty_like(u0)
    orbits = []
    for p, name in enumerate(problems):
        progress(f"periods of {name}")
        period[p] = [float(closed_form.period(registry[name], value, DIGITS)) for value in u0[p]]
        ends = _turning_points(registry[name], u0[p])
        highest[p] = _highest_frequency(registry[name], ends)
        orbits.append(_orbit(registry[name], ends))
    u, v = map(np.stack, zip(*orbits, strict=True))
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
            "orbit_u": ((*dims, "point"), u, {"long_name": "displacement along the exact orbit", "units": "1"}),
            "orbit_v": ((*dims, "point"), v, {"long_name": "velocity along the exact orbit", "units": "s-1"}),
        },
        coords={
            "problem": ("problem", list(problems), {"long_name": "problem"}),
            "amplitude": (
                "amplitude",
                10**x,
                {"long_name": "initial displacement over that of the problem", "units": "1"},
            ),
        },
        attrs={"title": "Exact periods of the springs over decades of amplitude"},
    )
