"""Tables 1 and 2 of Xie (1996) with steps controlled by the estimator of 1991."""

from functools import partial

import numpy as np
import xarray as xr

from study.control.named import estimators as estimators_by_name
from study.declaration.experiment import experiment, progress, references
from study.declaration.options import Controllers, Count, Counts, OneStepSchemes, Springs
from study.experiments import coordinates
from study.marching.run import run
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name

#: Exponents of ten of the smallest and the largest tolerance tried first. Number of tolerances tried at once.
WIDEST, LANES = (-9.0, 0.5), 64

ESTIMATOR = "zienkiewicz_xie"


@experiment("controlled_1996", reads=references)
def controlled_1996(
    problems: Springs, schemes: OneStepSchemes, controllers: Controllers, steps_per_period: Counts, periods: Count
) -> xr.Dataset:
    """Find the largest energy error of controlled runs that take about as many steps as runs with equal steps of T/N.

    The steps are controlled by the estimator of 1991. 64 tolerances are tried, and then 64 near the best tolerances.
    The result is from the completed run whose number of steps per period is nearest to N = ``steps_per_period``.
    ``max_energy_error`` is eq. (17), of the shape (problem, controller, steps_per_period, scheme). It is
    NaN if the number of steps of every run differs from the number of equal steps by more than a tenth. It is also NaN
    for schemes to which the estimator does not apply.
    """
    shape = (len(problems), len(controllers), len(steps_per_period), len(schemes))
    error, taken, tolerance = (np.full(shape, np.nan) for _ in range(3))
    wanted = periods * np.array(steps_per_period)
    for p, problem in enumerate(problems):
        duration = periods * coordinates.periods(problem)["exact"]
        for s, scheme in enumerate(schemes):
            if estimators_by_name[ESTIMATOR].refusal(schemes_by_name[scheme], problems_by_name[problem]):
                continue
            for c, controller in enumerate(controllers):
                progress(f"{scheme} on {problem}, {controller}")
                marched = partial(
                    run,
                    problem,
                    scheme,
                    duration=duration,
                    estimator=ESTIMATOR,
                    controller=controller,
                    steps=int(1.2 * wanted.max()),
                    observe=["max_energy_error"],
                    on_failure="ignore",
                )
                tried = np.logspace(*WIDEST, LANES)
                coarse = marched(tolerance=tried)
                near = _between(tried, coarse.steps.values, wanted)
                runs = xr.concat([coarse, marched(tolerance=near)], "lane")
                completed = runs.isel(lane=runs.status.values == 0)
                for k, number in enumerate(wanted):
                    lane = completed.isel(lane=np.argmin(abs(completed.steps.values - number)))
                    if abs(lane.steps.item() - number) <= number / 10:
                        at = p, c, k, s
                        error[at], taken[at], tolerance[at] = lane.max_energy_error, lane.steps, lane.tolerance
    dims = ("problem", "controller", "steps_per_period", "scheme")
    return xr.Dataset(
        {
            "max_energy_error": (
                dims,
                error,
                {
                    "long_name": f"largest relative error of the energy over {periods} periods, eq. (17) of Xie (1996)",
                    "units": "1",
                },
            ),
            "steps": (dims, taken, {"long_name": "number of steps", "units": "1"}),
            "tolerance": (dims, tolerance, {"long_name": "tolerance that gives this number of steps", "units": "1"}),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            "controller": ("controller", list(controllers), {"long_name": "controller of the step"}),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            **coordinates.scheme_coordinates(schemes),
        },
        attrs={"title": "Tables 1 and 2 of 1996 with steps controlled by the estimator of 1991", "periods": periods},
    )


def _between(tolerances: np.ndarray, steps: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """``LANES`` new tolerances, around the tolerances whose numbers of steps are nearest to the wanted numbers."""
    ratio = tolerances[1] / tolerances[0]
    nearest = [tolerances[np.argmin(abs(steps - number))] for number in wanted]
    each = -(-LANES // len(nearest))
    around = np.concatenate([tolerance * np.logspace(-1, 1, each, base=ratio) for tolerance in nearest])
    return around[:LANES]
