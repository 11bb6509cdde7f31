"""A limit on the wall time of work that does not watch the clock itself."""

import math
import time
from collections.abc import Callable
from contextvars import copy_context
from threading import TIMEOUT_MAX, Thread
from typing import Any

from reference.solution import ENDS


class OutOfTime(ValueError):
    """The given time has ended before there was any result; the message states what was not finished."""


def within(end: float, work: Callable[[], Any], unfinished: str) -> Any:
    """The result of ``work``, unless the monotonic clock passes ``end`` first.

    Compiled solvers cannot be interrupted. A thread that is too late is left behind; it ends with the solver, or with
    the process.

    Raises
    ------
    OutOfTime
        If ``work`` is too late; ``unfinished`` is the message.
    Exception
        Any exception of ``work``.
    """
    if end == math.inf:
        return work()
    found: dict[str, Any] = {}

    def run() -> None:
        ENDS.set(end)
        try:
            found["result"] = work()
        except BaseException as error:  # raised again by the waiting thread
            found["error"] = error

    thread = Thread(target=copy_context().run, args=(run,), daemon=True)
    thread.start()
    thread.join(min(max(end - time.monotonic(), 0.0), TIMEOUT_MAX))
    if not found or isinstance(found.get("error"), TimeoutError):
        raise OutOfTime(unfinished)
    if "error" in found:
        raise found["error"]
    return found["result"]
