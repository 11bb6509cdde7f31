"""Values of reductions at earlier times of a run."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp

from study.mechanics.definition import Problem
from study.observer.base import Reduction


class AlsoEarlier(Reduction):
    """Variables of some reductions at the end of a run, and at the last step up to each of some earlier times.

    The values at the earlier time number k are called as :meth:`earlier_name` says. One run thus has the values of
    shorter runs too, unless it fails.

    Attributes
    ----------
    reductions
        The reductions.
    times
        The earlier times in s.
    """

    reductions: tuple[Reduction, ...]
    times: tuple[jax.Array, ...]

    @classmethod
    def of(cls, reductions: Sequence[Reduction], times: Sequence[float]) -> "AlsoEarlier":
        """The observer of some reductions at some times."""
        return cls(tuple(reductions), tuple(jnp.asarray(time, float) for time in times))

    @staticmethod
    def earlier_name(name: str, number: int) -> str:
        """Name of a variable at the earlier time of a number."""
        return f"{name} at earlier time {number}"

    @property
    def variables(self) -> dict[str, dict[str, str]]:  # type: ignore[override]
        at_end = {name: values for reduction in self.reductions for name, values in reduction.variables.items()}
        numbers = range(len(self.times))
        return at_end | {self.earlier_name(name, k): values for name, values in at_end.items() for k in numbers}

    def refusal(self, problem: Problem) -> str | None:
        return next(filter(None, (reduction.refusal(problem) for reduction in self.reductions)), None)

    def _results(self, carried, problem, state):
        pairs = zip(self.reductions, carried, strict=True)
        return {name: value for reduction, c in pairs for name, value in reduction.result(c, problem, state).items()}

    def start(self, problem, state):
        carried = tuple(reduction.start(problem, state) for reduction in self.reductions)
        return carried, (self._results(carried, problem, state),) * len(self.times)

    def started(self, carried, effort):
        pairs = zip(self.reductions, carried[0], strict=True)
        return tuple(reduction.started(c, effort) for reduction, c in pairs), carried[1]

    def update(self, carried, problem, state, t, effort):
        pairs = zip(self.reductions, carried[0], strict=True)
        updated = tuple(reduction.update(c, problem, state, t, effort) for reduction, c in pairs)
        results = self._results(updated, problem, state)
        earlier = tuple(
            {name: jnp.where(t <= time, value, before[name]) for name, value in results.items()}
            for time, before in zip(self.times, carried[1], strict=True)
        )
        return updated, earlier

    def result(self, carried, problem, state):
        at_end, earlier = self._results(carried[0], problem, state), enumerate(carried[1])
        return at_end | {self.earlier_name(name, k): value for k, x in earlier for name, value in x.items()}
