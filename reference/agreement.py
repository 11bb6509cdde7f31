"""What a tolerance delivers: the true global error of every route, over one, ten and a hundred periods."""

from collections.abc import Callable, Sequence
from functools import partial

import heyoka as hy
import jax
import numpy as np
import xarray as xr

from reference import diffrax, exact, sundials, taylor
from reference.solution import RouteFailed, Solution, StepLimit
from study.command import main, progress
from study.problem import Problem
from study.problems import printed_periods, problems

#: Route: its trajectory and its period, each a function of problem, times or estimate, and tolerance.
ROUTES: dict[str, tuple[Callable, Callable]] = {
    "cvode_adams": (partial(sundials.trajectory, method="Adams"), partial(sundials.period, method="Adams")),
    "cvode_bdf": (partial(sundials.trajectory, method="BDF"), partial(sundials.period, method="BDF")),
    "dopri8": (partial(diffrax.trajectory, method="Dopri8"), partial(diffrax.period, method="Dopri8")),
    "tsit5": (partial(diffrax.trajectory, method="Tsit5"), partial(diffrax.period, method="Tsit5")),
    # implicit and of order five: at tight tolerances its steps would take minutes
    "kvaerno5": (
        partial(diffrax.trajectory, method="Kvaerno5", max_steps=15_000),
        partial(diffrax.period, method="Kvaerno5"),
    ),
    "heyoka": (taylor.trajectory, taylor.period),
}
#: How often in a period the routes are held against the truth; not only where displacement hides phase errors.
SAMPLES = 16
#: A number of periods is over where the last of them ends.
WINDOWS = (1, 10, 100)


class _Folded:
    """The truth at double precision times over many periods, folded into one."""

    def __init__(self, problem: Problem, estimate: float, periods: int):
        exact_period, _ = exact.period(problem, estimate)
        parts = [exact_period * k / SAMPLES for k in range(SAMPLES)]
        once = exact.trajectory(problem, parts)
        whole = [exact_period * n / SAMPLES for n in range(1, periods * SAMPLES + 1)]
        self.period = float(exact_period)
        self.t = np.array([float(time) for time in whole])
        # a double holds a time to one part in 1e16; what it lacks moves the truth along by a little
        lack = np.array([float(hy.real(stored, 192) - time) for stored, time in zip(self.t, whole, strict=True)])
        at = np.arange(1, len(whole) + 1) % SAMPLES
        u, v = once.u[at], once.v[at]
        self.u = u + v * lack
        self.v = v - np.asarray(jax.vmap(problem.force)(u)) * lack


def _errors(problem: Problem, truth: _Folded, solution: Solution) -> dict[str, np.ndarray]:
    """Largest errors up to the end of every window, relative to the largest size of the quantity."""
    energy = np.asarray(jax.vmap(problem.energy)(solution.u, solution.v))
    initial = float(problem.energy(np.asarray(problem.u0), np.asarray(problem.v0)))
    histories = {
        "u_error": np.abs(solution.u - truth.u) / np.max(np.abs(truth.u)),
        "v_error": np.abs(solution.v - truth.v) / np.max(np.abs(truth.v)),
        "energy_error": np.abs(energy / initial - 1),
    }
    errors = {name: np.array([np.max(h[: w * SAMPLES]) for w in WINDOWS]) for name, h in histories.items()}
    # at whole periods the velocity is zero, and with it the first order effect of an error in phase
    at_periods = histories["u_error"][SAMPLES - 1 :: SAMPLES]
    return errors | {"u_error_at_periods": np.array([np.max(at_periods[:w]) for w in WINDOWS])}


def agreement(problem: str, tolerances: Sequence[float]) -> xr.Dataset:
    """True error of every route at every tolerance, with what it took over the longest window.

    The tolerances must fall. A route that did not finish has NaN, and status 1.
    """
    definition, estimate = problems[problem], printed_periods[problem]
    shape = (len(ROUTES), len(tolerances))
    windowed = {
        name: np.full((*shape, len(WINDOWS)), np.nan)
        for name in ("u_error", "v_error", "energy_error", "u_error_at_periods")
    }
    single = {name: np.full(shape, np.nan) for name in ("period_error", "evaluations", "run_time")}
    status = np.ones(shape, np.int32)
    truth = _Folded(definition, estimate, max(WINDOWS))
    for r, (route, (trajectory, period)) in enumerate(ROUTES.items()):
        progress(f"{route} on {problem}")
        for k, tolerance in enumerate(tolerances):
            at = r, k
            try:
                solution = trajectory(definition, truth.t, tolerance)
                found = period(definition, estimate, tolerance)
            except StepLimit as failure:
                progress(str(failure))
                break  # a tighter tolerance would take more steps
            except RouteFailed as failure:
                progress(str(failure))
                continue
            status[at] = 0
            single["period_error"][at] = abs(found / truth.period - 1)
            single["evaluations"][at], single["run_time"][at] = solution.evaluations, solution.seconds
            for quantity, values in _errors(definition, truth, solution).items():
                windowed[quantity][at] = values
    dims = ("route", "tolerance")
    described = {
        "u_error": "largest error of the displacement, relative to its largest size",
        "v_error": "largest error of the velocity, relative to its largest size",
        "energy_error": "largest relative error of the energy",
        "u_error_at_periods": "largest error of the displacement at whole periods, relative to its largest size",
        "period_error": "relative error of the period",
        "evaluations": f"evaluations of the right side over {max(WINDOWS)} periods",
        "run_time": f"run time over {max(WINDOWS)} periods, without compilation",
    }
    variables = {
        name: ((*dims, "periods"), values, {"long_name": described[name], "units": "1"})
        for name, values in windowed.items()
    } | {
        name: (dims, values, {"long_name": described[name], "units": "s" if name == "run_time" else "1"})
        for name, values in single.items()
    }
    attributes = {"long_name": "whether the route finished", "flag_values": np.arange(2, dtype=np.int32)}
    return xr.Dataset(
        {**variables, "status": (dims, status, {**attributes, "flag_meanings": "finished gave_up"})},
        coords={
            "problem": ((), problem, {"long_name": "problem"}),
            "route": ("route", list(ROUTES), {"long_name": "solver that was asked"}),
            "tolerance": ("tolerance", list(tolerances), {"long_name": "relative tolerance asked for", "units": "1"}),
            "periods": (
                "periods",
                list(WINDOWS),
                {"long_name": "periods over which the error is the largest", "units": "1"},
            ),
        },
        attrs={"title": "What a tolerance delivers: true errors of the reference solvers"},
    ).expand_dims("problem")


if __name__ == "__main__":
    main(agreement)
