"""Counts of the forces, the tangents and the matrices of linear systems that a traced function evaluates.

JAX runs a function once to trace it, and the compiled program evaluates what the function calls in this one pass. The
counts of a step are therefore known before the step is computed. Loops are the exception: their passes are counted as
data, in the :class:`study.mechanics.state.Effort` of the step.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any


class Counts:
    """Numbers of internal forces and of tangents, and the matrices that linear systems were solved with.

    ``forces_of_iteration`` is the number of forces that one Newton iteration of the last balance evaluates.
    """

    def __init__(self):
        self.forces = self.tangents = self.forces_of_iteration = 0
        self.matrices: list[Any] = []


_COUNTS: ContextVar[Counts | None] = ContextVar("counts", default=None)


@contextmanager
def counting() -> Iterator[Counts]:
    """Count what is evaluated within this context; a context around it does not count it again."""
    counts = Counts()
    token = _COUNTS.set(counts)
    try:
        yield counts
    finally:
        _COUNTS.reset(token)


def count(forces: int = 0, tangents: int = 0, forces_of_iteration: int = 0) -> None:
    """Add evaluations to the counts of the context, if there is one."""
    counts = _COUNTS.get()
    if counts is not None:
        counts.forces += forces
        counts.tangents += tangents
        counts.forces_of_iteration = forces_of_iteration or counts.forces_of_iteration


def count_matrix(matrix: Any) -> None:
    """Add the matrix of a linear system to the counts of the context; a matrix with several right sides counts once."""
    counts = _COUNTS.get()
    if counts is not None and not any(matrix is known for known in counts.matrices):
        counts.matrices.append(matrix)


class Counted:
    """A function with the counts of its last call, which no context around it counts."""

    def __init__(self, function: Callable):
        self._function, self.counts = function, Counts()

    def __call__(self, *arguments):
        """The value of the function."""
        with counting() as self.counts:
            return self._function(*arguments)
