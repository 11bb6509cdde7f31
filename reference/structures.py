"""References of the structures: CVODE and diffrax at a tight tolerance, and how far they differ as the error bar."""

import numpy as np
import xarray as xr

from reference import diffrax, sundials
from study.command import main, progress
from study.problems import periods as time_scales
from study.problems import problems

#: A stiff mode takes ten steps of a method of order eight in each of its own short periods.
MAX_STEPS = 10_000_000


def _spread(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Largest difference of any unknown, by time."""
    return np.abs(one - other).reshape(len(one), -1).max(axis=1)


def structure(problem: str, periods: float, samples_per_period: int, rtol: float) -> xr.Dataset:
    """Displacement and velocity of every unknown by diffrax's Dopri8, with the difference of CVODE's Adams from it.

    Two solvers that share neither method nor code nor control of the step agree as far as both are right.
    """
    definition, scale = problems[problem], time_scales[problem]
    progress(f"reference of {problem}: diffrax and CVODE")
    t = np.arange(1, round(periods * samples_per_period) + 1) * scale / samples_per_period
    taken = diffrax.trajectory(definition, t, rtol, "Dopri8", MAX_STEPS)
    witness = sundials.trajectory(definition, t, rtol, "Adams", MAX_STEPS)
    unknown = ("unknown",) if np.ndim(definition.u0) else ()
    return xr.Dataset(
        {
            "u": (("t", *unknown), taken.u, {"long_name": "displacement", "units": "1"}),
            "v": (("t", *unknown), taken.v, {"long_name": "velocity", "units": "s-1"}),
            "u_uncertainty": (
                "t",
                _spread(taken.u, witness.u),
                {"long_name": "largest difference of the displacement between the solvers", "units": "1"},
            ),
            "v_uncertainty": (
                "t",
                _spread(taken.v, witness.v),
                {"long_name": "largest difference of the velocity between the solvers", "units": "s-1"},
            ),
            "period": ((), scale, {"long_name": "time by which steps are counted", "units": "s"}),
        },
        coords={"t": ("t", t, {"long_name": "elapsed time", "units": "s"})},
        attrs={
            "title": f"Reference solution of the {definition.title}",
            "problem": problem,
            "samples_per_period": samples_per_period,
            "rtol": rtol,
        },
    )


if __name__ == "__main__":
    main(structure)
