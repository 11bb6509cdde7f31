"""Mesh against motion: time of an explicit and of an implicit scheme, by the frequencies of mesh and motion."""

import math
from itertools import product
from typing import Annotated

import jax.numpy as jnp
import numpy as np
import xarray as xr
from annotated_types import Ge, Le, Len
from scipy import sparse

from study import io
from study.declaration.experiment import experiment, progress
from study.declaration.options import Repeats, RisingCounts, Size, Sizes, Tolerance
from study.experiments import coordinates
from study.marching.run import run
from study.marching.timing import Timed
from study.materials import elastoplastic, elements
from study.mechanics.definition import Problem
from study.observer.motion import Quantity
from study.observer.named import observers
from study.scheme.named import schemes
from study.sizes import unbroken

#: The explicit and the implicit scheme, and the stability limit of the explicit one.
SCHEMES, LIMIT = ("central_difference", "average_acceleration"), 2.0
#: Strain at yield, stiffness after yield over the elastic one, and initial speed of the top.
YIELD, HARDENING, SPEED = 0.02, 0.05, 0.1
#: Refinements of the explicit step at the limit; the finest is the reference.
REFINED = (1, 2, 4)
#: Number of runs of one step, of which the shortest gives the time of a call, and this step over the period: so short
#: that Newton's method converges at once. A run that takes less than ``LONG`` calls goes on with the motion until it
#: takes as much, and short runs are repeated for ``ENOUGH`` seconds.
CALLS, SHORT, LONG, ENOUGH = 50, 1e-9, 100, 0.02

#: Numbers of rows and columns of a panel.
Panels = Annotated[list[Annotated[list[Annotated[int, Ge(1), Le(1000)]], Len(2, 2)]], Len(1, 20)]


