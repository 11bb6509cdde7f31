"""Claims on the frequencies of mesh and motion, decided by our measurements of time."""

import xarray as xr

from paper.claims.ledger import PRACTICE, Finding, claim, when
from study.words import span

#: Ratios that count as about a hundred, half a decade on either side.
HUNDRED = 10**1.5, 10**2.5


def crossovers(mesh: xr.Dataset) -> xr.DataArray:
    """The ratio of frequencies at which both schemes take the same time, extrapolated from each case, to two digits."""
    ratios = mesh.crossover.dropna("case")
    return ratios.copy(data=[float(f"{ratio:.2g}") for ratio in ratios.values])


@claim(
    "structures",
    "An implicit scheme is the faster one where the highest frequency of the mesh is about a hundred times that of the "
    "motion, or more.",
    "ratio of the frequencies at which average acceleration and central difference take the same time, frames "
    "and meshes",
    whose=PRACTICE,
)
def hundred_times_the_motion(mesh):
    ratio = crossovers(mesh)
    ours = "; ".join(
        f"{title}: {span(ratios, ',.0f')}"
        for title, wide in (("frames", False), ("meshes", True))
        if (ratios := ratio.isel(case=(ratio.columns > 1).values == wide)).size
    )
    holds = bool(ratio.size and ((ratio > HUNDRED[0]) & (ratio < HUNDRED[1])).all())
    implicit, explicit = (
        mesh.seconds_per_step.sel(scheme=name) for name in ("average_acceleration", "central_difference")
    )
    reason = f"an implicit step takes {span(implicit / explicit, ',.0f')} times as long as an explicit one"
    return Finding(ours or "none", holds, when(not holds, reason))
