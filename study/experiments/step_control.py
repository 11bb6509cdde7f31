"""Error and energy over many periods with controlled and with equal steps."""

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr

from study import io
from study.control.controllers import Controller, Reversible
from study.control.named import controllers as controllers_by_name
from study.declaration.experiment import experiment, progress, references
from study.declaration.options import Controllers, Count, Counts, OneStepSchemes, Springs, Tolerances
from study.experiments import coordinates
from study.marching.run import sweep
from study.observer.motion import Quantity
from study.problem.named import problems as problems_by_name

#: Name of reversible control along the dimension ``controller``. Name of equal steps along the dimension
#: ``with_equal``.
REVERSIBLE, EQUAL = "reversible", "equal"

#: Largest mean number of steps per period of a run. This limit ends runs whose energy grows, because their steps become
#: ever smaller.
MOST = 1000

#: Observers of displacement and velocity at the end of a run.
ENDS = [Quantity(lambda u: u, name="end_u", reduce="final"), Quantity(lambda v: v, name="end_v", reduce="final")]


def reversible(problem: str, period: float) -> Reversible:
    """Reversible control of a spring of unit mass with the density ρ, where ρ² = ω² + max(p'(u), 0) and ω = 2π/T."""
    force, omega = problems_by_name[problem].force, 2 * np.pi / period

    def density(u, v):
        return jnp.sqrt(omega**2 + jnp.maximum(jax.grad(force)(u), 0.0))

    return Reversible(density)


@experiment("step_control", reads=references)
def step_control(
    problems: Springs,
    schemes: OneStepSchemes,
    controllers: Controllers,
    tolerances: Tolerances,
    steps_per_period: Counts,
    periods: Count,
) -> xr.Dataset:
    """March springs over whole periods with controlled and with equal steps.

    After whole periods the exact motion returns to its start. ``return_error`` is the distance of the numerical motion
    from the start: the larger of the differences of displacement and velocity, each relative to its largest value.
    ``max_energy_error`` is eq. (17) of Xie (1996). Reversible control takes about as many steps as the
    first controller at the same tolerance. The histories are the largest energy errors of each period, for the first
    scheme at the middle tolerance. They include a run with equal steps, as many as the first controller took.
    """
    controls = [*controllers, REVERSIBLE]
    shape = (len(problems), len(schemes), len(controls), len(tolerances))
    names = "steps", "rejected", "max_energy_error", "energy_drift", "error"
    values = {name: np.full(shape, np.nan) for name in names}
    equal = np.full((*shape[:2], len(steps_per_period)), np.nan)
    history = np.full((len(problems), len(controls) + 1, periods), np.nan)
    middle = len(tolerances) // 2
    for p, problem in enumerate(problems):
        period = coordinates.periods(problem)["exact"]
        scale = _scale(problem)
        start = problems_by_name[problem].u0, problems_by_name[problem].v0
        named: dict[str, Controller] = {name: controllers_by_name[name] for name in controllers}
        named[REVERSIBLE] = reversible(problem, period)
        for s, scheme in enumerate(schemes):
            progress(f"control of {scheme} on {problem}")
            for c, (name, controller) in enumerate(named.items()):
                allowed = np.array(tolerances)
                if name == REVERSIBLE:  # the integral of the density over a period is about 3π
                    allowed = 3 * np.pi * periods / values["steps"][p, s, 0]
                ds = _controlled(problem, scheme, controller, allowed, period * periods, MOST * periods)
                at = p, s, c
                values["steps"][at], values["rejected"][at] = ds.steps, ds.steps_rejected_by_estimate
                values["max_energy_error"][at], values["energy_drift"][at] = ds.max_energy_error, ds.energy_drift
                values["error"][at] = _distance(ds, start, scale)
                if s == 0:
                    along_time = sweep(
                        problem,
                        scheme,
                        controller=controller,
                        tolerance=allowed[middle],
                        duration=period * periods,
                        steps=MOST * periods,
                        observe="energy_error",
                    )
                    history[p, c] = _by_period(along_time, period, periods)
            for k, steps in enumerate(steps_per_period):
                ds = sweep(problem, scheme, dt=period / steps, steps=steps * periods, observe=ENDS)
                equal[p, s, k] = _distance(ds, start, scale)
            if s == 0:
                steps = round(values["steps"][p, 0, 0, middle])
                ds = sweep(problem, scheme, dt=period * periods / steps, steps=steps, observe="energy_error")
                history[p, -1] = _by_period(ds, period, periods)
    dims = ("problem", "scheme", "controller", "tolerance")
    equal_dims = ("problem", "scheme", "steps_per_period")
    energy = {"long_name": "largest relative error of the total energy, eq. (17) of Xie (1996)", "units": "1"}
    period_attributes = {"long_name": "largest relative error of the total energy of each period", "units": "1"}
    distance = {"long_name": "distance from the start after whole periods, over the largest value", "units": "1"}
    return xr.Dataset(
        {
            "steps": (dims, values["steps"], {"long_name": "number of steps", "units": "1"}),
            "rejected": (dims, values["rejected"], {"long_name": "trial steps that were rejected", "units": "1"}),
            "max_energy_error": (dims, values["max_energy_error"], energy),
            "energy_drift": (
                dims,
                values["energy_drift"],
                {"long_name": "signed relative error of the total energy at the end", "units": "1"},
            ),
            "return_error": (dims, values["error"], distance),
            "equal_return_error": (equal_dims, equal, distance | {"comment": "with equal steps"}),
            "max_energy_error_of_period": (("problem", "with_equal", "period_number"), history, period_attributes),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.control_coordinates(controls),
            "with_equal": ("with_equal", [*controls, EQUAL], {"long_name": "controller, or equal steps"}),
            "tolerance": ("tolerance", list(tolerances), {"long_name": "tolerance", "units": "1"}),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "period_number": (
                "period_number",
                np.arange(1, periods + 1),
                {"long_name": "number of the period", "units": "1"},
            ),
        },
        attrs={"title": "Controlled and equal steps over many periods", "periods": periods},
    )


def _controlled(problem: str, scheme: str, controller: Controller, tolerances: np.ndarray, duration: float, most: int):
    return sweep(
        problem,
        scheme,
        tolerance=tolerances,
        duration=duration,
        controller=controller,
        steps=most,
        observe=[*ENDS, "max_energy_error", "energy_drift"],
    )


def _scale(problem: str) -> tuple[float, float]:
    """Largest displacement and velocity of the exact motion."""
    known = io.open_dataset(f"reference/{problem}")
    return float(np.abs(known.u).max()), float(np.abs(known.v).max())


def _distance(ds: xr.Dataset, start, scale) -> np.ndarray:
    return np.maximum(abs(ds.end_u - start[0]) / scale[0], abs(ds.end_v - start[1]) / scale[1]).values


def _by_period(ds: xr.Dataset, period: float, periods: int) -> np.ndarray:
    """Largest size of the energy error in each period; NaN after the end of a run that failed."""
    number = np.minimum((ds.t.values[1:] / period - 1e-9).astype(int), periods - 1)
    largest = np.full(periods, np.nan)
    size = np.abs(ds.energy_error.values[1:])
    np.fmax.at(largest, number[np.isfinite(size)], size[np.isfinite(size)])
    return largest
