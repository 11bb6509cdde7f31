"""A limit on the wall time of a reference."""

from collections.abc import Iterator
from contextlib import contextmanager

from reference.solution import ENDS


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
    token = ENDS.set(end)
    try:
        yield
    except TimeoutError:
        raise OutOfTime(unfinished) from None
    finally:
        ENDS.reset(token)
