"""The timed cases, and their durations."""

import importlib.util
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from study.problem.named import printed_periods

#: Steps of a single run.
STEPS = 100_000


class Case(NamedTuple):
    """Two functions that are timed in turns and return the seconds of the same work."""

    name: str
    ours: Callable[[], float]
    baseline: Callable[[], float]
    #: Largest acceptable ratio.
    target: float
    #: Number of steps by which the times are divided.
    steps: int


def example(name: str) -> ModuleType:
    """A file of the examples as a module."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).parents[2] / "examples" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def step_size(problem: str) -> float:
    """A thousandth of the period."""
    return printed_periods[problem] / 1000


def timed(work: Callable[[], object]) -> float:
    """Seconds that the work takes."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
