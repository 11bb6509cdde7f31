"""Largest gain of energy at close step sizes and from neighbouring starts, which shows whether one run is typical."""

from collections.abc import Mapping
from typing import ClassVar

import jax.numpy as jnp
import numpy as np
import xarray as xr

from study.declaration.checks import step_beyond_run
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, Schemes, Spring, StepSizes, Tolerance
from study.experiments import coordinates
from study.experiments.sensitivity import STARTS
from study.marching.result import STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.observer.base import Reduction
from study.observer.energy import relative_energy_error
from study.problem.named import approximate_periods
from study.problem.named import problems as problems_by_name


class _LargestGain(Reduction):
    """Largest relative gain of energy over the run, max (E − E₀)/|E₀|."""

    variables: ClassVar = {"largest_gain": {"long_name": "largest relative gain of the total energy", "units": "1"}}
    needs_energy = True

    def start(self, problem, state):
        return state, jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        initial, largest = carried
        return initial, jnp.maximum(largest, relative_energy_error(problem, initial, state))

    def result(self, carried, problem, state):
        return {"largest_gain": carried[1]}


def _check(options: Options, configuration: Mapping) -> str | None:
    return step_beyond_run(options["step_size_over_period"]["last"], options["periods"])


@experiment("step_window", check=_check)
def step_window(
    problem: Spring, schemes: Schemes, step_size_over_period: StepSizes, perturbation: Tolerance, periods: Count
) -> xr.Dataset:
    """Compute the largest gain of energy over a window of step sizes and many starts, for every scheme.

    Every scheme runs at all step sizes from all starts, which are multiples of ``perturbation`` apart, as in
    ``sensitivity``. ``largest_gain`` is max (E − E₀)/|E₀| over ``periods`` printed periods, of shape (scheme,
    step_size_over_period, start).
    """
    progress(f"a window of steps on {problem}")
    parts = np.linspace(step_size_over_period["first"], step_size_over_period["last"], step_size_over_period["count"])
    part, start = (values.ravel() for values in np.meshgrid(parts, np.array(STARTS), indexing="ij"))
    u0 = float(problems_by_name[problem].u0) + perturbation * start
    dt, steps = approximate_periods[problem] * part, np.round(periods / part).astype(int)
    runs = [sweep(problem, scheme, dt=dt, steps=steps, u0=u0, observe=_LargestGain()) for scheme in schemes]
    dims, shape = ("scheme", "step_size_over_period", "start"), (len(schemes), len(parts), len(STARTS))
    largest, status = (np.stack([ds[name].values for ds in runs]).reshape(shape) for name in ("largest_gain", "status"))
    return xr.Dataset(
        {
            "largest_gain": (
                dims,
                largest,
                {"long_name": f"largest relative gain of the total energy over {periods} periods", "units": "1"},
            ),
            "status": (dims, status, STATUS_ATTRIBUTES),
            "perturbation": ((), perturbation, {"long_name": "unit of the distances of the starts", "units": "1"}),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "step_size_over_period": (
                "step_size_over_period",
                parts,
                {"long_name": "step size over the printed period", "units": "1"},
            ),
            "start": ("start", list(STARTS), {"long_name": "initial distance in perturbations", "units": "1"}),
        },
        attrs={"title": f"Largest gain of energy in a window of steps: {problems_by_name[problem].title}"},
    )
