"""Numbers and names as the ledger prints them: titles in place of code names, 10⁻⁵ in place of 1e-05, and no nan."""

import re
from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr

from study import words

#: First words of titles of schemes that are no names.
_COMMON = re.compile(r"\b(Average|Central|Energy|Extrapolation|Generalized|Implicit|Linear|Symplectic)(?=[ -])")


def number(value: float, form: str = ".1f", missing: str = "failed") -> str:
    """A number as a text with the minus sign − and powers of ten; ``missing`` in place of NaN."""
    if np.isnan(value):
        return missing
    return words.printed(f"{value:{form}}".replace("inf", "∞"))


def title(name: str, data: Mapping[str, xr.Dataset]) -> str:
    """The title of a scheme or problem in some datasets, or its name in plain words if the datasets have no title."""
    for dataset in data.values():
        for along in ("scheme", "problem"):
            if f"{along}_title" in dataset.coords:
                names, titles = (np.atleast_1d(dataset[coordinate].values) for coordinate in (along, f"{along}_title"))
                if name in names:
                    return str(titles[names == name][0])
        if dataset.attrs.get("problem") == name:
            return dataset.attrs["problem_title"]
    return name.replace("_", " ")


def in_sentence(text: str) -> str:
    """A text in which titles of schemes begin with a small letter, unless they begin with a name."""
    return _COMMON.sub(lambda word: word[0].lower(), text)


def joined(names: Iterable[str], data: Mapping[str, xr.Dataset]) -> str:
    """Titles as a list in words, separated by semicolons if a title has a comma; 'none' if there are no names."""
    titles = [title(name, data) for name in names] or ["none"]
    return words.listed(titles, "; " if any("," in text for text in titles) else ", ")


def listed(
    values: Mapping[str, float], data: Mapping[str, xr.Dataset], form: str = ".1f", missing: str = "failed"
) -> str:
    """Titles with their values, as one text."""
    return "; ".join(f"{title(name, data)}: {number(value, form, missing)}" for name, value in values.items())


def share_with(share: float, low: float, high: float) -> str:
    """A share in percent with its interval of 95 % confidence."""
    return f"{words.percent(share)} (95 % interval {words.percent(low)} to {words.percent(high)})"
