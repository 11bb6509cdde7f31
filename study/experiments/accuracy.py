"""Accuracy of the schemes: errors of trajectory, phase, period, amplitude and energy against exact solutions."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study import io
from study.analysis.comparison import against, flagged, uncertainties
from study.analysis.duration import step_exponent
from study.declaration.checks import unlisted
from study.declaration.experiment import Options, experiment, progress, references
from study.declaration.options import Count, RisingCounts, Schemes, Springs, Tolerance, section
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.observer.diagnostics import Evaluations, NewtonIterations
from study.observer.energy import EnergyDrift, MaxEnergyError
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name
from study.sizes import least_number


@section
class _Growth(TypedDict):
    """Steps and lengths of long runs, and the lengths in periods between which steps are extrapolated for an error."""

    steps_per_period: RisingCounts
    periods: RisingCounts
    known: Count
    extrapolated: Count
    allowed_error: Tolerance


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse numbers of steps per period whose phases the references do not contain, and lengths that are not run."""
    sampled, growth = configuration["references"]["steps_per_period"], options["growth"]
    if growth["known"] not in options["periods"] or growth["known"] > growth["extrapolated"]:
        return f"growth.known: {growth['known']} must be one of the periods, and at most growth.extrapolated."
    return unlisted(
        "steps_per_period", options["steps_per_period"], "references.steps_per_period", sampled
    ) or unlisted("growth.steps_per_period", growth["steps_per_period"], "references.steps_per_period", sampled)


@experiment(
    "accuracy",
    "error_growth",
    split=lambda options: {problem: {**options, "problems": [problem]} for problem in options["problems"]},
    along="problem",
    reads=references,
    check=_check,
)
def accuracy(
    problems: Springs, schemes: Schemes, steps_per_period: RisingCounts, periods: RisingCounts, growth: _Growth
) -> tuple[xr.Dataset, xr.Dataset]:
    """Measure the errors of every scheme against the exact solution, by step size and length of the run.

    :mod:`study.analysis.comparison` defines the measures. The step size is Δt = T/N, with T the exact period and
    N the number of steps per period. Each measure has the shape (problem, scheme, steps_per_period, periods).

    Parameters
    ----------
    growth
        ``steps_per_period`` and ``periods`` of the dataset ``error_growth``; the lengths ``known`` and
        ``extrapolated`` in periods, and the allowed ``error`` of the displacement.

    Returns
    -------
    accuracy, error_growth : xarray.Dataset
        The same measures of fewer steps and longer runs in the second dataset. Also in the second, of shape (problem,
        scheme): ``fewest_steps_per_period``, the fewest steps per period that keep the error over ``known`` periods, as
        all finer steps do; and ``extrapolated_steps_per_period``, the steps per period over ``extrapolated`` periods by
        :mod:`study.analysis.duration`, at the next number of which the reference has the phases, with its
        ``extrapolated_error``.

    Raises
    ------
    FileNotFoundError
        If the reference of a problem has not been made.
    ValueError
        If a reference does not contain the phases of a number of steps per period.
    """
    finest = steps_per_period[-1]
    measured = _measured(problems, schemes, steps_per_period, periods, finest)
    longer = _measured(problems, schemes, growth["steps_per_period"], growth["periods"], finest)
    kept = measured.displacement_error.sel(periods=growth["known"]) <= growth["allowed_error"]
    needed = least_number(kept, "steps_per_period").transpose("problem", "scheme").values
    exponents = np.array([step_exponent(schemes_by_name[n].order, schemes_by_name[n].order_of_loss) for n in schemes])
    wanted = needed * (growth["extrapolated"] / growth["known"]) ** exponents
    sampled = np.array(steps_per_period)
    run, error = np.full((2, *needed.shape), np.nan)
    for p, s in np.argwhere(wanted <= finest):
        run[p, s] = sampled[sampled >= wanted[p, s] * (1 - 1e-9)][0]
        extrapolated = _measured([problems[p]], [schemes[s]], [int(run[p, s])], [growth["extrapolated"]], finest)
        error[p, s] = extrapolated.displacement_error.item()
    along = ("problem", "scheme")
    allowed = f"{100 * growth['allowed_error']:g} % of the displacement"
    longer = longer.assign(
        fewest_steps_per_period=(
            along,
            needed,
            {"long_name": f"fewest steps tried from rest that keep {allowed}, as all finer ones do", "units": "1"},
        ),
        extrapolated_steps_per_period=(along, run, {"long_name": "extrapolated steps per period", "units": "1"}),
        extrapolated_error=(
            along,
            error,
            {"long_name": "largest error of the displacement with the extrapolated steps, relative", "units": "1"},
        ),
    ).assign_coords(
        exponent=("scheme", exponents, {"long_name": "a in: step size proportional to periods^(-a)", "units": "1"}),
        known=((), growth["known"], {"long_name": "periods of the runs that are extrapolated", "units": "1"}),
        extrapolated=((), growth["extrapolated"], {"long_name": "periods that are extrapolated to", "units": "1"}),
        allowed_error=((), growth["allowed_error"], {"long_name": "allowed error of the displacement", "units": "1"}),
    )
    return (
        measured.assign_attrs(title="Accuracy of the schemes against the exact solution"),
        longer.assign_attrs(title="Growth of the errors of the schemes with the length of the run"),
    )


