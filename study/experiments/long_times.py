"""Round-off of very long runs, which is their difference from runs with compensated sums, and its growth."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Annotated, cast

import numpy as np
import xarray as xr
from annotated_types import Ge, Le

from study import io
from study.analysis.comparison import first_crossing
from study.analysis.orders import observed_order
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, OneStepSchemes, RisingCounts, Spring
from study.experiments import coordinates
from study.marching.run import sweep
from study.problem.named import problems as problems_by_name
from study.scheme.base import OneStep
from study.scheme.named import schemes as schemes_by_name
from study.scheme.wrapper.compensated import Compensated

#: Relative distance of neighbouring step sizes, at which long runs end at different phases of the orbit.
APART = 2.0**-11
#: Ratio of the longest runs to the shortest from which the growth follows.
LATE = 100
OBSERVED = ("mean_energy_error", "oscillations")


def _delay(ds: xr.Dataset, dt: np.ndarray, length: int, period: Fraction, crossing: Fraction) -> np.ndarray:
    """Delay at the end of each run in periods, (run,); NaN for runs without an upward crossing of zero.

    The mean period T̄ is taken from the start to the last upward crossing; the delay is (T̄/T − 1) times the length of
    the run in periods. The delay is computed in fractions, because the round-off of T̄/T − 1 would be multiplied
    by the length of the run.

    Parameters
    ----------
    period, crossing
        Exact period T, and the exact time of the first upward crossing of zero, divided by T.
    """
    late = np.full(len(dt), np.nan)
    for lane in np.flatnonzero(ds.crossings.values > 0):
        step, part, count = (
            Fraction(ds[name].values[lane].item()) for name in ("last_crossing_step", "last_crossing_part", "crossings")
        )
        mean_period = (step + part) * Fraction(dt[lane]) / (crossing + count - 1)
        late[lane] = float((mean_period / period - 1) * length)
    return late


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse too few lengths for a law of growth, and motions that do not cross zero."""
    lengths = options["periods"]
    if sum(length >= lengths[-1] / LATE for length in lengths) < 3:
        return "periods: a law of growth needs three lengths within the last two decades."
    problem = problems_by_name[options["problem"]]
    if not problem.stored_energy(0.0) < problem.stored_energy(problem.u0):
        return f"problem: the motion of '{options['problem']}' does not cross zero, where oscillations are counted."
    return None


@experiment(
    "long_times",
    split=lambda options: {name: {**options, "schemes": [name]} for name in options["schemes"]},
    along="scheme",
    reads=lambda options: [f"reference/{options['problem']}"],
    check=_check,
)
def long_times(
    problem: Spring,
    schemes: OneStepSchemes,
    steps_per_period: Count,
    periods: RisingCounts,
    runs: Annotated[int, Ge(2), Le(1000)],
) -> xr.Dataset:
    """Measure the round-off of mean energy and phase of very long runs, and how it grows with their length.

    The round-off of a run is its difference from the run with the same step size in compensated double precision. Every
    length is run with ``runs`` step sizes close to T/N, with the exact period T and N = ``steps_per_period``.

    Parameters
    ----------
    schemes
        One-step schemes, because only their sums can be compensated.
    periods
        Lengths of the runs in periods, ascending.

    Returns
    -------
    xarray.Dataset
        Root mean squares over the runs, (scheme, periods), and the exponents of their growth over the last two decades
        of lengths, (scheme,).

    Raises
    ------
    FileNotFoundError
        If the reference of the problem has not been made.
    """
    definition, reference = problems_by_name[problem], io.open_dataset(f"reference/{problem}")
    period = Fraction(reference.period.item()) + Fraction(reference.period_remainder.item())
    exact = period, Fraction(first_crossing(reference, 0.0))
    dt = float(period / steps_per_period) * (1 + APART * (np.arange(runs) - runs // 2))
    size = {name: np.empty((len(schemes), len(periods))) for name in ("energy", "phase")}
    for s, name in enumerate(schemes):
        plain = schemes_by_name[name]
        progress(f"long runs of {name} on {problem}")
        for k, length in enumerate(periods):
            errors = []
            for scheme in (plain, Compensated(scheme=cast(OneStep, plain))):
                ds = sweep(definition, scheme, dt=dt, steps=length * steps_per_period, observe=OBSERVED)
                errors.append((ds.mean_energy_error.values, _delay(ds, dt, length, *exact)))
            for variable, ordinary, compensated in zip(size, *errors, strict=True):
                size[variable][s, k] = np.sqrt(np.mean((ordinary - compensated) ** 2))
    return xr.Dataset(
        {
            f"{name}_round_off": (
                ("scheme", "periods"),
                values,
                {"long_name": f"{words} less the value in compensated double precision, rms of runs", "units": "1"},
            )
            for (name, values), words in zip(size.items(), ("mean energy error", "delay in periods"), strict=True)
        }
        | {
            f"{name}_exponent": (
                "scheme",
                [-_slope(periods, round_off) for round_off in values],
                {"long_name": f"exponent of the growth of {name}_round_off over two decades", "units": "1"},
            )
            for name, values in size.items()
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
            "steps_per_period": ((), steps_per_period, {"long_name": "approximate steps per period", "units": "1"}),
            "runs": ((), runs, {"long_name": "number of runs with different step sizes", "units": "1"}),
        },
        attrs={"title": f"Round-off over long times on the {definition.title}", "problem": problem},
    )


def _slope(periods: Sequence[int], values: np.ndarray) -> float:
    lengths = np.array(periods, float)
    return observed_order(lengths, values, lengths >= lengths[-1] / LATE)
