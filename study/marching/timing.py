"""How long a run takes, compilation apart."""

import time

import jax
import numpy as np

from study.marching.march import COMPLETED, March, march
from study.observer.base import Reduction
from study.problem.definition import Problem
from study.scheme.base import Scheme


class Timed:
    """A compiled run, warmed up, whose step size and number of steps can be chosen.

    Attributes
    ----------
    compile_time
        Seconds to trace and compile it, or to load it where JAX's cache is enabled and holds it.
    """

    def __init__(self, problem: Problem, scheme: Scheme, reductions: tuple[Reduction, ...]):
        self._march, self._u0 = March(problem, scheme, reductions, ()), np.asarray(problem.u0)
        start = time.perf_counter()
        self._compiled = march.lower(*self._arguments(1.0, 1)).compile()  # type: ignore[attr-defined]
        self.compile_time = time.perf_counter() - start
        self.run(1e-9, 1000)

    def _arguments(self, dt: float, steps: int) -> tuple:
        return self._march, self._u0, np.asarray(dt), np.asarray(steps), np.asarray(1)

    def run(self, dt: float, steps: int) -> tuple[float, bool]:
        """Seconds of one run, and whether it completed."""
        arguments = self._arguments(dt, steps)
        start = time.perf_counter()
        _, outcome = self._compiled(*arguments)
        jax.block_until_ready(outcome)
        return time.perf_counter() - start, bool(outcome.status == COMPLETED)
