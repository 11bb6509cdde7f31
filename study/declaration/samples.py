"""Samples of the exact motions of problems with kinks and of structures, for comparison with runs and solvers."""

from collections.abc import Mapping
from typing import NamedTuple, get_args

import numpy as np

from study import io
from study.declaration.checks import unlisted
from study.declaration.experiment import Options
from study.declaration.options import KinkedName

#: Names of the problems whose samples are in the dataset ``reference/inelastic``.
KINKED = get_args(get_args(KinkedName)[0])


class Known(NamedTuple):
    """Samples of the exact motion.

    Attributes
    ----------
    t, u
        Times in s, of shape (t,), and displacements, of shape (t, unknowns).
    uncertainty
        Uncertainty of the displacements, relative to the largest displacement.
    """

    t: np.ndarray
    u: np.ndarray
    uncertainty: float

    def error(self, u: np.ndarray) -> float:
        """Largest error of ``u`` over all unknowns and samples, relative to the largest exact displacement."""
        return float(np.abs(u.reshape(self.u.shape) - self.u).max() / np.abs(self.u).max())


def reference_of(problem: str) -> str:
    """Name of the dataset with samples of the exact motion of a problem."""
    return "reference/inelastic" if problem in KINKED else f"reference/{problem}"


def known(problem: str) -> Known:
    """Samples of the exact motion of a problem."""
    ds = io.open_dataset(reference_of(problem))
    if problem in KINKED:
        ds = ds.sel(problem=problem)
        t = ds.sample.values * ds.time_scale.item()
    else:
        t = ds.t.values
    u = ds.u.values.reshape(len(t), -1)
    return Known(t, u, float(ds.u_uncertainty.max() / np.abs(u).max()))


def check(options: Options, configuration: Mapping) -> str | None:
    """Refuse structures without samples."""
    smooth = [problem for problem in options["problems"] if problem not in KINKED]
    lengths = [length["problem"] for length in configuration["structures"]["lengths"]]
    return unlisted("problems", smooth, "structures.lengths", lengths)


def jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each problem."""
    return {problem: options | {"problems": [problem]} for problem in options["problems"]}
