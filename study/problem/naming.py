"""How a problem is named."""

from collections.abc import Callable
from dataclasses import dataclass

from study.problem.definition import Problem


@dataclass(frozen=True)
class NamedProblem:
    """A function that makes a problem, with the facts that the study knows about it.

    Attributes
    ----------
    make
        Returns the problem; its arguments, if it has any, have defaults.
    time_scale
        Time that measures the step sizes of a structure: a period of its load or of its motion.
    printed_period
        Period that Xie (1996) prints, in two or three digits, and bases the step sizes on.
    """

    make: Callable[..., Problem]
    time_scale: float | None = None
    printed_period: float | None = None

    def __call__(self, *arguments, **options) -> Problem:
        """Make the problem."""
        return self.make(*arguments, **options)


def named(**known: float) -> Callable[[Callable[..., Problem]], NamedProblem]:
    """Decorate a function that makes a problem; the problem takes the name of the variable.

    ``known`` are the other attributes of :class:`NamedProblem`.
    """
    return lambda make: NamedProblem(make, **known)
