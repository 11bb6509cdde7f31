"""Reference motions of the oscillators with kinks and memory, each with its uncertainty."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from reference import diffrax, exact, piecewise, sundials
from reference.solution import Solution, Times
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Kinked
from study.declaration.samples import KINKED
from study.mechanics.definition import Problem
from study.problem.inelastic import PERIOD
from study.problem.named import approximate_periods
from study.problem.named import problems as problems_by_name

#: Relative tolerance of diffrax and CVODE.
RTOL = 1e-13

#: Numbers of instants in the shortest period at which :mod:`reference.piecewise` seeks events. The motion is solved
#: with both numbers. The difference of the two motions gives the uncertainty.
PLACES = (200, 331)


def _in_pieces(problem, t: Times) -> tuple[str, Solution, Solution]:
    solution, check = (piecewise.trajectory(problem, t, places) for places in PLACES)
    return "exact pieces", solution, check


def from_kink_to_kink(problem: Problem, t: Times) -> tuple[str, Solution, Solution]:
    """Name of the route, and the solutions by diffrax and by CVODE, whose steps end at every kink of load and force."""
    declared = np.asarray(getattr(problem.load, "kinks", []), float)
    load_kinks = declared[(declared > 0) & (declared < t[-1])]
    force_kinks = sundials.kinks(problem, t[-1], load_kinks)
    stops = np.union1d(np.union1d(t, load_kinks), force_kinks)
    first = diffrax.trajectory(problem, stops, RTOL)
    second = sundials.trajectory(problem, stops, RTOL, kinks=load_kinks, restarts=force_kinks)
    indices = np.searchsorted(stops, t)
    first, second = (part._replace(u=part.u[indices], v=part.v[indices]) for part in (first, second))
    return "diffrax Dopri8 from kink to kink", first, second


#: Function that solves each problem; problems without an entry are smooth.
_WAYS = {
    "yielding": _in_pieces,
    "bouncing": _in_pieces,
    "hysteretic": from_kink_to_kink,
    "shaken": from_kink_to_kink,
    "pulse": from_kink_to_kink,
}


#: Sections of the configuration whose runs are compared with these motions.
_READERS = ("kinks", "control_cost", "solver_cost")


def _options(configuration: Mapping) -> Options:
    section = configuration["kinks"]
    problems = [problem for reader in _READERS for problem in configuration[reader]["problems"] if problem in KINKED]
    lengths = {key: section[key] for key in ("periods", "samples_per_period")}
    return {"problems": list(dict.fromkeys(problems))} | lengths


@experiment("reference/inelastic", section="kinks", options=_options)
def inelastic(problems: Kinked, periods: int, samples_per_period: int) -> xr.Dataset:
    """Compute the motion of oscillators with kinks and memory.

    The motions with yielding and with bouncing are solved exactly from event to event, twice: the second solution seeks
    events at more instants. Smooth hysteresis and the motions under a record and a pulse are solved once by diffrax and
    once by CVODE, from one kink of force or load to the next. The uncertainty is the largest difference between the
    displacements of the two solutions, but at least the spacing of doubles at the largest displacement. A smooth
    spring, solved by the Taylor method, is included for comparison. Its uncertainty follows from four integrations.
    """
    u, uncertainty, route, scale = [], [], [], []
    for name in problems:
        progress(f"motion of {name}")
        # not the period of the motion itself: a run with a whole number of steps in it may be right by accident
        problem, period = problems_by_name[name], approximate_periods.get(name, PERIOD)
        t = np.arange(1, periods * samples_per_period + 1) * period / samples_per_period
        if name in _WAYS:
            way, first, check = _WAYS[name](problem, t)
            u.append(first.u)
            uncertainty.append(max(np.abs(first.u - check.u).max(), np.spacing(np.abs(first.u).max())))
        else:
            solution = exact.trajectory(problem, t.tolist())
            way = "Taylor polynomials of many digits"
            u.append(np.asarray(solution.u, float))
            uncertainty.append(max(float(solution.u_certified), np.spacing(np.abs(u[-1]).max())))
        route.append(way)
        scale.append(period)
    return xr.Dataset(
        {
            "u": (("problem", "sample"), np.stack(u), {"long_name": "displacement", "units": "1"}),
            "u_uncertainty": ("problem", uncertainty, {"long_name": "uncertainty of the displacement", "units": "1"}),
            "route": ("problem", route, {"long_name": "how the motion was found"}),
            "time_scale": ("problem", scale, {"long_name": "time by which steps are counted", "units": "s"}),
        },
        coords={
            "problem": ("problem", list(problems), {"long_name": "problem"}),
            "sample": (
                "sample",
                np.arange(1, periods * samples_per_period + 1) / samples_per_period,
                {"long_name": "time over the time scale", "units": "1"},
            ),
        },
        attrs={"title": "Motion of oscillators whose force has kinks or memory"},
    )