def _measured(
    problems: Sequence[str],
    schemes: Sequence[str],
    steps_per_period: Sequence[int],
    periods: Sequence[int],
    finest: int,
) -> xr.Dataset:
    """The measures of error; one compilation of a scheme serves all steps up to ``finest``."""
    motions = [(problems_by_name[problem], io.open_dataset(f"reference/{problem}")) for problem in problems]
    dims = ("problem", "scheme", "steps_per_period", "periods")
    shape = (len(motions), len(schemes), len(steps_per_period), len(periods))
    measured: dict[str, np.ndarray] = {}
    attributes: dict[str, dict] = {"status": STATUS_ATTRIBUTES, "failed_at_step": FAILED_AT_STEP_ATTRIBUTES}
    for p, (problem, reference) in enumerate(motions):
        compared = [against(reference, steps, finest) for steps in steps_per_period]
        for s, scheme in enumerate(schemes):
            progress(f"accuracy of {scheme} on {problem.title}")
            for k, (steps, (dt, observers)) in enumerate(zip(steps_per_period, compared, strict=True)):
                observe = [*observers, MaxEnergyError(), EnergyDrift(), NewtonIterations(), Evaluations()]
                for n, length in enumerate(periods):
                    ds = sweep(problem, scheme, dt=dt, steps=steps * length, observe=observe)
                    for name, value in ds.data_vars.items():
                        measured.setdefault(str(name), np.empty(shape, value.dtype))[p, s, k, n] = value
                        attributes[str(name)] = value.attrs
    known = [[uncertainties(reference, length) for length in periods] for _, reference in motions]
    measures = list(known[0][0])
    uncertainty = np.array([[[by_measure[measure] for by_measure in row] for row in known] for measure in measures])
    values = np.array([measured[measure] for measure in measures])
    return xr.Dataset(
        {name: (dims, values, attributes[name]) for name, values in measured.items()}
        | {
            "uncertainty": (
                ("measure", "problem", "periods"),
                uncertainty,
                {"long_name": "uncertainty of the reference in the units of the measure", "units": "1"},
            ),
            "flagged": flagged(values, uncertainty[:, :, None, None, :], ("measure", *dims)),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
            "measure": ("measure", measures, {"long_name": "measure of error, a variable of this dataset"}),
            "measure_title": (
                "measure",
                [attributes[measure]["long_name"] for measure in measures],
                {"long_name": "description of the measure"},
            ),
        },
    )
