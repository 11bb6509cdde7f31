"""Data of the page: maps, samples of runs, exact orbits and the runs of the paper, packed as bytes."""

import base64
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

#: Amplitudes and step sizes of a map that the page shows, at most: a cell is then some ten pixels wide.
CELLS = 64
#: Heights of the energy between which the page shows it: from where a run is at rest to where it has grown.
LEAST, MOST = 0.01, 100.0
#: Codes of a height for each doubling, from ``LEAST / 2`` on, and of the logarithm to base 2 of other quantities.
HEIGHT_CODES, LOG_CODES = 16, 512
#: Codes of a Lyapunov exponent times the period for each unit.
EXPONENT_CODES = 1000
#: Samples farther from the origin than this multiple of the exact orbit are left out; the panels end before.
FARTHEST = 12.0
#: Samples of one of the paper's runs, about: as many as the page draws of the others.
SAMPLES = 62


def packed(blocks: Mapping[str, np.ndarray]) -> tuple[dict[str, Any], str]:
    """Arrays as one text, and where each lies in it: offset, type and shape by name.

    The text is base64 of the compressed bytes, which a browser unpacks by itself. Arrays of wider numbers come first,
    so that each starts at a multiple of its own width.
    """
    order = sorted(blocks, key=lambda name: -blocks[name].itemsize)
    offsets = np.cumsum([0, *(blocks[name].nbytes for name in order)]).tolist()
    places = {
        name: {"offset": offset, "type": blocks[name].dtype.name, "shape": list(blocks[name].shape)}
        for name, offset in zip(order, offsets, strict=False)
    }
    content = b"".join(blocks[name].astype(blocks[name].dtype.newbyteorder("<")).tobytes() for name in order)
    return places, base64.b64encode(zlib.compress(content, 9)).decode()


def _to_int16(codes: np.ndarray) -> np.ndarray:
    """Codes as integers of two bytes; the smallest of these is NaN, and the ends stand for all that is beyond."""
    limited = np.clip(np.round(codes), -32767, 32767)
    return np.where(np.isnan(limited), -32768, limited).astype(np.int16)


