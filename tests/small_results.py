"""Small made-up datasets of the study, for tests that open them by name."""

from pathlib import Path

import numpy as np
import xarray as xr

from study import io
from study.runs.needs import ATTRIBUTES, joined_needs, needs
from tests.runs.made_up import runs, with_kinds

VERDICTS = ("found", "already_the_coarsest_step", "not_even_the_finest_step")

#: Step sizes by scheme, quantity and allowed error; with the first scheme no step keeps the energy error below 1 %.
STEPS = np.array([[[0.02, 0.01], [0.01, np.nan]], [[0.02, 0.005], [0.01, 0.004]]])


def assessment() -> xr.Dataset:
    """Assessment of two schemes on a spring over ten seconds; a step of central difference is ten times cheaper."""
    dims, per_step = ("scheme", "quantity", "allowed_error"), np.array([50e-9, 5e-9])[:, None, None]
    time, tried = per_step * 10 / STEPS, np.unique(STEPS[np.isfinite(STEPS)])
    # the energy error is half of the displacement error
    error = np.tile(100 * tried[:, None] * [1.0, 0.5], (2, 1, 1))
    return xr.Dataset(
        {
            "recommended_step_size": (dims, STEPS),
            "largest_step_size": (dims, 1.05 * STEPS),
            "error": (("scheme", "step_size", "quantity"), error),
            "recommended_error": (dims, np.broadcast_to([0.09, 0.009], STEPS.shape)),
            "seconds": (dims, time),
            "seconds_spread": (dims, time / 10),
            "force_evaluations": (dims, np.ceil(10 / STEPS)),
            "steps_tried": (dims, np.full(STEPS.shape, 700)),
            "largest_error": (dims, np.broadcast_to([0.095, 0.0095], STEPS.shape)),
            "verdict": (
                dims,
                np.where(np.isnan(STEPS), 2, 0),
                io.flags("how the search ended", VERDICTS, int),
            ),
            "highest_frequency": 3.0,
        },
        {
            "scheme": ["average_acceleration", "central_difference"],
            "scheme_title": ("scheme", ["Average acceleration", "Central difference"]),
            "kind": ("scheme", ["implicit", "explicit"]),
            "order": ("scheme", [2, 2]),
            "order_of_loss": ("scheme", [np.inf, np.inf]),
            "quantity": ["displacement", "energy"],
            "scaled_from": ("quantity", [0.0, 0.0]),
            "allowed_error": [0.1, 0.01],
            "step_size": tried,
        },
        {"duration": 10.0, "periods": 10, "problem": "softening spring"},
    )


def energy_error() -> xr.Dataset:
    """Energy errors of Houbolt's method on the hardening spring that halve with the step size."""
    error = np.array([[[[0.8], [0.4]]]])
    return xr.Dataset(
        {"max_energy_error": (("period_used", "problem", "steps_per_period", "scheme"), error, {"units": "1"})},
        {"period_used": ["printed"], "problem": ["hardening"], "steps_per_period": [100, 200], "scheme": ["houbolt"]},
    )


def decisions() -> xr.Dataset:
    """The decision on one spring, one quantity and one error."""
    dims, shape = ("problem", "quantity", "allowed_error", "kind", "filter"), (1, 1, 1, 1, 2)
    numbers = {name: (dims, np.ones(shape)) for name in ("step_size", "force_evaluations", "largest_error")}
    return xr.Dataset(
        {"scheme": (dims, np.full(shape, "bathe")), **numbers},
        {
            "problem": ["softening"],
            "quantity": ["displacement"],
            "allowed_error": [0.01],
            "kind": ["implicit"],
            "filter": ["all", "codes"],
        },
    )


def needed() -> xr.Dataset:
    """The needs of three schemes on a softening and a hardening spring."""
    errors = [[0.2, 0.05, 0.005, 0.0005], [0.05, 0.05, 0.02, 0.02], [0.2, 0.02, 0.005, 0.0005]]
    parts = [needs(runs(errors, problem), [0.1, 0.01]) for problem in ("softening", "hardening")]
    ds = with_kinds(joined_needs(parts))
    ds.verdict.attrs = ATTRIBUTES["verdict"]
    return ds


def write_to(results: Path) -> Path:
    """Write the datasets to a folder of results, and return the folder."""
    datasets = {
        "assessment/mine": assessment(),
        "energy_error": energy_error(),
        "decisions": decisions(),
        "needs": needed(),
    }
    for name, dataset in datasets.items():
        io.write(dataset.assign_attrs(source=io.SOURCE), results / f"{name}.nc")
    return results
