"""Runge-Kutta with and without relaxation: errors of the energy, and of the motion after whole periods."""

import numpy as np
import xarray as xr

from study.declaration.experiment import experiment, progress, references
from study.declaration.options import Count, Counts, Springs
from study.experiments import coordinates
from study.marching.run import sweep
from study.problem.named import problems as problems_by_name
from study.scheme.runge_kutta import rk4
from study.scheme.wrapper.relaxed import Relaxed

#: The method without and with relaxation.
VARIANTS = {"plain": rk4, "relaxed": Relaxed(scheme=rk4)}


@experiment("relaxation", reads=references)
def relaxation(problems: Springs, steps_per_period: Counts, periods: Count) -> xr.Dataset:
    """Compute errors of energy and motion of the Runge-Kutta method with and without relaxation.

    The error of the energy is max |E − E₀|/|E₀| over ``periods`` periods, with the period rounded as in Xie (1996). The
    error of the motion is the distance √((u/u₀ − 1)² + u̇²/(2E₀)) from the start after ``periods`` exact periods. Both
    errors have the shape (problem, steps_per_period, variant).

    Raises
    ------
    FileNotFoundError
        If the reference of a problem, which holds its exact period, has not been made.
    """
    shape = len(problems), len(steps_per_period), len(VARIANTS)
    energy, motion = np.empty(shape), np.empty(shape)
    for p, problem in enumerate(problems):
        progress(f"relaxation on {problem}")
        known, spring = coordinates.periods(problem), problems_by_name[problem]
        u0, fastest = spring.u0, np.sqrt(2 * spring.energy(spring.u0, spring.v0))
        for m, scheme in enumerate(VARIANTS.values()):
            for k, steps in enumerate(steps_per_period):
                tables, whole = (
                    sweep(
                        problem,
                        scheme,
                        dt=period / steps,
                        steps=steps * periods,
                        every=steps * periods,
                        observe=["trajectory", "max_energy_error"],
                    )
                    for period in (known["printed"], known["exact"])
                )
                energy[p, k, m] = tables.max_energy_error
                motion[p, k, m] = np.hypot(whole.u[-1] / u0 - 1, whole.v[-1] / fastest)
    dims = ("problem", "steps_per_period", "variant")
    return_attributes = {"long_name": f"relative distance from the start after {periods} exact periods", "units": "1"}
    return xr.Dataset(
        {
            "max_energy_error": (dims, energy, coordinates.energy_attributes(periods)),
            "return_error": (dims, motion, return_attributes),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "variant": ("variant", list(VARIANTS), {"long_name": "Runge-Kutta without or with relaxation"}),
        },
        attrs={"title": "Runge-Kutta with and without relaxation by problem and step size"},
    )
