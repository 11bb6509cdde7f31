"""One run of a program, checked: its times and quantities, or the reason why it failed."""

import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from study.algebra.scalars import check_unmasked

#: Outcomes of a run of a program; the last one marks steps that were not tried.
STATUSES = (
    "completed",
    "raised",
    "nothing",
    "unusable",
    "not_finite",
    "unequal_times",
    "too_short",
    "exit_code",
    "signal",
    "timed_out",
    "not_tried",
)

#: Names in the result of a run. ``t`` holds the times. ``seconds`` is optional and holds the measured computing time in
#: s, in total or up to each time.
TIME, SECONDS = "t", "seconds"

#: Largest absolute value of a quantity; a run that exceeds it gets the status ``not_finite``.
LARGEST = 1e100

#: Tolerance of times relative to a step, for the rounding of numbers in a file.
UNIFORM = 1e-3

#: Advice for times that are not the ends of every n-th step.
WHOLE = "write every step, or give the time between outputs as spacing=, which all steps then divide"

#: Times of a run, of shape (t,).
Times = Float[np.ndarray, "t"]

#: Values of a quantity along time, or a single number.
Values = Float[np.ndarray, "..."]

#: Function that runs a program. It takes the name of a scheme and the step in s, and returns times and quantities by
#: name.
Runnable = Callable[[str, float], Mapping]


class Unusable(Exception):
    """Exception for a failed run, with one of the ``STATUSES`` and the reason."""

    def __init__(self, status: str, reason: str):
        super().__init__(reason)
        self.status, self.reason = status, reason


class Unfit(ValueError):
    """A program that no step can run; the message states why, in one sentence."""


class Run(NamedTuple):
    """A run of a program.

    Attributes
    ----------
    status, reason
        One of the ``STATUSES``, and the reason of a failure, which is empty for a completed run.
    seconds
        Computing time of the run in s, as measured by the program. It is ``elapsed`` if the program measures none or
        the run failed, and NaN if the run ended its process.
    elapsed
        Wall time of the run in s, including the start of a process by the program; zero if the run ended its process.
    t
        Times in s, of shape (t,); empty if the program returns no times, or if the run failed.
    values
        Quantities by name: along time, of shape (t, ...), or a single number, of shape ().
    """

    scheme: str
    dt: float
    status: str
    reason: str
    seconds: float
    elapsed: float
    t: Times
    values: dict[str, Values]

    @property
    def completed(self) -> bool:
        """Whether the run succeeded."""
        return self.status == STATUSES[0]


def _array(name: str, value: object) -> Values:
    try:
        check_unmasked(f"'{name}'", value)
        values = np.asarray(value)
        if values.dtype.kind == "c":
            raise Unusable("unusable", f"'{name}' must be real numbers, and is complex")
        values = values.astype(float)
    except (TypeError, ValueError) as error:
        raise Unusable("unusable", f"'{name}' must be numbers ({error})") from None
    if not values.size:
        raise Unusable("nothing", f"'{name}' is empty")
    return values


def _check_times(t: np.ndarray, dt: float, duration: float) -> None:
    """Check that times begin and end within one gap of the run, and increase in equal gaps of whole steps.

    Only the last gap may be shorter.

    Raises
    ------
    Unusable
        If the times fail one of these checks.
    """
    gaps = np.diff(t)
    if t.ndim != 1 or not gaps.size:
        raise Unusable("too_short", f"'{TIME}' has {t.size} time{'s' * (t.size != 1)}, and at least two are needed")
    if not np.isfinite(t).all() or (gaps <= 0).any():
        raise Unusable("unequal_times", f"its times do not increase after t = {t[np.argmin(gaps > 0)]:g} s")
    # every gap but the last must equal the first; the last may be shorter
    uneven = np.flatnonzero(np.append(np.abs(gaps[:-1] - gaps[0]), gaps[-1] - gaps[0]) > UNIFORM * gaps[0])
    if uneven.size:
        raise Unusable(
            "unequal_times",
            f"its times are {gaps[0]:g} s apart, and {gaps[uneven[0]]:g} s after t = {t[uneven[0]]:g} s: {WHOLE}",
        )
    steps = t[0] / dt
    starts_late = gaps.size > 1 and t[0] > gaps[0] * (1 + UNIFORM)
    if starts_late or t[0] < -UNIFORM * dt or abs(steps - round(steps)) > UNIFORM * max(steps, 1):
        raise Unusable("unusable", f"it begins at t = {t[0]:g} s, and must begin at 0 or with the first output after 0")
    if t[-1] - gaps[-1] > duration * (1 + UNIFORM):
        raise Unusable("unusable", f"it ends at t = {t[-1]:g}, and must end at {duration:g} in the unit s")
    if t[-1] + gaps[0] < duration * (1 - UNIFORM * dt / duration):
        raise Unusable("too_short", f"it ends at t = {t[-1]:g} of {duration:g} s")
    if gaps.size > 1 and abs(gaps[0] / dt - max(round(gaps[0] / dt), 1)) > UNIFORM * gaps[0] / dt:
        raise Unusable("unequal_times", f"its times are {gaps[0]:g} s apart at a step of {dt:g} s: {WHOLE}")


