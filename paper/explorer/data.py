"""Data of the page as tables of Bokeh: maps, runs, exact orbits and the runs of the paper."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource

#: Amplitudes and step sizes of a map that the page shows, at most: a cell is then some ten pixels wide.
CELLS = 64
#: Binary digits of the numbers that the mouse shows, and of what is drawn, of the size of the exact orbit and of a
#: doubling of the energy: what a reader or a pixel resolves, so that the page packs well.
DIGITS, DIGITS_OF_ORBIT, DIGITS_OF_HEIGHT = 9, 6, 4
#: Heights of the energy that the page shows: from where a run is at rest to where it has grown.
LEAST, MOST = 0.01, 100.0


def _rounded(values: np.ndarray) -> np.ndarray:
    """Values rounded to ``DIGITS`` binary digits, in single precision."""
    mantissa, exponent = np.frexp(values)
    with np.errstate(over="ignore"):
        return np.ldexp(np.round(mantissa * 2.0**DIGITS), exponent - DIGITS).astype(np.float32)


def _on_grid(values: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Values rounded to multiples of a power of two that is small compared with the size, in single precision."""
    step = 2.0 ** (np.floor(np.log2(size)) - DIGITS_OF_ORBIT)
    return (np.round(values / step) * step).astype(np.float32)


def coarse(dataset: xr.Dataset) -> xr.Dataset:
    """A map thinned to at most ``CELLS`` amplitudes and step sizes."""
    strides = {name: -(-dataset.sizes[name] // CELLS) for name in ("amplitude", "dt_over_period")}
    return dataset.isel({name: slice(None, None, stride) for name, stride in strides.items()})


def maps_source(atlas: xr.Dataset) -> ColumnDataSource:
    """A row for each problem and scheme, with an image (amplitudes, step sizes) of each quantity."""
    names = [(p, s) for p in atlas.problem.values.tolist() for s in atlas.scheme.values.tolist()]
    columns: dict[str, list] = {"problem": [p for p, _ in names], "scheme": [s for _, s in names]}
    for p, s in names:
        one = atlas.sel(problem=p, scheme=s)
        images = {
            "at_step": one.at_step.where(one.at_step >= 0),
            "energy_error": one.max_energy_error,
            "iterations": one.max_newton_iterations,
            "exponent": one.lyapunov_exponent * one.period,
            "u0": one.u0.broadcast_like(one.outcome),
            "dt_over_period": one.dt_over_period.broadcast_like(one.outcome),
        }
        columns.setdefault("outcome", []).append(one.outcome.values)
        for name, image in images.items():
            # Bokeh's tooltips write NaN as such and leave infinity to a formatter
            columns.setdefault(name, []).append(_rounded(image.fillna(np.inf).transpose(*one.outcome.dims).values))
    return ColumnDataSource(columns)


def runs_source(portraits: xr.Dataset, exact: xr.Dataset, outcome: xr.DataArray) -> ColumnDataSource:
    """A row for each problem and scheme, with outcomes, and samples (amplitudes, step sizes, samples) of quantities."""
    outcome = outcome.sel(amplitude=portraits.amplitude, dt_over_period=portraits.dt_over_period, method="nearest")
    columns: dict[str, list] = {"name": [], "outcome": [], "u": [], "v": [], "height": []}
    for p in portraits.problem.values.tolist():
        size = {name: abs(exact[f"orbit_{name}"].sel(problem=p)).max("point").values for name in ("u", "v")}
        for s in portraits.scheme.values.tolist():
            one = portraits.sel(problem=p, scheme=s)
            one = one.where(one.height <= MOST)
            columns["name"].append(f"{p} {s}")
            ends = outcome.sel(problem=p, scheme=s).transpose("amplitude", "dt_over_period")
            columns["outcome"].append(ends.values.astype(np.uint8))
            for name in ("u", "v"):
                columns[name].append(_on_grid(one[name].values, size[name][:, None, None]))
            doublings = np.log2(np.maximum(one.height.values, LEAST / 2)) * 2**DIGITS_OF_HEIGHT
            columns["height"].append(np.exp2(np.round(doublings) / 2**DIGITS_OF_HEIGHT).astype(np.float32))
    return ColumnDataSource(columns)


def orbits_source(exact: xr.Dataset) -> ColumnDataSource:
    """A row for each problem, with the amplitudes and the exact orbits (amplitudes, points) of the samples."""
    return ColumnDataSource(
        {
            "problem": exact.problem.values.tolist(),
            "u0": list(exact.u0.values),
            "period": list(exact.period.values),
            "u": list(exact.orbit_u.values),
            "v": list(exact.orbit_v.values),
        }
    )


def cases_source(atlas: xr.Dataset, cases: Sequence[xr.Dataset]) -> ColumnDataSource:
    """Places of the paper's runs in the maps."""
    columns: dict[str, list] = {"problem": [], "x": [], "y": [], "label": []}
    for case in cases:
        # the softening spring has another name at its large amplitude
        problem = next(name for name in atlas.problem.values.tolist() if case.problem.startswith(name))
        of_problem, u0, dt = atlas.sel(problem=problem), case.u.isel(scheme=0, t=0).item(), case.dt.item()
        x, y = np.log10([of_problem.u0, of_problem.period]), np.log10(of_problem.amplitude)
        period = 10 ** np.interp(np.log10(u0), *x)
        columns["problem"].append(problem)
        columns["x"].append(np.log10(dt / period))
        columns["y"].append(np.interp(np.log10(u0), x[0], y))
        columns["label"].append(f"u₀ = {u0:g}, Δt = {dt:g}")
    return ColumnDataSource(columns)
