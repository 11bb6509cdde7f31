"""Requirements on the configuration that several products share.

A requirement is a function of the value at a key, as :data:`paper.products.Requirements` takes it. It returns an empty
string if the value fits, and otherwise the rest of a sentence whose subject is the key.
"""

from collections.abc import Callable, Sequence
from typing import Any

from paper.published import PROBLEMS, SCHEMES, STEPS

Requirement = Callable[[Any], str]


def value_at(config: Any, key: str) -> Any:
    """The value at a dotted key, or a list of values where a part of the key leads into a list of mappings.

    Raises
    ------
    KeyError, TypeError
        If there is no such key.
    """
    for part in filter(None, key.split(".")):
        config = [entry[part] for entry in config] if isinstance(config, list) else config[part]
    return config


def contained(*keys: str, within: str) -> Requirement:
    """Require of the whole configuration that all entries at some keys are also present at another key."""

    def check(config: dict) -> str:
        there = value_at(config, within)
        missing = [(key, entry) for key in keys for entry in value_at(config, key) if entry not in there]
        return "{1} lacks {0[1]!r}, which {0[0]} has".format(missing[0], within) if missing else ""

    return check


def rising(values: list[float]) -> str:
    """Require that the numbers of a list are in ascending order."""
    return "" if values == sorted(values) else f"must be in ascending order, not {values}"


def fourfold(values: list[float]) -> str:
    """Require that four times the first number of a list is in the list too."""
    return "" if 4 * values[0] in values else f"lacks {4 * values[0]}, four times the first"


def spans(*values: float) -> Requirement:
    """Require that a range from ``first`` to ``last`` includes all of ``values``."""

    def check(span: dict) -> str:
        left_out = [value for value in values if not span["first"] <= value <= span["last"]]
        return f"leaves out {left_out[0]:g}, which the manuscript explains" if left_out else ""

    return check


def as_many(number: int) -> Requirement:
    """Require a list with exactly ``number`` entries, as the text or a figure needs."""
    return lambda values: "" if len(values) == number else f"must have {number} entries, not {len(values)}"


def one_of(known: Sequence[str]) -> Requirement:
    """Require a value that is one of ``known``."""
    return lambda value: "" if value in known else f"must be one of {', '.join(known)}, not {value!r}"


def steps_of_portrait(least: int) -> Requirement:
    """Require that a phase portrait has at least the given number of steps."""
    return lambda portrait: (
        f"has a duration of less than {least} steps, which the ledger needs"
        if portrait["duration"] / portrait["dt"] < least
        else ""
    )


def samples_of_history(least: int) -> Requirement:
    """Require that a history has at least the given number of samples after its start."""

    def check(history: dict) -> str:
        samples = round(history["periods"] * history["steps_per_period"]) // history["every"]
        return f"has {samples} samples after the start; its products need {least}" if samples < least else ""

    return check


#: Requirements of Tables 1 and 2 of the paper.
REPRODUCED_TABLES: dict[str, Any] = {
    "energy_error.schemes": SCHEMES,
    "energy_error.problems": PROBLEMS,
    "energy_error.steps_per_period": STEPS,
    "energy_error.periods": 100,
}
#: Requirements of the resonance of the Runge-Kutta method on the softening spring.
RESONANCE: dict[str, Any] = {
    "energy_drift.problem": "softening",
    "energy_drift.scheme": "rk4",
    "energy_drift.steps_per_period": spans(20, 25),
    "energy_drift.steps_per_period.step": lambda step: (
        f"must be at most 0.5 to show windows of resonance, not {step}" if step > 0.5 else ""
    ),
}
