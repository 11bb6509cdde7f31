"""One reference from several routes: the best of them, and how far the others are from it."""

import jax.numpy as jnp
import numpy as np
import xarray as xr

from reference import diffrax, exact, sundials
from study.command import main, progress
from study.problems import printed_periods, problems

SAMPLES = 512


def _scaled_difference(a, b):
    """Largest difference along time, relative to the largest size of the quantity."""
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


def reference(problem: str) -> xr.Dataset:
    """Period and trajectory over one period by every route, the best of them, and their differences.

    The best is the closed form where there is one, else diffrax. The uncertainty is the largest difference between
    two routes.
    """
    definition = problems[problem]
    progress(f"reference of {problem}: closed form, CVODE, diffrax")
    truth = exact.period(definition)
    estimate = printed_periods[problem]
    periods = {
        "closed_form": float(truth),
        "cvode": sundials.period(definition, estimate),
        "diffrax": diffrax.period(definition, estimate),
    }
    t = np.linspace(0.0, periods["closed_form"], SAMPLES + 1)
    trajectories = {"cvode": sundials.trajectory(definition, t), "diffrax": diffrax.trajectory(definition, t)}
    best = "diffrax"
    if exact.has_trajectory(definition):
        trajectories["closed_form"] = exact.trajectory(definition, t)
        best = "closed_form"
    routes = list(periods)
    absent = np.full((2, len(t)), np.nan)
    u, v = np.stack([trajectories.get(route, absent) for route in routes], axis=1)

    def differences(values):
        return [
            [_scaled_difference(x, y) if np.isfinite([x, y]).all() else np.nan for y in values.values()]
            for x in values.values()
        ]

    period_differences = [[abs(x - y) / float(truth) for y in periods.values()] for x in periods.values()]
    u_differences = differences(dict(zip(routes, u, strict=True)))
    v_differences = differences(dict(zip(routes, v, strict=True)))
    pair = ("route", "other_route")
    best_u, best_v = trajectories[best]
    return xr.Dataset(
        {
            "u": ("t", best_u, {"long_name": "displacement", "units": "1"}),
            "v": ("t", best_v, {"long_name": "velocity", "units": "s-1"}),
            "u_uncertainty": (
                (),
                np.nanmax(u_differences) * np.max(np.abs(best_u)),
                {"long_name": "largest difference of the displacement between two routes", "units": "1"},
            ),
            "v_uncertainty": (
                (),
                np.nanmax(v_differences) * np.max(np.abs(best_v)),
                {"long_name": "largest difference of the velocity between two routes", "units": "s-1"},
            ),
            "period": ((), float(truth), {"long_name": "period", "units": "s"}),
            "period_uncertainty": (
                (),
                np.max(period_differences) * float(truth),
                {"long_name": "largest difference of the period between two routes", "units": "s"},
            ),
            "period_by_route": ("route", list(periods.values()), {"long_name": "period by route", "units": "s"}),
            "period_difference": (
                pair,
                period_differences,
                {"long_name": "relative difference of the period between two routes", "units": "1"},
            ),
            "u_difference": (
                pair,
                u_differences,
                {"long_name": "largest difference of the displacement over one period, relative", "units": "1"},
            ),
            "v_difference": (
                pair,
                v_differences,
                {"long_name": "largest difference of the velocity over one period, relative", "units": "1"},
            ),
            "energy_drift": (
                (),
                _energy_drift(definition, best_u, best_v),
                {"long_name": "largest relative change of the energy along the reference", "units": "1"},
            ),
        },
        coords={
            "t": ("t", t, {"long_name": "elapsed time", "units": "s"}),
            "route": ("route", routes, {"long_name": "how the reference was found"}),
            "other_route": ("other_route", routes, {"long_name": "what it is compared with"}),
        },
        attrs={
            "title": f"Reference solution of the {definition.title} over one period",
            "problem": problem,
            "best_route": best,
            "period_30_digits": exact.digits(truth),
        },
    )


def _energy_drift(definition, u, v) -> float:
    energy = np.asarray([definition.energy(jnp.asarray(x), jnp.asarray(y)) for x, y in zip(u, v, strict=True)])
    return np.max(np.abs(energy / energy[0] - 1))


if __name__ == "__main__":
    main(reference)
