"""Estimates of the error of a step, compared with the true one."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study.control.controllers import Prescribed
from study.control.named import estimators as estimators_by_name
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Counts, Estimators, Schemes, Springs
from study.experiments import coordinates
from study.marching.run import run
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name
from study.scheme.splitting import kahan_li8

#: Scheme and number of its steps that solve for the true motion over one step of another scheme.
FINE, FINE_STEPS = kahan_li8, 16

#: Part of the period at which the curve along the motion has a value.
PHASES = np.linspace(0, 1, 101)


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    return FINE_STEPS * len(options["problems"]) * len(options["schemes"]) * sum(options["steps_per_period"])


@experiment(
    "estimates", reads=lambda options: [f"reference/{one}" for one in options["problems"]], steps=_number_of_steps
)
def estimates(problems: Springs, schemes: Schemes, estimators: Estimators, steps_per_period: Counts) -> xr.Dataset:
    """Measure estimates of the error of a step over one period, next to the true error.

    The true error of a step is its difference from the motion with the same start, solved with 16 steps of
    Kahan and Li's composition of eighth order. It is the larger error of displacement and velocity, each relative to
    the largest value, like the estimates. ``true_displacement_error`` ignores the velocity, as does the estimate of
    Zienkiewicz and Xie. ``estimate`` and the errors are the largest of the period, after its first tenth;
    ``ratio`` is the estimate over the true error along the period, at the smallest step.
    """
    shape = (len(problems), len(schemes), len(estimators), len(steps_per_period))
    estimate, true, displacement = (np.full(shape, np.nan) for _ in range(3))
    ratio = np.full((*shape[:3], len(PHASES)), np.nan)
    for p, problem in enumerate(problems):
        period = coordinates.periods(problem)["exact"]
        for s, scheme in enumerate(schemes):
            progress(f"estimates for {scheme} on {problem}")
            for k, steps in enumerate(steps_per_period):
                errors = None
                for e, estimator in enumerate(estimators):
                    method, equations = schemes_by_name[scheme], problems_by_name[problem]
                    if estimators_by_name[estimator].refusal(method, equations) is not None:
                        continue
                    dt = period / steps
                    equal = Prescribed(np.array([dt]))
                    ds = run(problem, scheme, controller=equal, duration=period, estimator=estimator)
                    if errors is None or estimator == "step_doubling":
                        errors = _errors(problem, ds)
                    of_u, of_both = errors
                    late = ds.t.values[1:] > 0.1 * period
                    at = p, s, e, k
                    estimate[at] = ds.estimate.values[1:][late].max()
                    displacement[at], true[at] = of_u[late].max(), of_both[late].max()
                    if steps == max(steps_per_period):
                        middle = (ds.t.values[1:] - dt / 2) / period
                        ratio[at[:3]] = np.interp(PHASES, middle, ds.estimate.values[1:] / of_both)
    dims = ("problem", "scheme", "estimator", "steps_per_period")
    largest = "largest in a period after its first tenth"
    return xr.Dataset(
        {
            "estimate": (dims, estimate, {"long_name": f"estimate of the error of a step, {largest}", "units": "1"}),
            "true_error": (dims, true, {"long_name": f"true error of a step, {largest}", "units": "1"}),
            "true_displacement_error": (
                dims,
                displacement,
                {"long_name": f"true error of the displacement of a step, {largest}", "units": "1"},
            ),
            "ratio": (
                (*dims[:3], "phase"),
                ratio,
                {"long_name": "estimate over true error at the smallest step", "units": "1"},
            ),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.estimator_coordinates(estimators),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "phase": ("phase", PHASES, {"long_name": "part of the period", "units": "1"}),
        },
        attrs={"title": "Estimates of the error of a step and the true error"},
    )


def _errors(problem: str, ds: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """True errors of the displacement, and of displacement or velocity, of each step, over their largest values."""
    u, v, h = ds.u.values, ds.v.values, ds.step_size.values[1:]
    fine = run(problem, FINE, dt=h / FINE_STEPS, steps=FINE_STEPS, every=FINE_STEPS, u0=u[:-1], v0=v[:-1])
    of_u = np.abs(u[1:] - fine.u.values[:, -1]) / np.abs(u).max()
    of_v = np.abs(v[1:] - fine.v.values[:, -1]) / np.abs(v).max()
    return of_u, np.maximum(of_u, of_v)
