"""Datasets of made-up runs with the schemes of the paper."""

import numpy as np
import xarray as xr

from paper.published import PROBLEMS, SCHEMES, STEPS


def filled(value, **coordinates) -> xr.DataArray:
    """Array with one value everywhere, on the given coordinates."""
    return xr.DataArray(np.full([len(axis) for axis in coordinates.values()], value), coordinates, list(coordinates))


def energy_error(order=2.0, **errors) -> xr.Dataset:
    """A dataset like energy_error.nc; ``errors`` are in percent.

    Other schemes than the given ones have 1 % at T/15 and the order ``order``.
    """
    error = filled(1.0, period_used=["printed"], problem=PROBLEMS, steps_per_period=STEPS, scheme=SCHEMES)
    error = error * (15 / error.steps_per_period) ** order
    for scheme, value in errors.items():
        error.loc[{"scheme": scheme}] = value if np.ndim(value) == 0 else np.reshape(value, (-1, len(STEPS)))
    return (
        (error / 100)
        .transpose("period_used", "problem", "steps_per_period", "scheme")
        .to_dataset(name="max_energy_error")
    )


def accuracy(energy=1.0, displacement=1.0, drift=0.0) -> xr.Dataset:
    """A dataset like accuracy.nc, in which all runs have the same errors; the arguments are in percent."""
    along = {"problem": PROBLEMS, "scheme": SCHEMES, "steps_per_period": [16, 32], "periods": [100]}
    values = {"max_energy_error": energy / 100, "displacement_error": displacement / 100, "energy_drift": drift / 100}
    return xr.Dataset({name: filled(value, **along) for name, value in values.items()})


def times(**scheme_times) -> xr.Dataset:
    """A dataset like cpu_time.nc with four repeats; other schemes than the given ones take 10 ns a step."""
    time = filled(10.0, problem=PROBLEMS, scheme=SCHEMES, repeat=[0, 1, 2, 3])
    for scheme, values in scheme_times.items():
        time.loc[{"scheme": scheme}] = np.broadcast_to(values, (len(PROBLEMS), 4))
    return time.to_dataset(name="seconds_per_step")