def checked(result: object, dt: float, duration: float) -> tuple[np.ndarray, dict[str, Values]]:
    """Times and quantities in the result of a run.

    Raises
    ------
    Unusable
        If the result is not a mapping from names to finite numbers, if it is empty, if a quantity and the times have
        different lengths, or if the times are not equally spaced or end too early.
    """
    if result is None:
        raise Unusable("nothing", "it returned nothing")
    if not isinstance(result, Mapping):
        raise Unusable("unusable", f"it returned {type(result).__name__}, and not a mapping from names to numbers")
    values = {str(name): _array(str(name), value) for name, value in result.items()}
    t = values.pop(TIME, np.empty(0))
    if not values:
        raise Unusable("nothing", "it returned no quantity")
    if t.size:
        _check_times(t, dt, duration)
    for name, quantity in values.items():
        if quantity.ndim and len(quantity) != len(t):
            raise Unusable("unusable", f"'{name}' has {len(quantity)} values at {len(t)} times '{TIME}'")
        if not np.isfinite(quantity).all():
            finite = np.isfinite(quantity.reshape(len(t), -1)).all(axis=1) if quantity.ndim else None
            location = "" if finite is None else f" at t = {t[np.argmin(finite)]:g} s"
            raise Unusable("not_finite", f"'{name}' is not finite{location}")
        if np.abs(quantity).max() > LARGEST:
            raise Unusable("not_finite", f"'{name}' grows to {np.abs(quantity).max():.1g}")
    return t, values


def difference(first: Run, second: Run, sizes: Mapping[str, float] | None = None) -> float:
    """Largest difference of the quantities of two runs, relative to sizes, or otherwise to the values of the first run.

    It is infinite if times or names of quantities differ.
    """
    if first.t.shape != second.t.shape or first.values.keys() != second.values.keys():
        return np.inf
    differences = [0.0]
    for name, values in {TIME: first.t, **first.values}.items():
        second_values = second.t if name == TIME else second.values[name]
        if second_values.shape != values.shape:
            return np.inf
        deviation = np.abs(values - second_values).max(initial=0.0)
        differences.append(
            float(deviation / ((sizes or {}).get(name) or np.abs(values).max() or deviation)) if deviation else 0.0
        )
    return max(differences)


def attempt(run: Runnable, scheme: str, dt: float, duration: float) -> Run:
    """Run a program once; a failure is returned as a :class:`Run` with its reason.

    Raises
    ------
    Unfit
        If the program states that no step can run it.
    """
    start = time.perf_counter()
    try:
        # values of a program may overflow, which ``checked`` reports
        with np.errstate(all="ignore"):
            result = run(scheme, dt)
        elapsed = time.perf_counter() - start
        t, values = checked(result, dt, duration)
        seconds = values.pop(SECONDS, np.array(elapsed)).flat[-1]
        return Run(scheme, dt, STATUSES[0], "", float(seconds), elapsed, t, values)
    except Unfit:
        raise
    except Unusable as failed:
        status, reason = failed.status, failed.reason
    except SystemExit as end:  # SystemExit would end this process, too
        status, reason = "exit_code", f"it ended with the exit code {end.code}"
    except Exception as error:  # a user's program may raise anything
        status, reason = "raised", f"it raised {type(error).__name__}: {error}"
    elapsed = time.perf_counter() - start
    return Run(scheme, dt, status, reason, elapsed, elapsed, np.empty(0), {})
