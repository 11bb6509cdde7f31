"""Automatic steps of finite element codes: steps in a period, energy error, and the effect of a halved step."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from study.control.codes import (
    ApparentFrequency,
    HalfIncrement,
    HalfStepResidual,
    Iterations,
    Nastran,
    Proportional,
)
from study.control.controllers import Controller, Prescribed
from study.control.estimators import Estimator, ZienkiewiczXie
from study.declaration.experiment import experiment, progress, references
from study.declaration.options import Count, Counts, Springs
from study.experiments import coordinates
from study.marching.run import run, sweep
from study.mechanics.definition import Problem
from study.scheme.alpha import hht_alpha
from study.scheme.base import Scheme
from study.scheme.newmark import average_acceleration

#: Largest number of steps in a period, on average over the run.
MOST = 1000


class Rule(NamedTuple):
    """The automatic step of a code: scheme, estimator, controller, and the tolerances in its manual."""

    scheme: Scheme
    estimator: Estimator
    controller: Controller
    tolerances: tuple[float, ...]


#: Rules by code. A tolerance is the half-increment residual divided by the largest force for Abaqus, the step size
#: divided by the apparent period for Nastran, and the number of Newton iterations for OpenSees.
RULES = {
    "Abaqus": Rule(hht_alpha, HalfStepResidual(), HalfIncrement(), (0.1, 1.0, 10.0)),
    "Nastran": Rule(average_acceleration, ApparentFrequency(), Nastran(), (1 / 40, 1 / 20, 1 / 10)),
    "OpenSees": Rule(average_acceleration, Iterations(), Proportional(), (2.0, 4.0, 8.0)),
}
CLASSES = ("tight", "middle", "loose")

#: Tolerances and duration of the runs on a linear oscillator by which SciML tests its adaptive Newmark method.
SCIML, LINEAR_DURATION = (1e-4, 1e-6, 1e-8), 5.0


@experiment("control_of_codes", reads=references)
def control_of_codes(problems: Springs, steps_per_period: Counts, periods: Count) -> xr.Dataset:
    """March springs over whole periods with the automatic steps of codes, and with a step that is halved once.

    ``steps_per_period`` and ``max_energy_error``, eq. (17) of Xie (1996), have the shape (problem, code, class). Along
    ``class`` are the tight, middle and loose tolerance of each code. The first step is a hundredth of the period.

    ``halved_energy_error`` compares two runs of average acceleration. It is the energy error of a run whose step is
    halved in the middle, divided by the energy error of a run that keeps its first step.

    ``error_in_tolerances`` repeats a test of SciML, average acceleration on ü + u = 0 from u̇₀ = 1. It is the largest
    error of displacement or velocity, divided by the tolerance times the number of steps. Our tolerance is relative to
    the largest displacement, and SciML's tolerance to one plus the displacement.
    """
    shape = (len(problems), len(RULES), len(CLASSES))
    steps, energy = np.full(shape, np.nan), np.full(shape, np.nan)
    halved = np.full((len(problems), len(steps_per_period)), np.nan)
    for p, problem in enumerate(problems):
        period = coordinates.periods(problem)["exact"]
        for c, (code, rule) in enumerate(RULES.items()):
            progress(f"the automatic steps of {code} on {problem}")
            ds = sweep(
                problem,
                rule.scheme,
                tolerance=np.array(rule.tolerances),
                duration=period * periods,
                dt=period / 100,
                estimator=rule.estimator,
                controller=rule.controller,
                steps=MOST * periods,
                observe=["max_energy_error"],
            )
            steps[p, c], energy[p, c] = ds.steps / periods, ds.max_energy_error
        for k, parts in enumerate(steps_per_period):
            dt, before = period / parts, parts * periods // 2
            sizes = np.append(np.full(before, dt), np.full(parts * periods, dt / 2))
            ds = run(
                problem,
                average_acceleration,
                controller=Prescribed(sizes),
                duration=period * periods,
                observe=["max_energy_error"],
            )
            whole = run(problem, average_acceleration, dt=dt, steps=parts * periods, observe=["max_energy_error"])
            halved[p, k] = ds.max_energy_error / whole.max_energy_error
    errors_in_tolerances = [_error_in_tolerances(tolerance) for tolerance in SCIML]
    dims = ("problem", "code", "class")
    largest = {"long_name": "largest relative error of the total energy, eq. (17) of Xie (1996)", "units": "1"}
    return xr.Dataset(
        {
            "steps_per_period": (dims, steps, {"long_name": "steps in a period", "units": "1"}),
            "max_energy_error": (dims, energy, largest),
            "tolerance": (
                dims[1:],
                [rule.tolerances for rule in RULES.values()],
                {"long_name": "tolerance of the code's own estimate", "units": "1"},
            ),
            "halved_energy_error": (
                ("problem", "steps_at_first"),
                halved,
                {
                    "long_name": "energy error with a step halved in the middle over the one with equal steps",
                    "units": "1",
                },
            ),
            "error_in_tolerances": (
                "linear_tolerance",
                errors_in_tolerances,
                {"long_name": "largest error over the tolerance times the number of steps", "units": "1"},
            ),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            "code": ("code", list(RULES), {"long_name": "code"}),
            "class": ("class", list(CLASSES), {"long_name": "class of the tolerance"}),
            "steps_at_first": (
                "steps_at_first",
                list(steps_per_period),
                {"long_name": "steps in a period before the step is halved", "units": "1"},
            ),
            "linear_tolerance": (
                "linear_tolerance",
                list(SCIML),
                {"long_name": "tolerance on the linear oscillator", "units": "1"},
            ),
        },
        attrs={"title": "Automatic steps of codes on springs", "periods": periods},
    )


def _error_in_tolerances(tolerance: float) -> float:
    """Largest error of u or u̇ of the linear oscillator, divided by the tolerance times the number of steps."""
    oscillator = Problem(lambda u: u, 0.0, 1.0)
    ds = run(
        oscillator,
        average_acceleration,
        tolerance=tolerance,
        duration=LINEAR_DURATION,
        dt=0.1,
        estimator=ZienkiewiczXie(),
    )
    t = ds.t.values
    error = max(np.abs(ds.u.values - np.sin(t)).max(), np.abs(ds.v.values - np.cos(t)).max())
    return error / (tolerance * ds.steps.item())
