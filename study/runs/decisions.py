"""The step that each scheme needs on each problem, and the decisions that follow."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment
from study.declaration.options import PlainNames, Tolerances
from study.experiments import coordinates
from study.runs.needs import ATTRIBUTES, CODES, COSTS, decisions, needs, of_problems
from study.scheme.codes import names_in_codes
from study.words import listed

#: Name of the oscillators under records among the problems.
RECORDS = "records"


def _options(configuration: Mapping) -> Options:
    return {"problems": list(configuration["runs"]["problems"]), "errors": configuration["runs"]["errors"]}


def of_records(spectrum: xr.Dataset) -> xr.Dataset:
    """The runs of oscillators under records in the form of ``runs/PROBLEM``.

    The error of the peak drift is the largest over all records, periods and ratios of elastic force to strength, which
    take the place of the starts. Counts are the means over them.
    """
    each, shortest = ["record", "period", "reduction"], spectrum.period.min().item()
    error = spectrum.error.max(each, skipna=False).expand_dims(quantity=["peak drift"])
    runs = _in_form(spectrum.mean(each), error, spectrum.step_size.values, shortest, duration=1.0)
    return runs.assign_coords(
        divides=("size", spectrum.commensurate.values),
        highest_frequency=2 * np.pi / shortest,
        omega_step=("size", 2 * np.pi / shortest * spectrum.step_size.values),
        unknowns=1,
        starts=int(np.prod([spectrum.sizes[one] for one in each])),
        problem=RECORDS,
        problem_title=f"oscillators of {shortest:g} to {spectrum.period.max().item():g} s under records",
    )


def of_structure(structure: xr.Dataset) -> xr.Dataset:
    """The runs of one structure in the form of ``runs/PROBLEM``; errors are those at the samples of its reference."""
    errors = {
        "displacement": structure.displacement_error,
        "velocity": structure.velocity_error,
        "acceleration": structure.acceleration_error,
        "energy": structure.max_energy_imbalance,
    }
    error = xr.concat(errors.values(), "quantity", coords="minimal", compat="override")
    error = error.assign_coords(quantity=list(errors)).reset_coords(drop=True)
    scale, counts = structure.period.item(), structure.steps_per_period.values
    runs = _in_form(structure, error, scale / counts, scale, structure.periods.item())
    return runs.assign(
        uncertainty=("quantity", [structure.displacement_uncertainty.item(), 0.0, 0.0, 0.0])
    ).assign_coords(
        divides=("size", np.ones(len(counts), np.int8)),
        omega_step=("size", structure.highest_frequency.item() * scale / counts),
        **{name: structure[name].item() for name in ("highest_frequency", "unknowns", "problem", "problem_title")},
        starts=1,
    )


def _in_form(
    per_step: xr.Dataset, error: xr.DataArray, step_sizes: np.ndarray, scale: float, duration: float
) -> xr.Dataset:
    """Errors over (scheme, size, quantity) and counts per step as runs over one duration, in time scales."""
    (along,) = (str(one) for one in error.dims if one not in ("scheme", "quantity"))
    error = error.rename({along: "size"}).drop_vars(along, errors="ignore")
    steps = xr.DataArray(duration * scale / step_sizes, dims="size")
    costs = {}
    for name in COSTS:
        per = per_step.get(f"{name}_per_step", error.isel(quantity=0, drop=True) * np.nan)
        renamed = per.rename({along: "size"}) if along in per.dims else per
        costs[name] = renamed.drop_vars(along, errors="ignore").reset_coords(drop=True) * steps
    ds = xr.Dataset({**costs, "error": error, "largest_error": error * np.nan})
    ds = ds.reset_coords(drop=True).expand_dims(periods=[duration])
    # a scheme that refuses the problem has no error at any step; a run that failed has none at its step
    ran = ds.error.notnull().any(("quantity", "periods", "size"))
    return (
        ds.assign(tried=xr.broadcast(ran, ds.error.isel(quantity=0, periods=0, drop=True))[0].astype(np.int8))
        .assign(uncertainty=("quantity", np.zeros(ds.sizes["quantity"])))
        .assign_coords(
            step_size=("size", step_sizes),
            steps_per_period=("size", scale / step_sizes),
            duration=("periods", [duration * scale]),
            time_scale=scale,
            decided=duration,
        )
    )


@experiment(
    "needs",
    "decisions",
    section="runs",
    options=_options,
    reads=lambda options: [*(f"runs/{problem}" for problem in options["problems"]), "spectrum", "structures"],
)
def needs_and_decisions(problems: PlainNames, errors: Tolerances) -> tuple[xr.Dataset, xr.Dataset]:
    """Find what each scheme needs on each problem, and the cheapest scheme of each kind.

    ``needs`` is over (problem, scheme, quantity, allowed_error, condition), as :func:`study.runs.needs.of_problems`
    returns it; ``decisions`` is over (problem, quantity, allowed_error, kind, filter), as
    :func:`study.runs.needs.decisions` returns it.
    """
    parts = [needs(io.open_dataset(f"runs/{problem}"), errors) for problem in problems]
    structures = io.open_dataset("structures")
    parts += [needs(of_structure(structures.sel(problem=one)), errors) for one in structures.problem.values]
    parts += [needs(of_records(io.open_dataset("spectrum")), errors)]
    needed = of_problems(parts)
    in_codes = {one.scheme for one in names_in_codes() if one.code.startswith(CODES)}
    names = needed.scheme.values.tolist()
    needed = needed.assign_coords(
        **coordinates.scheme_coordinates(names),
        in_codes=(
            "scheme",
            [int(name in in_codes) for name in names],
            {"long_name": f"1 if {listed(CODES)} has it", "units": "1"},
        ),
    )
    decided = decisions(needed)
    for ds, title in ((needed, "Step sizes that schemes need"), (decided, "Cheapest schemes for allowed errors")):
        for name in ATTRIBUTES.keys() & ds.variables.keys():
            ds[name].attrs = ATTRIBUTES[str(name)]
        ds.attrs = {"title": title}
    # without the lengths of strings in the files that were read
    return needed.drop_encoding(), decided.drop_encoding()
