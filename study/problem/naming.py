"""The decorator that names a problem."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from study.mechanics.definition import Problem


class Known(NamedTuple):
    """A displacement that a source prints or that is exact.

    Attributes
    ----------
    time
        Time at which the displacement is reached.
    source
        Source that prints the displacement, or method that gives it exactly.
    u
        The displacement, or a quantity that is linear in the displacement.
    weights
        Matrix whose product with the displacement is this quantity; None for the displacement itself.
    """

    time: float
    source: str
    u: np.ndarray
    weights: np.ndarray | None = None


@dataclass(frozen=True)
class NamedProblem:
    """A function that makes a problem, with its properties.

    Attributes
    ----------
    make
        Function that returns the problem. All its arguments have defaults.
    time_scale
        Time that measures the step sizes of a structure: a period of its load or of its motion.
    time_scale_name
        What this time, or the period, is in words.
    period
        Approximate period of a free oscillator with one unknown. A problem with a period is one of the springs: its
        step sizes are fractions of the period, and the reference finds the exact period near it.
    printed
        Whether Xie (1996) prints ``period``, in two or three digits.
    known
        A displacement with which runs are compared.
    """

    make: Callable[..., Problem]
    time_scale: float | None = None
    period: float | None = None
    printed: bool = False
    known: Known | None = None
    time_scale_name: str = "period"

    def __call__(self, *arguments, **options) -> Problem:
        """Make the problem."""
        return self.make(*arguments, **options)


def named(
    *,
    time_scale: float | None = None,
    period: float | None = None,
    printed: bool = False,
    known: Known | None = None,
    time_scale_name: str = "period",
) -> Callable[[Callable[..., Problem]], NamedProblem]:
    """Decorate a function that makes a problem. The problem gets the name of the variable that holds the result.

    The arguments are the attributes of :class:`NamedProblem`, except ``make``.
    """
    return lambda make: NamedProblem(make, time_scale, period, printed, known, time_scale_name)
