"""The scheme that keeps an error with the fewest force evaluations, and its step, as a cell of a table."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import steps_of_period
from study.analysis.recommendation import recommend
from study.words import number

#: Allowed relative errors, one for each column of the table.
ERRORS = (0.1, 0.01, 0.001)
#: Largest relative error of energy and phase of a spring, of a balance of energies, and of a displacement.
LEVEL = 0.1
#: Verdict of a search that ends at the coarsest step.
COARSEST = "already the coarsest step"
#: Largest errors of a structure's motion, each divided by the size of the quantity. These bounds admit a scheme that
#: removes an unresolved oscillation: it misses half of the velocity and all of the acceleration. A sawtooth causes
#: larger errors.
BOUNDS = {"displacement_error": LEVEL, "velocity_error": 0.75, "acceleration_error": 1.25}
#: Number of force evaluations, as a multiple of the fewest, up to which a scheme ties with the cheapest.
TIED = 1.1

NO_BREAK = "\u00a0"
#: Mark of the coarsest step that was tried.
AT_MOST = f"≤{NO_BREAK}"


class Pick(NamedTuple):
    """A scheme with its step, in the form of a cell.

    ``step`` is the step or the number of steps in a period, and ``forces`` the number of force evaluations per period
    or second, both as texts. ``omega_step`` is Δt·ω with the highest ω of the motion, and ``limit`` is the stability
    limit of Δt·ω in linear theory. ``acceleration_error`` is the error of the acceleration of a structure at the step,
    NaN for other problems.
    """

    title: str
    step: str
    forces: str
    omega_step: float
    limit: float
    acceleration_error: float = np.nan


def cell(picks: list[Pick]) -> str:
    """The first of the schemes that tie, and ``…`` if others tie too; a dash if no scheme keeps the error."""
    if not picks:
        return "–"
    one = picks[0]
    below = f" < {one.limit:.3g}" if np.isfinite(one.limit) else ""
    work, condition = (part.replace(" ", NO_BREAK) for part in (one.forces, f"ωΔt {number(one.omega_step, 2)}{below}"))
    return f"{one.title}: {one.step} ({work}, {condition})" + ("; …" if len(picks) > 1 else "")


def first_of(titles: list[str]) -> str:
    """The first of some titles, and ``…`` if there are others."""
    return titles[0] + ("; …" if len(titles) > 1 else "")


def tied(forces: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Indices of the numbers of force evaluations that tie with the smallest, ordered by error; NaN is ignored."""
    places = np.flatnonzero(forces <= TIED * np.fmin.reduce(forces, initial=np.inf))
    return places[np.argsort(error[places], kind="stable")]


def sentence(title: str) -> str:
    """A title with a capital first letter, as at the beginning of a sentence."""
    return title[0].upper() + title[1:]


def needs_of_spring(spring: xr.Dataset, error: float, quantity: str) -> pd.DataFrame:
    """Rows of ``study.recommend``, one per scheme, for the step that keeps a quantity, the energy and the phase.

    This step is the finest of the steps that quantity, energy and phase need. The error of the quantity must be at most
    ``error``, and the errors of energy and phase at most ``LEVEL``. A scheme without such a step has no
    row. ``steps`` and ``forces`` are the steps and the force evaluations per period, and ``made`` is the error of the
    quantity.
    """
    wanted = {(error, quantity), (LEVEL, "energy"), (LEVEL, "phase")}
    needs = pd.concat([recommend(spring, error=limit, quantity=what) for limit, what in wanted])
    needs = needs.sort_values("step_size")
    kept = needs[needs.step_size.groupby(level="scheme").transform("count") == len(wanted)]
    finer = kept[~kept.index.duplicated()]
    made = [spring.error.sel(scheme=name, dt=dt, quantity=quantity).item() for name, dt in finer.step_size.items()]
    steps = [steps_of_period(spring, dt) for dt in finer.step_size]
    forces = [row.force_evaluations / row.number_of_steps * n for row, n in zip(finer.itertuples(), steps, strict=True)]
    return finer.assign(steps=steps, forces=forces, made=made)


def fewest_forces(runs: xr.Dataset, error: xr.DataArray, allowed: float) -> tuple[np.ndarray, np.ndarray]:
    """Fewest force evaluations per period with which each scheme keeps an error, and the index of the step.

    All finer steps must keep the error too. A run does not keep the error if its balance of energies is wrong by more
    than ``LEVEL``, or if it exceeds a bound in ``BOUNDS``. The number of evaluations is NaN if the finest step does
    not keep it.
    """
    sound = runs.max_energy_imbalance <= LEVEL
    for name, level in BOUNDS.items():
        if name in runs:
            sound &= runs[name] <= level
    dims, steps = ("scheme", "steps_per_period"), runs.steps_per_period.values
    kept = ((error <= allowed) & sound).transpose(*dims).values
    keeps = np.logical_and.accumulate(kept[:, ::-1], axis=1)[:, ::-1]
    per_step = runs.force_evaluations_per_step.transpose(*dims).values
    forces = np.where(keeps, per_step * steps, np.inf)
    best = forces.argmin(axis=1)
    return np.where(keeps.any(axis=1), forces[np.arange(len(best)), best], np.nan), best


def marked(steps: np.ndarray, place: int) -> str:
    """A number of steps; ``≤`` marks the coarsest step that was tried, and ``†`` the finest."""
    return f"{AT_MOST if place == 0 else ''}{steps[place]:,}{' †' if place == len(steps) - 1 else ''}"


def picks_of(runs: xr.Dataset, error: xr.DataArray, allowed: float, limits: Mapping[str, float]) -> list[Pick]:
    """The schemes that tie for the fewest force evaluations per period with an allowed error, with their steps."""
    dims = ("scheme", "steps_per_period")
    runs, error = runs.transpose(*dims, ...), error.transpose(*dims)
    fewest, best = fewest_forces(runs, error, allowed)
    steps = runs.steps_per_period.values
    ties = tied(fewest, error.values[np.arange(len(best)), best])
    picks = []
    # among ties, a step that a finer step confirms comes before the finest step
    for k in sorted(ties, key=lambda k: best[k] == len(steps) - 1):
        per_period = steps[best[k]]
        step, work = marked(steps, best[k]), f"{fewest[k]:,.0f} forces"
        omega_step = runs.highest_frequency.item() * runs.period.item() / per_period
        off = runs.acceleration_error.values[k, best[k]] if "acceleration_error" in runs else np.nan
        picks.append(Pick(runs.scheme_title.values[k], step, work, omega_step, limits[runs.scheme.values[k]], off))
    return picks
