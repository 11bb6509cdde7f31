"""The time of a run, without its compilation."""

import time

import jax
import numpy as np

from study.marching.march import March, compiled
from study.marching.result import COMPLETED
from study.observer.base import Reduction
from study.problem.definition import Problem
from study.scheme.base import Scheme


class Timed:
    """A compiled run, warmed up, for any step size and number of steps.

    Attributes
    ----------
    compile_time
        Seconds to trace and compile the run, or to load it if JAX's cache holds it.
    """

    def __init__(self, problem: Problem, scheme: Scheme, reductions: tuple[Reduction, ...]):
        self._march, self._u0 = March(problem, scheme, reductions, ()), np.asarray(problem.u0)
        start = time.perf_counter()
        self._compiled = compiled(*self._arguments(1.0, 1))
        self.compile_time = time.perf_counter() - start
        self.run(1e-9, 1000)

    def _arguments(self, dt: float, steps: int) -> tuple:
        return self._march, self._u0, np.asarray(dt), np.asarray(steps), np.asarray(1)

    def run(self, dt: float, steps: int) -> tuple[float, bool]:
        """Seconds that one run takes, and whether it completed."""
        arguments = self._arguments(dt, steps)
        start = time.perf_counter()
        _, result = self._compiled(*arguments)
        jax.block_until_ready(result)
        return time.perf_counter() - start, bool(result.status == COMPLETED)
