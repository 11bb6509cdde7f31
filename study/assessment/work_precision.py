"""``study.work_precision``: error against computing time for a problem or a program."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import xarray as xr

from study.assessment.assess import assess
from study.assessment.drawing import curves, times_of_runs
from study.io import write
from study.mechanics.definition import Problem
from study.program.definition import Program
from study.registry import UnknownName, did_you_mean
from study.scheme.base import Scheme


def work_precision(
    problem: str | Problem | Program,
    schemes: Iterable[str | Scheme] | None = None,
    *,
    figure: str | Path | None = None,
    quantity: str | None = None,
    **options: Any,
) -> xr.Dataset:
    """Errors of schemes, and the computing times of their runs.

    Parameters
    ----------
    problem, schemes
        As the parameters of :func:`study.assess`.
    figure
        File for the diagram, ``.svg``; by default no diagram is drawn.
    quantity
        Quantity of the diagram, by default the first quantity of the assessment.
    **options
        Further parameters of :func:`study.assess`, such as ``duration`` and ``allowed_errors``.

    Returns
    -------
    xarray.Dataset
        Over ``scheme``, ``step_size`` and ``quantity``: ``error``, NaN where a step was not tried or a run failed; over
        ``scheme`` and ``step_size``: ``status`` and ``seconds``, and for a program ``reason``.

    Raises
    ------
    KeyError
        If there is no such problem, scheme or controller, or no such quantity for the diagram.
    TypeError, ValueError
        As :func:`study.assess`.

    Examples
    --------
    >>> study.work_precision("softening", ["rk4", "bathe"], figure="softening.svg")  # doctest: +SKIP
    """
    assessed = assess(problem, schemes, maps=False, **options)
    names = ["error", "status", *(["reason"] if "reason" in assessed else [])]
    ds = assessed[names].assign(seconds=times_of_runs(assessed))
    ds.seconds.attrs = {"long_name": "time of a run", "units": "s"}
    if figure is not None:
        known = assessed.quantity.values.tolist()
        if quantity is not None and quantity not in known:
            raise UnknownName(f"the assessment has no quantity {quantity!r}; {did_you_mean(quantity, known)}")
        error = assessed.error.sel(quantity=quantity or known[0])
        write(curves(assessed, ds.seconds, "time of a run, s", error, f"error of {error.quantity.item()}"), figure)
    return ds
