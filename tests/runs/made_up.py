"""Made-up runs of two explicit schemes and an implicit one on one problem."""

import numpy as np
import xarray as xr

from study.runs.needs import exponents

#: Names, titles and kinds of the schemes.
SCHEMES = ("cheap", "dear", "stiff")
#: Steps in a time scale of two seconds.
COUNTS = np.array([8, 16, 32, 64])


def runs(error, problem: str = "swing", **others) -> xr.Dataset:
    """Runs over 10 periods with errors over (scheme, count); a step takes 1, 2 and 5 forces.

    ``others`` replaces values over (scheme, count), or over count for ``divides``.
    """
    shape = (len(SCHEMES), len(COUNTS), 1, 1)
    errors = np.reshape(np.asarray(error, float), shape)
    largest = np.reshape(others.get("largest", np.full(shape, np.nan)), shape)
    velocity = np.reshape(others.get("velocity", 0 * errors), shape)
    both = np.concatenate([errors, velocity], axis=2)
    along, forces = (
        ("scheme", "size", "quantity", "periods"),
        10 * COUNTS[:, None] * np.array([1.0, 2.0, 5.0])[:, None, None],
    )
    return xr.Dataset(
        {
            "error": (along, both),
            "largest_error": (along, np.concatenate([largest, np.full(shape, np.nan)], axis=2)),
            "force_evaluations": (("scheme", "size", "periods"), forces),
            "tangent_evaluations": (("scheme", "size", "periods"), 0 * forces),
            "factorisations": (("scheme", "size", "periods"), 0 * forces),
            "tried": (("scheme", "size"), np.reshape(others.get("tried", np.ones(shape)), shape[:2])),
            "uncertainty": ("quantity", [others.get("uncertainty", 0.0), 0.0]),
        },
        {
            "scheme": list(SCHEMES),
            "quantity": ["displacement", "velocity"],
            "periods": [10.0],
            "duration": ("periods", [20.0]),
            "step_size": ("size", 2.0 / COUNTS),
            "steps_per_period": ("size", COUNTS.astype(float)),
            "omega_step": ("size", 6.0 / COUNTS),
            "proposed": ("size", others.get("proposed", np.ones(len(COUNTS), int))),
            "divides": ("size", others.get("divides", np.ones(len(COUNTS), int))),
            "time_scale": 2.0,
            "time_scale_name": "period",
            "decided": 10.0,
            "starts": 1,
            "free_vibration": 1,
            "has_kinks": 0,
            "unknowns": 1,
            "spacing": 0.125,
            "highest_frequency": 3.0,
            "problem": problem,
            "problem_title": f"{problem}ing thing",
        },
    )


def with_kinds(needed: xr.Dataset) -> xr.Dataset:
    """Needs with the properties of the schemes that decisions use; codes have the dear and the stiff scheme."""
    needed = needed.assign_coords(
        explicit=("scheme", [1, 1, 0]),
        in_codes=("scheme", [0, 1, 1]),
        order=("scheme", [4, 2, 2]),
        order_of_loss=("scheme", [5, 3, 3]),
        scheme_title=("scheme", ["Cheap", "Dear", "Stiff"]),
    )
    return needed.assign(exponent=exponents(needed))
