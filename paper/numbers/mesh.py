"""Numbers of the text: ratio of frequencies up to which an explicit scheme is the faster one."""

import numpy as np
import xarray as xr

from paper.claims.mesh import crossovers
from paper.products import numbers
from study.words import number, span


@numbers()
def mesh_numbers(mesh: xr.Dataset) -> dict:
    """Crossovers, steps and iterations of the implicit scheme, and the price of the stiffer row."""
    explicit = mesh.sel(scheme="central_difference")
    ratio = crossovers(mesh)
    frames, meshes = (ratio.isel(case=(ratio.columns > 1).values == wide) for wide in (False, True))
    by_panel = (
        explicit.steps_per_period.groupby(["rows", "columns"]).max()
        / explicit.steps_per_period.groupby(["rows", "columns"]).min()
    )
    step = explicit.seconds_per_step.groupby(["rows", "columns"])
    spread = (step.max() / step.min()).max().item()
    implicit = mesh.sel(scheme="average_acceleration")
    # time with the stiffest row over that with the least stiff one, panel by panel
    stiffest, softest = (
        implicit.seconds_per_period.isel(case=(mesh.stiffening == stiffening).values).values
        for stiffening in (mesh.stiffening.max(), mesh.stiffening.min())
    )
    return {
        "mesh_error": f"{100 * mesh.allowed_error.item():g}",
        "mesh_unknowns": span(mesh.unknowns, ",.0f"),
        "mesh_stiffest": number(mesh.stiffening.max().item()),
        "mesh_steps": span(implicit.steps_per_period, ".0f"),
        "mesh_iterations": span(implicit.newton_iterations_per_step, ".1f"),
        "mesh_crossover_frame": span(frames, ",.0f"),
        "mesh_crossover_panel": span(meshes, ",.0f"),
        "mesh_step_spread": number(spread, 2) if spread >= 1.05 else None,
        "mesh_price": span(by_panel.stack(panel=["rows", "columns"]).dropna("panel"), ".2g"),
        "mesh_price_implicit": span(stiffest / softest, ".2g"),
        # the next finer step tried is half as long
        "mesh_explicit_at_limit": bool((explicit.steps_per_period < 1.5 * np.pi * mesh.mesh_ratio).all()),
    }
