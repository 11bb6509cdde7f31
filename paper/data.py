"""Parts of datasets that several products read."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from paper.published import PROBLEMS, SCHEMES, STEPS
from study.sizes import largest_size

#: Titles of the general solvers that figures and tables show, by their names in the datasets.
SOLVERS = {
    "cvode_adams": "CVODE Adams",
    "cvode_bdf": "CVODE BDF",
    "dopri8": "diffrax Dopri8",
    "tsit5": "diffrax Tsit5",
    "kvaerno5": "diffrax Kvaerno5",
    "scipy_dop853": "SciPy DOP853",
    "heyoka": "heyoka",
}

#: Rotating structures, whose stiff modes are non-linear.
TURNING = ["elastic_pendulum", "spinning_truss"]


def schemes_of_1996(dataset: xr.Dataset) -> xr.Dataset:
    """The part of a dataset with the schemes of 1996, in the order of the paper's tables."""
    return dataset.sel(scheme=SCHEMES)


def cells_of_tables(energy_errors: xr.Dataset) -> xr.Dataset:
    """The part of a dataset with the schemes, problems and step sizes of Tables 1 and 2, in the order of the tables."""
    return schemes_of_1996(energy_errors).sel(problem=PROBLEMS, steps_per_period=STEPS)


def families(dataset: xr.Dataset) -> dict[str, xr.Dataset]:
    """The parts of a dataset with the schemes of one family each, in the order in which the families appear."""
    names = dict.fromkeys(dataset.family.values.tolist())
    return {name: dataset.isel(scheme=np.flatnonzero(dataset.family.values == name)) for name in names}


def with_schemes(dataset: xr.Dataset, schemes: Sequence[str]) -> xr.Dataset:
    """The part of a dataset with the given schemes. Schemes that the dataset lacks are ignored.

    If the dataset lacks all of them, the part has the first schemes of the dataset, as many as are given.
    """
    there = [name for name in schemes if name in dataset.scheme.values]
    return dataset.sel(scheme=there or dataset.scheme.values[: len(schemes)])


def loss_of_amplitude(errors: xr.Dataset, shorter: int, longer: int) -> xr.DataArray:
    """Size of the change of amplitude per period of the longer runs, NaN where the change is not steady.

    If a scheme keeps the amplitude, the measured change is a ripple, which depends on where steps fall and does not
    grow with the length of the run. A change is steady if its size per period is the same, within a factor of two, in
    runs of both lengths at five neighbouring step sizes.
    """
    size = abs(errors.amplitude_decay)
    ratio = size.sel(periods=longer) / size.sel(periods=shorter)
    neighbours = min(5, ratio.sizes["steps_per_period"])
    steady = ((ratio > 0.5) & (ratio < 2)).rolling(steps_per_period=neighbours).sum() == neighbours
    ends = [steady.shift(steps_per_period=-ahead, fill_value=False) for ahead in range(neighbours)]
    return size.sel(periods=longer).where(np.logical_or.reduce(ends))


def largest_safe(atlas: xr.Dataset, error: float) -> xr.DataArray:
    """Largest Δt/T at and below which all steps of the maps keep energy and period within a relative error.

    The result is zero if the finest step exceeds the error.
    """
    return largest_size((atlas.max_energy_error <= error) & (atlas.period_error <= error), "step_size_over_period")


def largest_omega_step(rule: xr.Dataset, error: float) -> xr.DataArray:
    """Largest ω Δt up to which steps keep energy and period within a relative error; zero if the finest does not."""
    return largest_size((rule.max_energy_error <= error) & (rule.period_error <= error), "omega_step")
