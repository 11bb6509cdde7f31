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
    """The runs of oscillators under records in the form of ``runs/PROBLEM``, over the duration of the records.

    The error of the peak drift is the largest over all records, periods and ratios of elastic force to strength, which
    take the place of the starts. Counts are the means over them.
    """
    each, scale, dt = ["record", "period", "reduction"], spectrum.period.min().item(), spectrum.step_size.values
    duration = spectrum.duration.item() / scale
    error = spectrum.error.max(each, skipna=False).expand_dims(quantity=["peak drift"])
    steps = spectrum.duration / spectrum.step_size
    ds = xr.Dataset({name: spectrum[f"{name}_per_step"].mean(each) * steps for name in COSTS})
    ds = ds.assign(error=error, largest_error=error * np.nan).reset_coords(drop=True).expand_dims(periods=[duration])
    # a scheme that refuses the oscillators has no error at any step; a run that failed has none at its step
    ran = error.notnull().any(["quantity", "step_size"]).expand_dims(step_size=dt).reset_coords(drop=True)
    ds = (
        ds.assign(tried=ran.astype(np.int8), uncertainty=("quantity", [0.0])).rename(step_size="size").drop_vars("size")
    )
    highest = 2 * np.pi / scale
    return ds.assign_coords(
        step_size=("size", dt),
        steps_per_period=("size", scale / dt),
        omega_step=("size", highest * dt),
        divides=("size", spectrum.commensurate.values),
        duration=("periods", [duration * scale]),
        time_scale=scale,
        decided=duration,
        highest_frequency=highest,
        unknowns=1,
        starts=int(np.prod([spectrum.sizes[one] for one in each])),
        free_vibration=0,
        problem=RECORDS,
        problem_title=f"oscillators of {scale:g} to {spectrum.period.max().item():g} s under records",
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
