"""Printed form of numbers, lists and pages. This module imports the standard library only."""

import html
import math
import re
from collections.abc import Iterable
from typing import Any

#: Translation of digits and a hyphen into superscripts, for exponents.
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Value that scales the errors of a quantity, by the name of its reduction; a quantity along time has none.
SCALED_BY = {"": "largest value along time", "peak": "peak", "final": "final value", "rms": "root mean square"}
# a power such as 5e-05; digits within a word, such as the hash of a commit, are not a number
_POWER = re.compile(r"(?<![\w.])(\d(?:\.\d+)?)e([+-]?)0*(\d{1,3})(?!\w)")
#: Largest fraction that :func:`percent` prints as zero, because it may be round-off.
_ZERO = 1e-9


def _power_of_ten(match: re.Match) -> str:
    factor, sign, exponent = match.groups()
    if float(factor) == 0:
        return "0"
    raised = f"10{(sign.replace('+', '') + exponent).translate(RAISED)}"
    # with no-break spaces
    return raised if factor == "1" else f"{factor}\u00a0×\u00a0{raised}"


def printed(text: str) -> str:
    """A text as it is printed: ``5e-05`` becomes 5 × 10⁻⁵, and the hyphen of a negative number a minus sign."""
    return re.sub(r"(?<![^\W\de])-(?=\d)", "−", _POWER.sub(_power_of_ten, text))


def printed_unit(units: str) -> str:
    """A unit as it is printed: ``m s-2`` becomes m s⁻²."""
    return re.sub(r"(?<=[^\W\d])-?\d+", lambda match: match[0].translate(RAISED), units)


def number(value: float, digits: int = 3) -> str:
    """A number with ``digits`` significant digits, ∞ for infinity, or a dash for NaN."""
    if math.isnan(value):
        return "–"
    # rounded first: with three digits, the format ``g`` alone would write 123,456 as 1.23 × 10⁵, not as 123000
    return printed(f"{float(f'{value:.{digits}g}'):g}".replace("inf", "∞"))


def at_most(value: float, digits: int = 1) -> str:
    """The least number with ``digits`` significant digits that is not below a value, for sentences that bound it."""
    if not 0 < value < math.inf:
        return number(value, digits)
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    return number(math.ceil(value / unit * (1 - 1e-9)) * unit, digits)


def up_to(value: float, digits: int = 3) -> str:
    """The largest number with ``digits`` significant digits that is not above a value, for limits that must be kept."""
    if not 0 < value < math.inf:
        return number(value, digits)
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    return number(math.floor(value / unit * (1 + 1e-7)) * unit, digits)


def typed(value: float, digits: int = 3) -> str:
    """A number with ``digits`` significant digits as Python and CSV files write it, or a dash for NaN."""
    return "–" if math.isnan(value) else f"{float(f'{value:.{digits}g}'):g}"


def measured(value: float, uncertainty: float) -> tuple[str, str]:
    """A value up to the first digit of its uncertainty, with at most seven digits, and the uncertainty to one digit."""
    digits = 7
    if value and 0 < uncertainty < math.inf:
        first, last = (math.floor(math.log10(x)) for x in (abs(value), float(f"{uncertainty:.1g}")))
        digits = min(max(first - last + 1, 1), 7)
    return f"{float(f'{value:.{digits}g}'):.15g}", typed(uncertainty, 1)


def step_size(step: float, spacing: float | None = None, digits: int = 3) -> str:
    """A step size, never rounded up, or a dash for NaN.

    A step with more than six significant digits is written as a fraction of ``spacing``, the time between samples, such
    as ``0.02/3``. If it is none, all but ``digits`` digits are cut off.
    """
    if math.isnan(step):
        return "–"
    if math.isclose(step, float(f"{step:.6g}"), rel_tol=1e-9):
        return typed(step, 6)
    if spacing and spacing > step and math.isclose(spacing / step, round(spacing / step), rel_tol=1e-9):
        return f"{spacing:.6g}/{round(spacing / step)}"
    unit = 10.0 ** (math.floor(math.log10(step)) - digits + 1)
    return typed(math.floor(step / unit) * unit, digits)


def step_with_unit(seconds: float, spacing: float | None = None) -> str:
    """A step size in s, ms or µs, never rounded up; see :func:`step_size`."""
    units = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}
    unit, size = next((entry for entry in units.items() if seconds >= entry[1] / 10), ("µs", 1e-6))
    return f"{step_size(seconds / size, None if spacing is None else spacing / size)}\u00a0{unit}"


def relative_to(value: str = "", components: int = 1, each: bool = False) -> str:
    """The value to which errors of a quantity are relative, by the name of its reduction; along time it is empty."""
    of = f" of {'each' if each else 'the largest'} component" if components > 1 else ""
    return f"relative to the {SCALED_BY[value]}{of}"


def percent(fraction: float) -> str:
    """A fraction in percent with a no-break space: 0 % if it is zero to round-off, and a dash for NaN."""
    if math.isnan(fraction):
        return "–"
    return f"{number(100 * fraction, 2)}\u00a0%" if abs(fraction) > _ZERO else "0\u00a0%"


def span(values: Any, form: str = ".2f") -> str:
    """The range of some values, such as ``0.10 to 0.25``, or one number if both ends are printed alike."""
    low, high = format(float(values.min()), form), format(float(values.max()), form)
    return low if low == high else f"{low} to {high}"


def listed(words: Iterable[str], separator: str = ", ") -> str:
    """A list of words in a sentence: a, b and c."""
    *others, last = words
    return f"{separator.join(others)} and {last}" if others else last


def text_of(value: object) -> str:
    """A text as HTML."""
    return html.escape(str(value))


def document(title: str, parts: Iterable[str], style: str) -> str:
    """A page of HTML that contains its style sheet and loads no other file."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
        f"<title>{text_of(title)}</title><style>\n{style}</style></head>\n"
        f"<body><main><h1>{text_of(title)}</h1>\n{''.join(parts)}</main></body></html>\n"
    )
