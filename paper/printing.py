"""How numbers are printed: powers of ten as such, and minus signs before numbers."""

import re

import xarray as xr

# no part of a word, such as the name of a commit, is a number
_POWER = re.compile(r"(?<![\w.])(\d(?:\.\d+)?)e([+-]?)0*(\d{1,3})(?!\w)")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _power_of_ten(match: re.Match) -> str:
    factor, sign, exponent = match.groups()
    if float(factor) == 0:
        return "0"
    raised = f"10{(sign.replace('+', '') + exponent).translate(_RAISED)}"
    # with no-break spaces
    return raised if factor == "1" else f"{factor}\u00a0×\u00a0{raised}"


def span(values: xr.DataArray, form: str = ".2f") -> str:
    """The smallest and the largest of some values, or one number if both are printed alike."""
    low, high = format(float(values.min()), form), format(float(values.max()), form)
    return low if low == high else f"{low} to {high}"


def printed(text: str) -> str:
    """A text as it is printed: ``5e-05`` as 5 × 10⁻⁵, and a minus sign before numbers, but no hyphen of a name."""
    return re.sub(r"(?<![^\W\de])-(?=\d)", "−", _POWER.sub(_power_of_ten, text))