def _logarithmic(values: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return _to_int16(LOG_CODES * np.log2(values))


def _bytes_within(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Codes from 1 to 255 between least and largest value along the last axis, 0 for NaN; and these two values."""
    finite = np.isfinite(values)
    low = np.where(finite, values, np.inf).min(-1, keepdims=True)
    high = np.where(finite, values, -np.inf).max(-1, keepdims=True)
    width = np.where(high > low, high - low, 1.0)
    with np.errstate(invalid="ignore"):
        codes = np.where(finite, 1 + np.round(254 * (values - low) / width), 0).astype(np.uint8)
    ends = np.concatenate([low, high], -1)
    return codes, np.where(np.isfinite(ends), ends, 0).astype(np.float32)


def _near(values: xr.DataArray, orbit: xr.DataArray, along: str) -> xr.DataArray:
    """Values within ``FARTHEST`` times the exact orbit, NaN for the others."""
    return values.where(abs(values) <= FARTHEST * abs(orbit).max(along))


def coarse(dataset: xr.Dataset) -> xr.Dataset:
    """A map thinned to at most ``CELLS`` amplitudes and step sizes."""
    strides = {name: -(-dataset.sizes[name] // CELLS) for name in ("amplitude", "dt_over_period")}
    return dataset.isel({name: slice(None, None, stride) for name, stride in strides.items()})


def largest_safe(atlas: xr.Dataset, outcomes: Sequence[str]) -> xr.DataArray:
    """Largest Δt/T from which on all finer steps of the map end in one of some outcomes.

    Returns
    -------
    xarray.DataArray
        Shape (problem, scheme, amplitude); NaN if already the finest step ends otherwise.
    """
    meanings = atlas.outcome.attrs["flag_meanings"].split()
    good = atlas.outcome.isin([meanings.index(name) for name in outcomes]).astype(int)
    unbroken = good.sortby("dt_over_period").cumprod("dt_over_period").astype(bool)
    steps = xr.DataArray(np.sort(atlas.dt_over_period.values), dims="dt_over_period")
    return steps.where(unbroken.drop_vars("dt_over_period")).max("dt_over_period")


def of_maps(atlas: xr.Dataset) -> dict[str, np.ndarray]:
    """Blocks of the maps: (problem, scheme, amplitude, step size), and without step size the largest safe steps."""
    maps = coarse(atlas).transpose("problem", "scheme", "amplitude", "dt_over_period", ...)
    blocks = {
        "outcome": maps.outcome.values.astype(np.uint8),
        "began": maps.at_step.values.astype(np.int32),
        "error": _logarithmic(maps.max_energy_error.values),
        "iterations": maps.max_newton_iterations.fillna(0).values.astype(np.uint8),
        "exponent": _to_int16(
            EXPONENT_CODES * (maps.lyapunov_exponent * maps.period).transpose(*maps.outcome.dims).values
        ),
        "u0": maps.u0.transpose("problem", "amplitude").values.astype(np.float32),
        "period": maps.period.transpose("problem", "amplitude").values.astype(np.float32),
    }
    for name, outcomes in (("accurate", ["accurate"]), ("bounded", ["accurate", "bounded"])):
        safe = largest_safe(atlas, outcomes).sel(amplitude=maps.amplitude)
        blocks[f"largest_{name}"] = safe.transpose("problem", "scheme", "amplitude").values.astype(np.float32)
    return blocks


def of_runs(portraits: xr.Dataset, amplitudes: xr.Dataset) -> dict[str, np.ndarray]:
    """Blocks of the samples: (problem, scheme, amplitude, step size, sample), and of the exact orbits beneath them."""
    samples = portraits.transpose("problem", "scheme", "amplitude", "dt_over_period", ...)
    shown = samples.where(samples.height <= MOST)
    exact = amplitudes.sel(amplitude=portraits.amplitude, problem=portraits.problem)
    blocks = {}
    for name in ("u", "v"):
        orbit = exact[f"orbit_{name}"].transpose("problem", "amplitude", "point")
        early = _near(samples[f"early_{name}"], orbit, "point").transpose(*samples[name].dims)
        blocks[f"late_{name}"], blocks[f"late_{name}_ends"] = _bytes_within(shown[name].values)
        blocks[f"early_{name}"], blocks[f"early_{name}_ends"] = _bytes_within(early.values)
        blocks[f"orbit_{name}"] = orbit.values.astype(np.float32)
    doublings = np.log2(np.clip(samples.height.values, LEAST / 2, 2 * MOST) / (LEAST / 2))
    blocks["height"] = np.where(np.isnan(doublings), 0, 1 + np.round(HEIGHT_CODES * doublings)).astype(np.uint8)
    return blocks


def problem_of(case: xr.Dataset, atlas: xr.Dataset) -> str:
    """The problem of the maps that one of the paper's runs belongs to."""
    # the softening spring has another name at its large amplitude
    return next(name for name in atlas.problem.values.tolist() if case.problem.startswith(name))


def of_cases(
    atlas: xr.Dataset, cases: Sequence[xr.Dataset], references: Sequence[xr.Dataset]
) -> tuple[list[dict[str, Any]], dict[str, np.ndarray]]:
    """The paper's own runs: a description of each, and blocks (scheme, sample) of its samples and exact orbit."""
    described: list[dict[str, Any]] = []
    blocks: dict[str, np.ndarray] = {}
    schemes = atlas.scheme.values.tolist()
    for place, (case, exact) in enumerate(zip(cases, references, strict=True)):
        period, dt = float(exact.period), case.dt.item()
        ran = [name for name in schemes if name in case.scheme.values]
        every, steps = max(1, round((case.sizes["t"] - 1) / SAMPLES)), case.sizes["t"] - 1
        described.append(
            {
                "name": case.problem,
                "problem": problem_of(case, atlas),
                "u0": case.u.isel(scheme=0, t=0).item(),
                "dt": dt,
                "period": period,
                "steps": steps,
                "every": every,
                "schemes": {
                    name: {
                        "place": index,
                        "error": float(abs(case.energy_error.sel(scheme=name)).where(np.isfinite).max().fillna(0)),
                        "failed": int(case.failed_at_step.sel(scheme=name)),
                    }
                    for index, name in enumerate(ran)
                },
            }
        )
        chosen = case.sel(scheme=ran).transpose("scheme", "t")
        late, early = chosen.isel(t=slice(None, None, every)), chosen.isel(t=slice(SAMPLES + 1))
        of_case = {f"late_{name}": late[name].where(late.height <= MOST) for name in ("u", "v")}
        of_case |= {"height": late.height.where(late.height <= 2 * MOST)}
        of_case |= {f"early_{name}": _near(early[name], exact[name], "t") for name in ("u", "v")}
        thinned = exact.isel(t=slice(None, None, max(1, (exact.sizes["t"] - 1) // 128)))
        of_case |= {"orbit_u": thinned.u, "orbit_v": thinned.v}
        blocks |= {f"case_{place}_{name}": values.values.astype(np.float32) for name, values in of_case.items()}
    return described, blocks
