"""The step that each scheme needs on each problem, and the decisions that follow."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment
from study.declaration.options import PlainNames, Tolerances
from study.experiments import coordinates
from study.runs.needs import ATTRIBUTES, CODES, decisions, needs, of_problems
from study.scheme.codes import names_in_codes
from study.words import listed

#: Name of the oscillators under records among the problems.
RECORDS = "records"


def _options(configuration: Mapping) -> Options:
    return {"problems": list(configuration["runs"]["problems"]), "errors": configuration["runs"]["errors"]}


def of_records(spectrum: xr.Dataset) -> xr.Dataset:
    """The runs of oscillators under records in the form of ``runs/PROBLEM``.

    The error of the peak drift is the largest over all records, periods and ratios of elastic force to strength, which
    take the place of the starts. Costs are the means over them.
    """
    runs, each = spectrum.sortby("step_size"), ["record", "period", "reduction"]
    failed = runs.error.isnull().any(each)
    error = runs.error.max(each).where(~failed).expand_dims(quantity=["peak drift"], periods=[1.0])
    per_second = (runs.force_evaluations_per_step.mean(each) / runs.step_size).expand_dims(periods=[1.0])
    newton = (runs.iterations_per_step.mean(each) / runs.step_size).expand_dims(periods=[1.0])
    shortest = runs.period.min().item()
    step = runs.step_size.values
    tried = runs.error.notnull().any(each)
    costs = {"force_evaluations": per_second, "tangent_evaluations": newton, "factorisations": newton}
    ds = xr.Dataset(
        {
            **costs,
            "seconds": xr.full_like(per_second, np.nan),
            "error": error,
            "largest_error": error,
            "tried": tried,
            "uncertainty": ("quantity", [0.0]),
        }
    )
    return ds.rename(step_size="size").drop_vars("size").assign_coords(
        step_size=("size", step),
        steps_per_period=("size", shortest / step),
        omega_step=("size", 2 * np.pi / shortest * step),
        divides=("size", runs.commensurate.values),
        highest_frequency=2 * np.pi / shortest,
        time_scale=shortest,
        unknowns=1,
        duration=("periods", [1.0]),
        decided=1.0,
        starts=int(np.prod([runs.sizes[one] for one in each])),
        problem=RECORDS,
        problem_title=f"oscillators of {shortest:g} to {runs.period.max().item():g} s under records",
    )


@experiment(
    "needs",
    "decisions",
    section="runs",
    options=_options,
    reads=lambda options: [*(f"runs/{problem}" for problem in options["problems"]), "spectrum"],
)
def needs_and_decisions(problems: PlainNames, errors: Tolerances) -> tuple[xr.Dataset, xr.Dataset]:
    """Find what each scheme needs on each problem, and the cheapest scheme of each kind.

    ``needs`` is over (problem, scheme, quantity, allowed_error, condition), as :func:`study.runs.needs.of_problems`
    returns it; ``decisions`` is over (problem, quantity, allowed_error, kind, filter), as
    :func:`study.runs.needs.decisions` returns it.
    """
    parts = [needs(io.open_dataset(f"runs/{problem}"), errors) for problem in problems]
    needed = of_problems([*parts, needs(of_records(io.open_dataset("spectrum")), errors)])
    in_codes = {one.scheme for one in names_in_codes() if one.code.startswith(CODES)}
    names = needed.scheme.values.tolist()
    needed = needed.assign_coords(
        **coordinates.scheme_coordinates(names),
        in_codes=("scheme", [int(name in in_codes) for name in names], {"long_name": f"1 if {listed(CODES)} has it"}),
    )
    decided = decisions(needed)
    for ds, title in ((needed, "Step sizes that schemes need"), (decided, "Cheapest schemes for allowed errors")):
        for name, attributes in ATTRIBUTES.items():
            ds[name].attrs = attributes
        ds.attrs = {"title": title}
    return needed, decided
