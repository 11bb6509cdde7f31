"""Checks of options that several experiments declare.

Each check returns an error message, or ``None`` if the options are valid. The message follows the name of the
experiment's section and a dot, so it starts with a key of that section.
"""

from collections.abc import Collection, Iterable


def unlisted(key: str, values: Iterable, source: str, listed: Collection) -> str | None:
    """Refuse a value that is not in ``listed``; ``source`` is the name of this list in the message."""
    for value in values:
        if value not in listed:
            return f"{key}: there is no {value} among {source}, {', '.join(map(str, listed))}."
    return None


def no_multiple(key: str, values: Iterable[int], divisor: int, source: str = "") -> str | None:
    """Refuse a value that is not a multiple of ``divisor``; ``source`` is the key of the divisor's option, if any."""
    for value in values:
        if value % divisor:
            return f"{key}: {value} is not a multiple of {source + ', ' if source else ''}{divisor}."
    return None


def less_than_a_step(key: str, duration: float, dt: float) -> str | None:
    """Refuse a duration that is shorter than one step."""
    return f"{key}, {duration}, is less than one step, {dt}." if duration < dt else None


def step_beyond_run(step_size_over_period: float, periods: float) -> str | None:
    """Refuse a step size, in periods, that exceeds the duration of the run, ``periods``."""
    if step_size_over_period > periods:
        return f"step_size_over_period: a step is longer than the {periods} periods of the run."
    return None
