"""Steps per period that a scheme needs to keep the energy at all amplitudes, by length of the run."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from study import io
from study.declaration.checks import unlisted
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Counts, RisingCounts, Schemes, Springs
from study.experiments import coordinates
from study.marching.run import sweep
from study.observer.outcome import LEVELS, Excursions, OutcomeObserver
from study.problem.named import problems as problems_by_name


def _needed(problem: str, scheme: str, lanes: xr.Dataset, candidates: np.ndarray, lengths: Sequence[int]) -> np.ndarray:
    """Fewest steps per period that keep the energy within each level, (levels, lengths).

    The number is the smallest candidate for which all candidates from it on keep the energy within the level at all
    amplitudes. It is NaN if the largest candidate does not.
    """
    definition = problems_by_name[problem]
    observer = Excursions(OutcomeObserver.of(definition).rest)
    u0, period = lanes.u0.values, lanes.period.values
    needed = np.full((len(LEVELS), len(lengths)), np.nan)
    undecided = np.ones(needed.shape, bool)
    # from the finest step on; once a level is exceeded at a length, coarser steps cannot change its result
    for steps in sorted(candidates, reverse=True):
        for k, length in enumerate(lengths):
            if not undecided[:, k].any():
                continue
            # each length has a separate run, because a run that fails has no errors of its earlier steps
            runs = sweep(
                definition,
                scheme,
                dt=period / steps,
                steps=int(steps * length),
                u0=u0,
                observe=[observer],
            )
            kept = np.array([np.isinf(runs[name]).all() for name in observer.variables])
            undecided[:, k:] &= kept[:, None]  # if a shorter run exceeds the level, so does a longer one
            needed[undecided[:, k], k] = steps
    return needed


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse problems whose amplitudes are not computed."""
    return unlisted("problems", options["problems"], "atlas.problems", configuration["atlas"]["problems"])


@experiment(
    "stability/robustness",
    section="robustness",
    split=lambda options: {scheme: {**options, "schemes": [scheme]} for scheme in options["schemes"]},
    along="scheme",
    reads=lambda options: ["reference/amplitudes"],
    check=_check,
)
def robustness(problems: Springs, schemes: Schemes, steps_per_period: Counts, periods: RisingCounts) -> xr.Dataset:
    """Find the fewest steps per period that keep the energy within 1, 5 and 10 percent at all amplitudes.

    The amplitudes come from ``results/reference/amplitudes``. The period T in Δt = T/N is the exact period at each
    amplitude. Errors of the energy are relative to the height of the energy above rest.

    Parameters
    ----------
    steps_per_period
        Candidates of N.
    periods
        Lengths of the runs in periods T, ascending.

    Returns
    -------
    xarray.Dataset
        ``fewest_steps_per_period`` has the shape (problem, scheme, allowed_error, periods).

    Raises
    ------
    FileNotFoundError
        If ``results/reference/amplitudes.nc`` has not been made.
    """
    exact = io.open_dataset("reference/amplitudes")
    needed = np.empty((len(problems), len(schemes), len(LEVELS), len(periods)))
    for p, problem in enumerate(problems):
        lanes = exact.sel(problem=problem)
        for s, scheme in enumerate(schemes):
            progress(f"steps that {scheme} needs on {problem}")
            needed[p, s] = _needed(problem, scheme, lanes, np.asarray(steps_per_period), sorted(periods))
    return xr.Dataset(
        {
            "fewest_steps_per_period": (
                ("problem", "scheme", "allowed_error", "periods"),
                needed,
                {
                    "long_name": "fewest steps per period that keep the energy within the level at all amplitudes of "
                    f"reference/amplitudes, as all larger numbers tried do; NaN if {max(steps_per_period)} do not",
                    "units": "1",
                },
            ),
            "most_steps_per_period": (
                (),
                max(steps_per_period),
                {"long_name": "most steps per period tried", "units": "1"},
            ),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            "allowed_error": (
                "allowed_error",
                list(LEVELS),
                {"long_name": "error of the energy over its height", "units": "1"},
            ),
            "periods": ("periods", sorted(periods), {"long_name": "length of the run in periods", "units": "1"}),
        },
        attrs={"title": "Steps per period that every scheme needs at all amplitudes"},
    )
