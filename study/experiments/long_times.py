"""Energy and phase errors of very long runs, and the growth of their round-off, in double and single precision."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Annotated, cast

import jax
import numpy as np
import xarray as xr
from annotated_types import Ge, Le

from study import datasets
from study.analysis.comparison import first_crossing
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import run
from study.pipeline import coordinates
from study.pipeline.command import progress
from study.pipeline.experiment import Options, experiment
from study.pipeline.options import Count, OneStepSchemes, RisingCounts, Spring
from study.problem.definition import Problem
from study.problem.named import problems as problems_by_name
from study.scheme.base import OneStep, Scheme
from study.scheme.compensated import Compensated
from study.scheme.named import schemes as schemes_by_name

#: Steps that a run of single precision counts, at most.
MOST_STEPS = 2**30 - 1
#: Arithmetics: whether each is in double precision, and whether it sums displacement and velocity with compensation.
#: The last one is the reference of the others.
ARITHMETIC = {
    "float32": (False, False),
    "float32_compensated": (False, True),
    "float64": (True, False),
    "float64_compensated": (True, True),
}
#: Kinds of step sizes, by the number of their bits. Single precision, of 24 bits, rounds the squares of the first kind
#: and represents those of the second exactly.
BITS = {"any": 24, "short": 12}
OBSERVED = ("energy_drift", "max_energy_error", "mean_energy_error", "oscillations")


def _step_sizes(step: float, runs: int) -> np.ndarray:
    """Step sizes close to ``step`` of each kind in ``BITS``, (kind, run); all arithmetics represent them exactly.

    Neighbours differ by one unit in the last place of a short step size. So the runs have independent round-off, and
    long ones end at different phases of the orbit.
    """
    sizes = []
    for bits in BITS.values():
        unit = 2.0 ** (np.floor(np.log2(step)) + 1 - bits)
        apart = 2 ** (bits - min(BITS.values()))
        sizes.append((np.round(step / unit) + apart * (np.arange(runs) - runs // 2)) * unit)
    return np.stack(sizes)


def _phase_error(ds: xr.Dataset, dt: np.ndarray, length: int, period: Fraction, crossing: Fraction) -> np.ndarray:
    """Delay at the end of each run in periods, (run,); NaN for runs without an upward crossing of zero.

    The mean period T̄ is taken from the start to the last upward crossing; the delay is (T̄/T − 1) times the length of
    the run in periods. It is computed in fractions: single precision cannot count the steps of long runs, and double
    precision leaves few digits to their phase.

    Parameters
    ----------
    period, crossing
        Exact period T, and the exact time of the first upward crossing over T.
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
    """Errors of the energy in percent and of the phase in periods, and the status, at the end of every run, (run,)."""
    with jax.enable_x64(double):
        ds = run(problem, scheme, dt=dt, steps=steps, observe=OBSERVED, on_failure="ignore")
    return {
        "energy_error": ds.energy_drift.values,
        "max_energy_error": ds.max_energy_error.values,
        "mean_energy_error": ds.mean_energy_error.values,
        "phase_error": _phase_error(ds, dt, length, *exact),
        "status": ds.status.values,
        "failed_at_step": ds.failed_at_step.values,
    }