def panel(rows: int, columns: int, stiffening: float) -> tuple[Problem, float, float]:
    """A panel of masses joined by yielding springs, with one elastic row that is stiffer by the factor ``stiffening``.

    Each mass moves along one direction. Springs join it to its neighbours in the row and in the column, and the
    lowest row to the ground. With one column the panel is a frame of storeys. The mesh does not change the lowest
    mode, whose speed at the top is the initial one.

    Returns
    -------
    tuple
        The problem, and the lowest and the highest circular frequency of its elastic motion.
    """
    size = rows * columns

    def elongations(u):
        w = u.reshape(rows, columns)
        return jnp.concatenate([jnp.diff(w, axis=0, prepend=0.0).ravel(), jnp.diff(w, axis=1).ravel()])

    upward = np.full((rows, columns), float(rows**2))
    upward[rows // 2] *= stiffening
    stiffness = np.concatenate([upward.ravel(), np.full(rows * (columns - 1), float(rows**2))])
    along, across = (
        sparse.diags_array([np.ones(n), -np.ones(n - 1)], offsets=[0, -1], format="csr") for n in (rows, columns)
    )
    joints = sparse.vstack(
        [sparse.kron(along, sparse.eye_array(columns)), sparse.kron(sparse.eye_array(rows), across[1:])]
    )
    matrix = sparse.csc_array(joints.T @ sparse.diags_array(stiffness) @ joints)
    # the stiff row would yield at an elongation of one, which it never reaches
    strength = np.where(stiffness > rows**2, stiffness, YIELD * rows)
    material = elastoplastic(stiffness=stiffness, yield_force=strength, hardening=HARDENING)
    force = elements(material, elongations, len(stiffness))
    lowest, highest = (
        float(np.sqrt(sparse.linalg.eigsh(matrix, 1, return_eigenvectors=False, **which)[0]))
        for which in ({"sigma": 0.0}, {"which": "LM"})
    )
    shape = np.sin(np.pi / 2 * np.arange(1, rows + 1) / rows)
    problem = Problem(
        force,
        u0=np.zeros(size),
        v0=SPEED * np.repeat(shape, columns),
        history=force.history,
        tangent=matrix if columns > 1 else None,
        title=f"panel of {rows} by {columns}",
    )
    return problem, lowest, highest


def seconds_of_step(timer: Timed, dt: float, steps: int, call: float) -> float:
    """Time of a step in a run of these steps, or of more if the call takes a large part of the time."""

    def shortest() -> float:  # the first long run may compile another program
        return min(timer.shortest(dt, steps, ENOUGH) for _ in range(2))

    while (seconds := shortest()) < LONG * call:
        steps *= max(math.ceil(LONG * call / seconds), 2)
    return (seconds - call) / steps


@experiment("mesh", timed=True)
def mesh(
    panels: Panels,
    stiffening: Sizes,
    steps_per_period: RisingCounts,
    periods: Size,
    allowed_error: Tolerance,
    repeats: Repeats,
) -> xr.Dataset:
    """Measure the time that an explicit and an implicit scheme need for a peak displacement with a given error.

    Parameters
    ----------
    panels
        Rows and columns of the panels.
    stiffening
        Factors of the stiffness of one row.
    steps_per_period
        Numbers of steps in the lowest period that the implicit scheme tries. The explicit scheme runs at its stability
        limit and at two finer steps.
    periods
        Length of the runs in lowest periods.
    allowed_error
        Allowed error of the largest displacement of the top.
    repeats
        Number of measurements of the time that decides; the schemes are timed in turns.

    Returns
    -------
    xarray.Dataset
        Over (case, scheme): ``steps_per_period`` from which on all steps tried keep the error, ``seconds_per_step``,
        ``seconds_per_period``, ``newton_iterations_per_step``; over (case, scheme, tried): ``tried_peak_error`` and
        ``tried_seconds`` of a lowest period, for every number of steps tried; over case: ``mesh_ratio``, ω of the mesh
        over ω of the motion, and ``crossover``, the ratio at which both schemes take the same time.
    """
    cases = list(product(map(tuple, panels), stiffening))
    shape = (len(cases), len(SCHEMES))
    steps, per_step, iterations, errors = (np.full(shape, np.nan) for _ in range(4))
    tried_error, tried_seconds = np.full((2, *shape, max(len(REFINED), len(steps_per_period))), np.nan)
    ratio, doubt = np.full(len(cases), np.nan), np.full(len(cases), np.nan)
    for c, ((rows, columns), factor) in enumerate(cases):
        progress(f"panel of {rows} by {columns}, one row {factor:g} times as stiff")
        problem, lowest, highest = panel(rows, columns, factor)
        ratio[c], period = highest / lowest, 2 * np.pi / lowest
        counts = [np.ceil(2 * np.pi / LIMIT * ratio[c] * 1.02) * np.array(REFINED), np.array(steps_per_period)]
        observed = [Quantity(lambda u: u[-1], name="top", reduce="peak"), observers["newton_iterations"]]
        runs = [
            [run(problem, schemes[name], dt=period / n, steps=round(periods * n), observe=observed) for n in tried]
            for name, tried in zip(SCHEMES, counts, strict=True)
        ]
        peaks = [np.array([ds.top.item() for ds in series]) for series in runs]
        truth = peaks[0][-1]
        doubt[c] = abs(peaks[1][-1] / truth - 1)
        timed = [Timed(problem, schemes[name], ()) for name in SCHEMES]
        for s, tried in enumerate(counts):
            tried_error[c, s, : len(tried)] = abs(peaks[s] / truth - 1)
            if kept := int(unbroken((tried_error[c, s, : len(tried)] <= allowed_error)[::-1]).sum()):
                first = len(tried) - kept
                steps[c, s], errors[c, s] = tried[first], tried_error[c, s, first]
                iterations[c, s] = runs[s][first].newton_iterations.item() / round(periods * tried[first])
        elapsed = np.full((repeats, *tried_seconds.shape[1:]), np.nan)
        calls = [min(timer.run(SHORT * period, 1)[0] for _ in range(CALLS)) for timer in timed]
        for repeat, (s, timer) in product(range(repeats), enumerate(timed)):
            for k, n in enumerate(counts[s]):
                if repeat == 0 or n == steps[c, s]:  # the time of steps that decide nothing is measured once
                    elapsed[repeat, s, k] = n * seconds_of_step(timer, period / n, round(periods * n), calls[s])
        for s, tried in enumerate(counts):
            tried_seconds[c, s, : len(tried)] = np.nanmin(elapsed[:, s, : len(tried)], axis=0)
            if np.isfinite(steps[c, s]):
                per_step[c, s] = tried_seconds[c, s, list(tried).index(steps[c, s])] / steps[c, s]
    dims = ("case", "scheme")
    time = steps * per_step
    return xr.Dataset(
        {
            "steps_per_period": (
                dims,
                steps,
                {"long_name": "steps in the lowest period that keep the error", "units": "1"},
            ),
            "peak_error": (
                dims,
                errors,
                {"long_name": "error of the largest displacement at these steps", "units": "1"},
            ),
            "newton_iterations_per_step": (
                dims,
                iterations,
                {"long_name": "Newton iterations in a step", "units": "1"},
            ),
            "seconds_per_step": (dims, per_step, {"long_name": "shortest time of a step", "units": "s"}),
            "seconds_per_period": (
                dims,
                time,
                {"long_name": "time of a lowest period with the allowed error", "units": "s"},
            ),
            "tried_peak_error": (
                (*dims, "tried"),
                tried_error,
                {"long_name": "error of the largest displacement", "units": "1"},
            ),
            "tried_seconds": (
                (*dims, "tried"),
                tried_seconds,
                {"long_name": "shortest time of a lowest period", "units": "s"},
            ),
            "crossover": (
                "case",
                ratio * time[:, 1] / time[:, 0],
                {"long_name": "ratio of frequencies at which both schemes would take the same time", "units": "1"},
            ),
            "reference_difference": (
                "case",
                doubt,
                {"long_name": "relative difference of the finest runs of the two schemes", "units": "1"},
            ),
        },
        coords={
            **coordinates.scheme_coordinates(SCHEMES),
            "rows": ("case", [rows for (rows, _), _ in cases], {"long_name": "rows of the panel", "units": "1"}),
            "columns": (
                "case",
                [columns for (_, columns), _ in cases],
                {"long_name": "columns of the panel", "units": "1"},
            ),
            "unknowns": (
                "case",
                [rows * columns for (rows, columns), _ in cases],
                {"long_name": "unknowns", "units": "1"},
            ),
            "stiffening": (
                "case",
                [factor for _, factor in cases],
                {"long_name": "factor of the stiff row", "units": "1"},
            ),
            "mesh_ratio": (
                "case",
                ratio,
                {"long_name": "highest over lowest circular frequency of the elastic panel", "units": "1"},
            ),
            "allowed_error": (
                (),
                allowed_error,
                {"long_name": "allowed error of the largest displacement", "units": "1"},
            ),
        },
        attrs={"title": "Time of an explicit and an implicit scheme on panels that yield", "processor": io.processor()},
    )
