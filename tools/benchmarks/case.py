"""The type of a timed case, and functions that make and time cases."""

import importlib.util
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from study.problem.named import printed_periods

#: Number of steps of a single run.
STEPS = 100_000


class Case(NamedTuple):
    """Two functions that return the seconds of comparable work, and are called in turns."""

    name: str
    ours: Callable[[], float]
    baseline: Callable[[], float]
    #: Largest acceptable ratio of our time to the time of the baseline.
    target: float
    #: Number of steps by which both times are divided.
    steps: int


def example(name: str) -> ModuleType:
    """The file of this name in ``examples/`` as a module."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).parents[2] / "examples" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def step_size(problem: str) -> float:
    """A thousandth of the printed period of a spring."""
    return printed_periods[problem] / 1000


def timed(work: Callable[[], object]) -> float:
    """Seconds that the work takes."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
