"""Energy and phase errors of every very long run, in double and single precision."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Annotated, cast

import jax
import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study import io
from study.analysis.comparison import first_crossing
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, OneStepSchemes, PlainNames, RisingCounts, Schemes, Spring, section
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.problem.named import problems as problems_by_name
from study.scheme.base import OneStep, Scheme
from study.scheme.named import schemes as schemes_by_name
from study.scheme.wrapper.compensated import Compensated

#: Largest number of steps that a run in single precision can count.
MOST_STEPS = 2**30 - 1
#: Arithmetics: whether each uses double precision, and whether it sums displacement and velocity with compensation.
#: The last arithmetic is the reference of the others.
ARITHMETIC = {
    "float32": (False, False),
    "float32_compensated": (False, True),
    "float64": (True, False),
    "float64_compensated": (True, True),
}
#: Kinds of step sizes, each with the number of its bits. Single precision, of 24 bits, rounds the squares of the first
#: kind and represents the squares of the second kind exactly.
BITS = {"any": 24, "short": 12}
#: Largest number of steps of a job with all arithmetics of a scheme. Beyond it each arithmetic is a separate job, of a
#: minute or more.
MOST_STEPS_OF_JOB = 10**9
OBSERVED = ("energy_drift", "max_energy_error", "mean_energy_error", "oscillations")


def _step_sizes(step: float, runs: int) -> np.ndarray:
    """Step sizes close to ``step`` of each kind in ``BITS``, (kind, run); all arithmetics represent them exactly.

    Neighbouring step sizes differ by one unit in the last place of a number of 12 bits. So the runs have independent
    round-off, and long runs end at different phases of the orbit.
    """
    sizes = []
    for bits in BITS.values():
        unit = 2.0 ** (np.floor(np.log2(step)) + 1 - bits)
        apart = 2 ** (bits - min(BITS.values()))
        sizes.append((np.round(step / unit) + apart * (np.arange(runs) - runs // 2)) * unit)
    return np.stack(sizes)


#: Type and attributes of each variable that is measured on a run.
_VARIABLES = {
    "energy_error": (np.float64, {"long_name": "signed energy error at the end", "units": "1"}),
    "max_energy_error": (np.float64, {"long_name": "largest energy error, eq. (17) of Xie (1996)", "units": "1"}),
    "mean_energy_error": (np.float64, {"long_name": "signed energy error, mean over the run", "units": "1"}),
    "phase_error": (np.float64, {"long_name": "delay at the end in periods", "units": "1"}),
    "status": (np.int32, STATUS_ATTRIBUTES),
    "failed_at_step": (np.int64, FAILED_AT_STEP_ATTRIBUTES),
}


def _phase_error(ds: xr.Dataset, dt: np.ndarray, length: int, period: Fraction, crossing: Fraction) -> np.ndarray:
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


def _measured(problem: Problem, scheme: Scheme, dt: np.ndarray, length: int, steps: int, double: bool, *exact) -> dict:
    """Errors of energy and phase, status and failing step of every run, by name as in ``_VARIABLES``, each (run,)."""
    with jax.enable_x64(double):
        ds = sweep(problem, scheme, dt=dt, steps=steps, observe=OBSERVED)
    return {
        "energy_error": ds.energy_drift.values,
        "max_energy_error": ds.max_energy_error.values,
        "mean_energy_error": ds.mean_energy_error.values,
        "phase_error": _phase_error(ds, dt, length, *exact),
        "status": ds.status.values,
        "failed_at_step": ds.failed_at_step.values,
    }


def _steps_of_arithmetic(options: Options) -> float:
    """Number of steps of all runs of one scheme in one arithmetic."""
    return len(BITS) * options["runs"] * options["steps_per_period"] * sum(options["periods"])


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each scheme or, if the runs are long, for each scheme and arithmetic."""
    if len(ARITHMETIC) * _steps_of_arithmetic(options) <= MOST_STEPS_OF_JOB:
        return {name: {**options, "schemes": [name], "arithmetics": list(ARITHMETIC)} for name in options["schemes"]}
    return {
        f"{name}_{arithmetic}": {**options, "schemes": [name], "arithmetics": [arithmetic]}
        for name in options["schemes"]
        for arithmetic in ARITHMETIC
    }


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse too few lengths for a law of growth, runs too long to be counted, and motions that do not cross zero."""
    lengths = options["periods"]
    if options["steps_per_period"] * lengths[-1] > MOST_STEPS:
        return f"periods: a run of {lengths[-1]:,} has more than the {MOST_STEPS:,} steps that single precision counts."
    if sum(length >= lengths[-1] / 100 for length in lengths) < 3:
        return "periods: a law of growth needs three lengths within the last two decades."
    problem = problems_by_name[options["problem"]]
    if not problem.stored_energy(0.0) < problem.stored_energy(problem.u0):
        return f"problem: the motion of '{options['problem']}' does not cross zero, where oscillations are counted."
    return None


@section
class _LongTimes(TypedDict):
    problem: Spring
    schemes: OneStepSchemes
    steps_per_period: Count
    periods: RisingCounts
    runs: Annotated[int, Ge(2), Le(1000)]


@experiment(
    "long_runs",
    section="long_times",
    model=_LongTimes,
    split=_jobs,
    along="scheme,arithmetic",
    reads=lambda options: [f"reference/{options['problem']}"],
    check=_check,
)
def long_runs(
    problem: Spring,
    schemes: Schemes,
    steps_per_period: int,
    periods: Sequence[int],
    runs: int,
    arithmetics: PlainNames,
) -> xr.Dataset:
    """Measure the errors of energy and phase at the end of each very long run.

    Every length is run in every arithmetic with ``runs`` step sizes close to T/N, with T the exact period and
    N = ``steps_per_period``, once with step sizes of 24 bits and once with step sizes of 12 bits.

    Parameters
    ----------
    schemes
        One-step schemes, because only their sums can be compensated.
    periods
        Lengths of the runs in periods, ascending.
    arithmetics
        Keys of ``ARITHMETIC``.

    Returns
    -------
    xarray.Dataset
        Errors and status, each (scheme, arithmetic, step, periods, run).

    Raises
    ------
    ValueError
        If the exact motion does not cross zero, where oscillations are counted.
    TypeError
        If a scheme is not a one-step scheme, but an arithmetic compensates its sums.
    FileNotFoundError
        If the reference of the problem has not been made.
    """
    definition, reference = problems_by_name[problem], io.open_dataset(f"reference/{problem}")
    period = Fraction(reference.period.item()) + Fraction(reference.period_remainder.item())
    exact = period, Fraction(first_crossing(reference, 0.0))
    dt = _step_sizes(float(period / steps_per_period), runs)
    shape = len(schemes), len(arithmetics), len(BITS), len(periods), runs
    observed = {name: np.empty(shape) for name in _VARIABLES}
    for s, name in enumerate(schemes):
        for a, arithmetic in enumerate(arithmetics):
            progress(f"long runs of {name} on {problem}, {arithmetic}")
            double, compensated = ARITHMETIC[arithmetic]
            plain = schemes_by_name[name]
            scheme = Compensated(scheme=cast(OneStep, plain)) if compensated else plain
            for k, length in enumerate(periods):
                steps = length * steps_per_period
                measured = _measured(definition, scheme, dt.ravel(), length, steps, double, *exact)
                for variable, values in measured.items():
                    observed[variable][s, a, :, k] = values.reshape(dt.shape)
    return xr.Dataset(
        {
            name: (("scheme", "arithmetic", "step", "periods", "run"), observed[name].astype(kind), attributes)
            for name, (kind, attributes) in _VARIABLES.items()
        }
        | {"step_size": (("step", "run"), dt, {"long_name": "step size", "units": "s"})},
        coords={
            **coordinates.scheme_coordinates(schemes),
            "arithmetic": ("arithmetic", list(arithmetics), {"long_name": "precision, and kind of summation"}),
            "step": ("step", list(BITS), {"long_name": "step sizes of 24 bits, or short ones of 12"}),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
            "problem": ((), problem, {"long_name": "problem"}),
            "steps_per_period": ((), steps_per_period, {"long_name": "approximate steps per period", "units": "1"}),
        },
        attrs={"title": f"Long times on the {definition.title}, one by one"},
    )
