"""A deadline for long computations, which give up between two of their pieces."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_END: ContextVar[float] = ContextVar("end", default=math.inf)


def deadline() -> float:
    """Value of the monotonic clock at which computations in this context give up; infinity by default."""
    return _END.get()


@contextmanager
def until(end: float) -> Iterator[None]:
    """Within this context, computations give up when the monotonic clock passes ``end``. New threads have no end."""
    token = _END.set(end)
    try:
        yield
    finally:
        _END.reset(token)


def check_time(end: float | None = None) -> None:
    """Raise ``TimeoutError`` if the monotonic clock has passed ``end``, by default the deadline of this context."""
    if time.monotonic() > (deadline() if end is None else end):
        raise TimeoutError("the given time has ended.")
