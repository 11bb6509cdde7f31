"""One source file for each kind of addition that a user may make to the project."""

#: Text of each file, by its path in the project.
ADDED = {
    "study/scheme/mine.py": '''"""A user's scheme."""

from study.scheme.newmark import Newmark

mine = Newmark(beta=0.26, gamma=0.52, title="Mine")
''',
    "study/experiments/last_displacement.py": '''"""Displacement after a number of steps."""

import xarray as xr

from study.marching.run import run
from study.declaration.experiment import experiment
from study.declaration.options import Count, Spring


@experiment("last_displacement", reads=lambda options: ["reference/hardening"])
def last_displacement(problem: Spring = "hardening", steps: Count = 100) -> xr.Dataset:
    """Displacement of a user's scheme after a number of steps."""
    end = run(problem, "mine", dt=0.001, steps=steps, every=steps).isel(t=-1)
    return xr.Dataset({"u": ((), end.u.item(), end.u.attrs)}, attrs={"title": "Last displacement"})
''',
    "paper/figures/last.py": '''"""The last displacement."""

import matplotlib.pyplot as plt

from paper.products import figure


@figure("The last displacement.", requires={"energy_error.periods": 100}, last="last_displacement")
def draw(last):
    """One point."""
    picture, axes = plt.subplots()
    axes.plot(0, last.u, "o")
    return picture
''',
    "paper/tables/last.py": '''"""The last displacement."""

import pandas as pd

from paper.products import table


@table(last="last_displacement")
def tabulate(last):
    """One row."""
    return pd.DataFrame({"u": [f"{last.u.item():.3f}"]})
''',
    "paper/claims/last.py": '''"""A user's claim."""

from paper.claims.ledger import Finding, claim


@claim("structures", "The last displacement is finite.", "its size")
def is_finite(last_displacement):
    """Whether it is."""
    size = abs(last_displacement.u.item())
    return Finding(f"{size:.2f}", size < 10)
''',
    "paper/numbers/last.py": '''"""A user's number."""

from paper.products import numbers


@numbers(last="last_displacement")
def last_numbers(last):
    """The last displacement."""
    return {"last_displacement": f"{last.u.item():.2f}"}
''',
}
