"""Error at very small steps, where round-off dominates, with plain and with compensated summation."""

from collections.abc import Mapping
from fractions import Fraction

import numpy as np
import xarray as xr

from study import io
from study.analysis.comparison import flagged
from study.declaration.checks import no_multiple
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, RisingCounts, Schemes, Spring
from study.experiments import coordinates
from study.marching.run import sweep
from study.problem.named import problems as problems_by_name
from study.scheme.base import OneStep
from study.scheme.named import schemes as schemes_by_name
from study.scheme.wrapper.compensated import Compensated

#: Part of a period by which a run exceeds a whole number of periods, so that displacement and velocity both show a
#: delay.
PHASE = Fraction(1, 8)


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse step sizes that do not divide a run, and references that have no sample at the end of a run."""
    refused = no_multiple("steps_per_period", options["steps_per_period"], PHASE.denominator)
    if refused is None and all(n % PHASE.denominator for n in configuration["references"]["steps_per_period"]):
        return f"steps_per_period: references.steps_per_period must contain a multiple of {PHASE.denominator}."
    return refused


@experiment("round_off", reads=lambda options: [f"reference/{options['problem']}"], check=_check)
def round_off(problem: Spring, schemes: Schemes, steps_per_period: RisingCounts, periods: Count) -> xr.Dataset:
    """Measure the error of the schemes at very small steps, with plain and with compensated summation.

    The error at t = (``periods`` + 1/8) T is √(Δu² + Δv²), with Δu and Δv relative to the largest displacement and
    velocity. It has the shape (scheme, summation, steps_per_period). The compensated error is NaN for schemes that are
    not one-step schemes, because they do not sum increments.

    Raises
    ------
    ValueError
        If a number of steps per period is not a multiple of 8, or the reference lacks the phase 1/8.
    FileNotFoundError
        If the reference of the problem has not been made.
    """
    refused = no_multiple("steps_per_period", steps_per_period, PHASE.denominator)
    if refused is not None:
        raise ValueError(f"round_off.{refused}")
    reference = io.open_dataset(f"reference/{problem}")
    if float(PHASE) not in reference.phase:
        raise ValueError(f"the reference of '{problem}' lacks the phase {PHASE}; add 8 to references.steps_per_period.")
    at = reference.sel(t=reference.t[reference.phase == float(PHASE)].item())
    u, v, force = at.u.item(), at.v.item(), float(problems_by_name[problem].force(at.u.item()))
    exact_period = Fraction(reference.period.item()) + Fraction(reference.period_remainder.item())
    end = exact_period * (periods + PHASE)
    summation = ["plain", "compensated"]
    error = np.full((len(schemes), len(summation), len(steps_per_period)), np.nan)
    for s, name in enumerate(schemes):
        progress(f"round-off of {name} on {problem}")
        plain = schemes_by_name[name]
        for c, scheme in enumerate([plain, Compensated(scheme=plain)] if isinstance(plain, OneStep) else [plain]):
            for k, parts in enumerate(steps_per_period):
                steps = int(parts * (periods + PHASE))
                dt = float(end / steps)
                late = float(steps * Fraction(dt) - end)
                last = sweep(problem, scheme, dt=dt, steps=steps, every=steps).isel(t=-1)
                differences = (
                    (last.u.item() - (u + v * late)) / np.max(np.abs(reference.u)),
                    (last.v.item() - (v - force * late)) / np.max(np.abs(reference.v)),
                )
                error[s, c, k] = np.hypot(*differences)
    uncertainty = np.hypot(
        (reference.u_uncertainty / abs(reference.u).max()).item(),
        (reference.v_uncertainty / abs(reference.v).max()).item(),
    )
    dims = ("scheme", "summation", "steps_per_period")
    return xr.Dataset(
        {
            "end_error": (
                dims,
                error,
                {
                    "long_name": f"error of displacement and velocity after {periods} periods and an eighth, relative",
                    "units": "1",
                },
            ),
            "uncertainty": ((), uncertainty, {"long_name": "uncertainty of the reference, relative", "units": "1"}),
            "flagged": flagged(error, uncertainty, dims),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "summation": ("summation", summation, {"long_name": "how displacement and velocity are summed"}),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "periods": ((), periods, {"long_name": "whole periods of the runs", "units": "1"}),
        },
        attrs={"title": f"Round-off at small steps on the {problems_by_name[problem].title}", "problem": problem},
    )
