"""The step that each scheme needs on each problem, and the decisions that follow."""

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import FallingErrors, PlainNames
from study.experiments import coordinates
from study.marching.timing import Timed
from study.problem.named import problems as problems_by_name
from study.runs.needs import ATTRIBUTES, CODES, decisions, exponents, joined_needs, needs
from study.scheme.codes import names_in_codes
from study.scheme.named import schemes as schemes_by_name
from study.words import listed

#: Number of rounds in which the schemes of a problem are timed, one after the other, and the least time in s that runs
#: of a step size take in a round. Other work on the machine slows most of the short runs, so the shortest time counts.
ROUNDS, ENOUGH = 5, 0.03


def _options(configuration: Mapping) -> Options:
    return {
        "problems": [*configuration["runs"]["problems"], "records"],
        "allowed_errors": configuration["runs"]["allowed_errors"],
    }


def computing_times(needed: xr.Dataset) -> xr.DataArray:
    """Computing time of a run with each step size, NaN for problems with another ``cost``."""
    times = needed.seconds.copy(deep=True)
    for problem in needed.problem.values[needed.cost.values == "seconds"].tolist():
        step_sizes = needed.step_size.sel(problem=problem)
        duration = step_sizes.duration.item()
        names = step_sizes.dropna("scheme", how="all").scheme.values.tolist()
        # nothing is timed while the programs are compiled
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            timer = partial(Timed, problems_by_name[problem], reductions=())
            timed = pool.map(timer, [schemes_by_name[name] for name in names])
            runs = dict(zip(names, timed, strict=True))
        for scheme, run in [*runs.items()] * ROUNDS:
            progress(f"time of {scheme} on {problem}")
            sizes, place = step_sizes.sel(scheme=scheme), {"problem": problem, "scheme": scheme}
            for dt in np.unique(sizes.values[np.isfinite(sizes.values)]).tolist():
                steps = max(int(duration / dt * (1 + 1e-9)), 1)
                shortest = np.fmin(times.loc[place], run.shortest(dt, steps, ENOUGH))
                times.loc[place] = times.loc[place].where(sizes != dt, shortest)
    return times


@experiment(
    "needs",
    "decisions",
    section="runs",
    timed=True,
    options=_options,
    reads=lambda options: [f"runs/{problem}" for problem in options["problems"]],
)
def needs_and_decisions(problems: PlainNames, allowed_errors: FallingErrors) -> tuple[xr.Dataset, xr.Dataset]:
    """Find what each scheme needs on each problem, and the cheapest scheme of each kind.

    ``needs`` is over (problem, scheme, quantity, allowed_error, condition), as :func:`study.runs.needs.joined_needs`
    returns it, with the computing times of the problems whose ``cost`` is ``seconds``, and the ``exponent`` with which
    the step of a free vibration falls over more periods; ``decisions`` is over (problem, quantity, allowed_error, kind,
    filter), as :func:`study.runs.needs.decisions` returns it.
    """
    needed = joined_needs([needs(io.open_dataset(f"runs/{problem}"), allowed_errors) for problem in problems])
    needed["seconds"] = computing_times(needed)
    in_codes = {name.scheme for name in names_in_codes() if name.code.startswith(CODES)}
    names = needed.scheme.values.tolist()
    needed = needed.assign_coords(
        **coordinates.scheme_coordinates(names),
        in_codes=(
            "scheme",
            [int(name in in_codes) for name in names],
            {"long_name": f"1 if {listed(CODES)} has it", "units": "1"},
        ),
    )
    needed["exponent"] = exponents(needed)
    decided = decisions(needed)
    for ds, title in ((needed, "Step sizes that schemes need"), (decided, "Cheapest schemes for allowed errors")):
        for name in ATTRIBUTES.keys() & ds.variables.keys():
            ds[name].attrs = ATTRIBUTES[str(name)]
        ds.attrs = {"title": title}
    # without the lengths of strings in the files that were read
    return needed.drop_encoding(), decided.drop_encoding()