def growth(periods: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exponent k of the law rms(values) ~ periods^k over the last two decades of lengths, and its standard error.

    k is the least squares slope of log rms over log periods. Its error is the jackknife estimate over runs, because
    the values of one run at several lengths share their round-off. Both are NaN if there are fewer than three lengths
    or two runs, if all values are zero, or if one is not finite.

    Parameters
    ----------
    periods, values
        Lengths in ascending order (periods,), and the values of the runs (..., periods, run).

    Returns
    -------
    exponent, error : numpy.ndarray
        Each of shape (...).
    """
    late = periods >= periods[-1] / 100
    runs = values.shape[-1]
    if late.sum() < 3 or runs < 2:
        nothing = np.full(values.shape[:-2], np.nan)
        return nothing, nothing
    x = np.log(periods[late]) - np.log(periods[late]).mean()
    squares = values[..., late, :] ** 2
    total = squares.sum(axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        # the slope is linear in the logarithms; it is taken over all runs, and over all but one
        whole, without = (x @ np.log(s) / (2 * x @ x) for s in (total, total - squares))
    error = np.sqrt((runs - 1) * without.var(axis=-1))
    known = np.isfinite(whole[..., 0] + error)
    return np.where(known, whole[..., 0], np.nan), np.where(known, error, np.nan)


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    runs = len(options["schemes"]) * len(ARITHMETIC) * len(BITS) * options["runs"]
    return runs * options["steps_per_period"] * sum(options["periods"])


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse lengths that are too few for a law of growth, and runs that are too long."""
    lengths = options["periods"]
    if options["steps_per_period"] * lengths[-1] > MOST_STEPS:
        return f"periods: a run of {lengths[-1]:,} has more than the {MOST_STEPS:,} steps that single precision counts."
    if sum(length >= lengths[-1] / 100 for length in lengths) < 3:
        return "periods: a law of growth takes three lengths within the last two decades."
    return None


@experiment(
    "long_times",
    split=lambda options: {scheme: {**options, "schemes": [scheme]} for scheme in options["schemes"]},
    along="scheme",
    reads=lambda options: [f"reference/{options['problem']}"],
    check=_check,
    steps=_number_of_steps,
)
def long_times(
    problem: Spring,
    schemes: OneStepSchemes,
    steps_per_period: Count,
    periods: RisingCounts,
    runs: Annotated[int, Ge(2), Le(1000)],
) -> xr.Dataset:
    """Measure the errors of energy and phase of very long runs, their round-off, and the laws of its growth.

    Every length is run in every arithmetic with ``runs`` step sizes close to T/N, with T the exact period and
    N = ``steps_per_period``, once with 24 bits and once with 12. The round-off of a run is its difference from the run
    with the same step size in compensated double precision.

    Parameters
    ----------
    schemes
        One-step schemes, because only their sums can be compensated.
    periods
        Lengths of the runs, ascending.

    Returns
    -------
    xarray.Dataset
        What :func:`summary` returns.

    Raises
    ------
    ValueError
        If the exact motion does not cross zero, where oscillations are counted.
    TypeError
        If a scheme is not a one-step scheme.
    FileNotFoundError
        If the reference of the problem has not been made.
    """
    definition, reference = problems_by_name[problem], datasets.open(f"reference/{problem}")
    period = Fraction(reference.period.item()) + Fraction(reference.period_remainder.item())
    exact = period, Fraction(first_crossing(reference, 0.0))
    dt, lengths = _step_sizes(float(period / steps_per_period), runs), np.asarray(periods)
    shape = len(schemes), len(ARITHMETIC), len(lengths), *dt.shape
    observed: dict[str, np.ndarray] = {}
    for s, name in enumerate(schemes):
        progress(f"long times of {name} on {problem}")
        for a, (double, compensated) in enumerate(ARITHMETIC.values()):
            plain = schemes_by_name[name]
            scheme = Compensated(cast(OneStep, plain)) if compensated else plain
            for k, length in enumerate(lengths.tolist()):
                steps = length * steps_per_period
                measured = _measured(definition, scheme, dt.ravel(), length, steps, double, *exact)
                for variable, values in measured.items():
                    observed.setdefault(variable, np.empty(shape))[s, a, k] = values.reshape(dt.shape)
    return (
        summary({name: np.moveaxis(values, -2, 2) for name, values in observed.items()}, lengths)
        .assign_coords(coordinates.scheme_coordinates(schemes))
        .assign_coords(
            problem=((), problem, {"long_name": "problem"}),
            steps_per_period=((), steps_per_period, {"long_name": "steps per exact period, about", "units": "1"}),
            runs=((), runs, {"long_name": "runs with each kind of step size", "units": "1"}),
            spread_of_steps=((), np.ptp(dt) / dt.mean(), {"long_name": "spread of the step sizes", "units": "1"}),
        )
        .assign_attrs(title=f"Long times on the {definition.title}")
    )


def summary(observed: dict[str, np.ndarray], lengths: np.ndarray) -> xr.Dataset:
    """Means, root mean squares and laws of growth of the errors over runs, as a dataset.

    Its errors have the shape (scheme, arithmetic, step, periods), exponents and their errors
    (quantity, scheme, arithmetic, step). They are NaN if one of the runs failed.

    Parameters
    ----------
    observed
        Errors, status and failing step of every run, each (scheme, arithmetic, step, periods, run).
    lengths
        Lengths of the runs in periods, (periods,).
    """
    along, mean, rms = ("scheme", "arithmetic", "step", "periods"), {}, {}
    observed = dict(observed)
    for kind, of in (("energy", "mean_energy_error"), ("phase", "phase_error")):
        round_off = observed[of] - observed[of][:, -1:]
        round_off[:, -1] = np.nan  # the reference itself
        observed[f"{kind}_round_off"] = round_off
    for name in ("energy_error", "mean_energy_error", "phase_error", "energy_round_off", "phase_round_off"):
        mean[name], rms[name] = observed[name].mean(axis=-1), np.sqrt(np.mean(observed[name] ** 2, axis=-1))
    growing = [name for name in rms if name != "energy_error"]
    exponent, error = growth(lengths, np.stack([observed[name] for name in growing]))
    failed_at = np.where(observed["failed_at_step"] < 0, np.inf, observed["failed_at_step"])
    earliest = np.argmin(failed_at, axis=-1)[..., None]
    status, step = (
        np.take_along_axis(observed[name], earliest, axis=-1)[..., 0].astype(int)
        for name in ("status", "failed_at_step")
    )

    def described(values, long_name, units):
        return along, values, {"long_name": long_name, "units": units}

    less = "less that in compensated double precision"
    slope = "slope of log rms quantity over log periods, least squares over the last two decades"
    return xr.Dataset(
        {
            "energy_error": described(mean["energy_error"], "signed energy error at the end, mean of runs", "percent"),
            "max_energy_error": described(observed["max_energy_error"].max(axis=-1), "largest energy error", "percent"),
            "mean_energy_error": described(
                mean["mean_energy_error"], "signed energy error, mean over the run and of runs", "percent"
            ),
            "phase_error": described(mean["phase_error"], "delay at the end in periods, mean of runs", "1"),
            "energy_round_off": described(rms["energy_round_off"], f"mean energy error {less}, rms of runs", "percent"),
            "energy_bias": described(mean["energy_round_off"], f"mean energy error {less}, mean of runs", "percent"),
            "phase_round_off": described(rms["phase_round_off"], f"delay in periods {less}, rms of runs", "1"),
            "phase_bias": described(mean["phase_round_off"], f"delay in periods {less}, mean of runs", "1"),
            "exponent": (("quantity", *along[:-1]), exponent, {"long_name": slope, "units": "1"}),
            "exponent_error": (
                ("quantity", *along[:-1]),
                error,
                {"long_name": "standard error of the exponent, by the jackknife over runs", "units": "1"},
            ),
            "status": (
                along,
                status.astype(np.int32),
                STATUS_ATTRIBUTES | {"long_name": "how the first run to fail ended"},
            ),
            "failed_at_step": (along, step, FAILED_AT_STEP_ATTRIBUTES),
        },
        coords={
            "arithmetic": ("arithmetic", list(ARITHMETIC), {"long_name": "precision, and how is summed"}),
            "step": ("step", list(BITS), {"long_name": "step sizes of 24 bits, or short ones of 12"}),
            "periods": ("periods", lengths, {"long_name": "length of the run in exact periods", "units": "1"}),
            "quantity": ("quantity", growing, {"long_name": "what grows"}),
        },
    )
