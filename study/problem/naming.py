"""The decorator that names a problem."""

from collections.abc import Callable
from dataclasses import dataclass

from study.mechanics.definition import Problem


@dataclass(frozen=True)
class NamedProblem:
    """A function that makes a problem, with its properties.

    Attributes
    ----------
    make
        Returns the problem; its arguments, if it has any, have defaults.
    time_scale
        Time that measures the step sizes of a structure: a period of its load or of its motion.
    period
        Approximate period of a free oscillator with one unknown, which makes it a spring: it measures step sizes, and
        the reference finds the exact period near it.
    printed
        Whether it is the period that Xie (1996) prints, in two or three digits.
    """

    make: Callable[..., Problem]
    time_scale: float | None = None
    period: float | None = None
    printed: bool = False

    def __call__(self, *arguments, **options) -> Problem:
        """Make the problem."""
        return self.make(*arguments, **options)


def named(
    *, time_scale: float | None = None, period: float | None = None, printed: bool = False
) -> Callable[[Callable[..., Problem]], NamedProblem]:
    """Decorate a function that makes a problem; the problem takes the name of the variable.

    The arguments are the other attributes of :class:`NamedProblem`.
    """
    return lambda make: NamedProblem(make, time_scale, period, printed)
