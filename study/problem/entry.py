"""How a problem gets its name."""

from collections.abc import Callable
from dataclasses import dataclass

from study.problem.definition import Problem


@dataclass(frozen=True)
class NamedProblem:
    """A function that makes a problem, with what the study knows of it.

    Attributes
    ----------
    make
        Returns the problem; its arguments, if it has any, have defaults.
    time_scale
        Time by which the steps of a structure are counted: a period of its load or of its motion.
    printed_period
        Period that Xie (1996) prints and takes the step sizes from, in two or three digits.
    """

    make: Callable[..., Problem]
    time_scale: float | None = None
    printed_period: float | None = None

    def __call__(self, *arguments, **options) -> Problem:
        """The problem."""
        return self.make(*arguments, **options)


def named(**known: float) -> Callable[[Callable[..., Problem]], NamedProblem]:
    """Name the problem that the decorated function makes after its variable; ``known`` are further attributes."""
    return lambda make: NamedProblem(make, **known)
