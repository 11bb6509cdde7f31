"""A limit on the wall time of an assessment."""

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from study.algebra.deadline import until


class OutOfTime(ValueError):
    """The given time has ended before there was any result; the message states what was not finished."""


@contextmanager
def within(end: float, unfinished: str) -> Iterator[None]:
    """Give up the solvers of references in this context when the monotonic clock passes ``end``.

    Raises
    ------
    OutOfTime
        If a solver is given up; ``unfinished`` is the message.
    """
    try:
        with until(end):
            yield
    except TimeoutError:
        raise OutOfTime(unfinished) from None


class Budget:
    """The wall time of an assessment. Work that compiles cannot be given up, so its time is estimated.

    Parameters
    ----------
    end
        Value of the monotonic clock at which the time ends.
    """

    def __init__(self, end: float):
        self.end, self._longest = end, defaultdict[str, float](float)

    def allows(self, kind: str) -> bool:
        """Whether there is time for work that takes as long as the longest work of its kind so far."""
        return time.monotonic() + self._longest[kind] <= self.end

    def took(self, kind: str, seconds: float) -> None:
        """Note the time of work of a kind."""
        self._longest[kind] = max(self._longest[kind], seconds)

    @contextmanager
    def work(self, kind: str) -> Iterator[None]:
        """Measure work of a kind. It is given up between two of its pieces, without an error, when the time ends."""
        begin = time.monotonic()
        with suppress(TimeoutError), until(self.end):
            yield
        self.took(kind, time.monotonic() - begin)
