"""The order that schemes keep if the force has kinks or memory, or the load has kinks."""

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from study import io
from study.analysis.orders import observed_order
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, Kinked, RisingCounts, Schemes
from study.experiments import coordinates
from study.io import flags
from study.marching.result import STATUSES_OR_NOT_RUN
from study.marching.run import sweep
from study.mechanics.frequencies import highest_frequency
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name

#: Limits of the errors that count towards the order: smallest multiple of the uncertainty of the reference, smallest
#: and largest error relative to the motion, and smallest number of steps per period.
ABOVE, SMALLEST, LARGEST, RESOLVED = 100.0, 1e-11, 0.1, 50

#: Largest number of periods of a run.
LONGEST = 30


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each problem."""
    return {problem: options | {"problems": [problem]} for problem in options["problems"]}


def _check(options: Options, configuration: Mapping) -> str | None:
    if options["periods"] > LONGEST:
        return f"periods must be at most {LONGEST}; the references are certain up to there."
    for steps in options["steps_per_period"]:
        if steps % options["samples_per_period"]:
            return f"samples_per_period, {options['samples_per_period']}, does not divide {steps} steps per period."
    return None


def _order(steps: np.ndarray, error: np.ndarray, uncertainty: float) -> float:
    """Observed order over the errors that count; NaN if fewer than three do."""
    counts = (steps >= RESOLVED) & (error > max(ABOVE * uncertainty, SMALLEST)) & (error < LARGEST)
    return observed_order(steps, error, counts)


def _compared(known: xr.Dataset, scheme: str, steps: int, samples: int) -> tuple[xr.Dataset, float]:
    """A run with a number of steps in a period, and its error relative to its size at a number of samples in a period.

    ``known`` are samples of the exact motion, of which ``samples`` is a divisor.
    """
    per_period = np.rint(1 / known.sample.values[0]).astype(int)
    scale, periods, each = known.time_scale.item(), known.sizes["sample"] // per_period, per_period // samples
    ds = sweep(
        problems_by_name[known.problem.item()],
        scheme,
        dt=scale / steps,
        steps=periods * steps,
        observe=["trajectory", "energy_balance", "newton_iterations", "effort"],
        every=steps // samples,
    )
    return ds, np.abs(ds.u.values[1:] - known.u.values[each - 1 :: each]).max() / np.abs(known.u.values).max()


@experiment("kinks", split=_jobs, along="problem", reads=lambda options: ["reference/inelastic"], check=_check)
def kinks(
    problems: Kinked,
    schemes: Schemes,
    steps_per_period: RisingCounts,
    steps_per_spacing: RisingCounts,
    periods: Count,
    samples_per_period: Count,
) -> xr.Dataset:
    """Measure error and order of schemes on oscillators with yielding, memory or contact, and under a ground motion.

    The error is max |u − u_ref| / max |u_ref| over the samples, (problem, scheme, steps_per_period). It is NaN where a
    run fails, or where a scheme refuses the problem, for instance a scheme that takes its force from a potential if the
    force dissipates. The observed order is the slope of the logarithm of the error against the logarithm of the step
    size. Under a record, ``dividing_sampled_error`` and ``dividing_order`` are those with ``steps_per_spacing`` steps
    between two samples of the record, over the samples of the reference at which all these steps end.
    """
    reference = io.open_dataset("reference/inelastic")
    shape = (len(problems), len(schemes), len(steps_per_period))
    error, imbalance, iterations, forces = (np.full(shape, np.nan) for _ in range(4))
    dividing_error = np.full((*shape[:2], len(steps_per_spacing)), np.nan)
    highest, spacing = np.empty(len(problems)), np.full(len(problems), np.nan)
    order, dividing_order = np.full(shape[:2], np.nan), np.full(shape[:2], np.nan)
    status = np.full(shape, STATUSES_OR_NOT_RUN.index("not_run"), np.int8)
    for p, problem in enumerate(problems):
        known, definition = reference.sel(problem=problem), problems_by_name[problem]
        size, scale = np.abs(known.u.values).max(), known.time_scale.item()
        uncertainty = known.u_uncertainty.item() / size
        if definition.ground is not None and definition.ground.dt < scale:
            spacing[p] = definition.ground.dt
        highest[p] = highest_frequency(definition, [definition.u0, *known.u.values])
        for s, scheme in enumerate(schemes):
            progress(f"order of {scheme} on {problem}")
            if schemes_by_name[scheme].refusal(definition):
                continue

            for k, steps in enumerate(steps_per_period):
                ds, error[p, s, k] = _compared(known, scheme, steps, samples_per_period)
                status[p, s, k] = ds.status
                imbalance[p, s, k] = ds.max_energy_imbalance
                iterations[p, s, k] = ds.newton_iterations / (periods * steps)
                forces[p, s, k] = ds.force_evaluations / (periods * steps)
            order[p, s] = _order(np.array(steps_per_period), error[p, s], uncertainty)
            if np.isfinite(spacing[p]):
                dividing = np.rint(scale / spacing[p] * np.array(steps_per_spacing)).astype(int)
                samples = math.gcd(samples_per_period, *dividing.tolist())  # steps of all sizes end there
                dividing_error[p, s] = [_compared(known, scheme, steps, samples)[1] for steps in dividing.tolist()]
                dividing_order[p, s] = _order(dividing, dividing_error[p, s], uncertainty)
    dims, dividing_dims = ("problem", "scheme", "steps_per_period"), ("problem", "scheme", "steps_per_spacing")
    error_attributes = {"long_name": "largest error of the displacement at the samples over its size", "units": "1"}
    dividing_steps = "with steps that divide the spacing of a record; NaN without a record"
    return xr.Dataset(
        {
            "sampled_error": (dims, error, error_attributes),
            "dividing_sampled_error": (
                dividing_dims,
                dividing_error,
                error_attributes | {"long_name": f"{error_attributes['long_name']}, {dividing_steps}"},
            ),
            "max_energy_imbalance": (
                dims,
                imbalance,
                {"long_name": "largest error of the balance of energies", "units": "1"},
            ),
            "status": (dims, status, flags("how the run ended", STATUSES_OR_NOT_RUN, np.int8)),
            "newton_iterations_per_step": (dims, iterations, {"long_name": "Newton iterations per step", "units": "1"}),
            "force_evaluations_per_step": (dims, forces, {"long_name": "forces evaluated per step", "units": "1"}),
            "observed_order": (dims[:2], order, {"long_name": "observed order of the errors", "units": "1"}),
            "dividing_order": (
                dims[:2],
                dividing_order,
                {"long_name": f"observed order {dividing_steps}", "units": "1"},
            ),
            "time_scale": (
                "problem",
                reference.time_scale.sel(problem=problems).values,
                {"long_name": "time by which steps are counted here", "units": "s"},
            ),
            "spacing": (
                "problem",
                spacing,
                {"long_name": "time between the samples of a record, NaN if there is none", "units": "s"},
            ),
            "highest_frequency": (
                "problem",
                highest,
                {"long_name": "highest circular frequency of small motions along the reference", "units": "s-1"},
            ),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "steps_per_spacing": (
                "steps_per_spacing",
                steps_per_spacing,
                {"long_name": "steps between two samples of a record", "units": "1"},
            ),
        },
        attrs={"title": "Order of schemes with yielding, memory and contact, and under a record"},
    )
