"""The computing time of a run, without compilation."""

import time

import numpy as np

from study.marching.march import March
from study.marching.program import Program
from study.marching.result import COMPLETED
from study.mechanics.definition import Problem
from study.observer.base import Reduction
from study.scheme.base import Scheme

#: Computing time of ten steps, in s, below which a run is fast. A fast run is warmed up by a thousand more steps.
SLOW = 0.01


class Timed:
    """A compiled run, warmed up, for any step size and number of steps.

    Attributes
    ----------
    seconds_to_compile
        Seconds to trace and compile the run, or to load it if JAX's cache holds it.
    """

    def __init__(self, problem: Problem, scheme: Scheme, reductions: tuple[Reduction, ...]):
        self._program = Program(March.of(problem, scheme, reductions))
        self._begin = np.asarray(problem.u0), np.asarray(problem.v0)
        self.seconds_to_compile, _ = self.run(1.0, 1)
        few, _ = self.run(1e-9, 10)
        if few < SLOW:
            self.run(1e-9, 1000)

    def run(self, dt: float, steps: int) -> tuple[float, bool]:
        """Computing time of one run in s, and whether the run completed."""
        start = time.perf_counter()
        result = self._program.run(*self._begin, np.asarray(dt), steps, every=1, samples=0, pause=steps)
        return time.perf_counter() - start, bool(result.status == COMPLETED)

    def shortest(self, dt: float, steps: int, enough: float) -> float:
        """Shortest computing time in s of runs that follow each other for ``enough`` seconds."""
        seconds: list[float] = []
        while sum(seconds) < enough:
            seconds.append(self.run(dt, steps)[0])
        return min(seconds)
