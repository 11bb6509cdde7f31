"""Where refinement ends: the error at very small steps, and what compensated summation buys."""

from fractions import Fraction

import numpy as np
import xarray as xr

from study import datasets
from study.analysis.comparison import flagged
from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Count, Counts, Schemes, Spring
from study.problem.named import problems
from study.scheme.base import OneStep
from study.scheme.compensated import Compensated
from study.scheme.named import schemes as registry

#: The run ends this part of a period after a whole number of them, where displacement and velocity both tell phases.
PHASE = Fraction(1, 8)


def _phases(o, c) -> str | None:
    odd = [parts for parts in o["steps_per_period"] if (parts * PHASE).denominator > 1]
    if odd:
        return f"steps_per_period: {odd[0]} is no multiple of {PHASE.denominator}."
    known = c["references"]["steps_per_period"]
    if not any(steps % PHASE.denominator == 0 for steps in known):
        return f"references.steps_per_period has no multiple of {PHASE.denominator}, which round_off needs."
    return None


@experiment(
    "round_off",
    reads=lambda o: [f"reference/{o['problem']}"],
    check=_phases,
    steps=lambda o, c: 2 * len(o["schemes"]) * sum(o["steps_per_period"]) * (o["periods"] + 1),
)
def round_off(problem: Spring, schemes: Schemes, steps_per_period: Counts, periods: Count) -> xr.Dataset:
    """Error at the end of ``periods`` periods and an eighth, plain and compensated, by steps per period.

    A multi-step scheme keeps displacements and adds nothing to them; its compensated error is NaN.

    Raises
    ------
    ValueError
        If a number of steps per period does not divide the end of the run, or the reference lacks its phase.
    """
    reference = datasets.open(f"reference/{problem}")
    odd = [parts for parts in steps_per_period if (parts * PHASE).denominator > 1]
    if odd:
        raise ValueError(f"round_off.steps_per_period: {odd[0]} is no multiple of {PHASE.denominator}.")
    if float(PHASE) not in reference.phase:
        raise ValueError(f"the reference of '{problem}' lacks the phase {PHASE}; add 8 to references.steps_per_period.")
    at = reference.sel(t=reference.t[reference.phase == float(PHASE)].item())
    u, v, force = at.u.item(), at.v.item(), float(problems[problem].force(at.u.item()))
    exact_period = Fraction(reference.period.item()) + Fraction(reference.period_remainder.item())
    end = exact_period * (periods + PHASE)
    summation = ["plain", "compensated"]
    error = np.full((len(schemes), len(summation), len(steps_per_period)), np.nan)
    for s, name in enumerate(schemes):
        progress(f"round-off of {name} on {problem}")
        plain = registry[name]
        for c, scheme in enumerate([plain, Compensated(plain)] if isinstance(plain, OneStep) else [plain]):
            for k, parts in enumerate(steps_per_period):
                steps = int(parts * (periods + PHASE))
                dt = float(end / steps)
                late = float(steps * Fraction(dt) - end)
                last = run(problem, scheme, dt=dt, steps=steps, every=steps).isel(t=-1)
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
            "error": (
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
            **labels.scheme_coordinates(schemes),
            "summation": ("summation", summation, {"long_name": "how displacement and velocity are summed"}),
            **labels.steps_per_period_coordinate(steps_per_period),
        },
        attrs={"title": f"Round-off at small steps on the {problems[problem].title}", "problem": problem},
    )
