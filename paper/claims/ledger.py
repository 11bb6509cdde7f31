"""What a claim is, and how the datasets decide it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum

import xarray as xr

Data = Mapping[str, xr.Dataset]


class Verdict(StrEnum):
    """Outcome of a check."""

    REPRODUCED = "reproduced"
    QUALIFIED = "reproduced with a qualification"
    NOT_REPRODUCED = "not reproduced"


@dataclass(frozen=True)
class Finding:
    """Our value as a text, whether the claim holds, and what must be added if it holds only in part.

    ``qualification`` is stated whether the claim holds or not: with it a claim that holds is reproduced with a
    qualification, and for one that does not hold it is the reason.
    """

    ours: str
    holds: bool
    qualification: str = ""

    @property
    def verdict(self) -> Verdict:
        """Verdict out of ``holds`` and ``qualification``."""
        if not self.holds:
            return Verdict.NOT_REPRODUCED
        return Verdict.QUALIFIED if self.qualification else Verdict.REPRODUCED


@dataclass(frozen=True)
class Claim:
    """A statement of the paper in our words, the quantity that decides it, and the printed value."""

    section: str
    statement: str
    quantity: str
    printed: str
    check: Callable[[Data], Finding]


CLAIMS: list[Claim] = []


def claim(section: str, statement: str, quantity: str, printed: str = "") -> Callable:
    """Enter the decorated check into the ledger."""

    def enter(check: Callable[[Data], Finding]) -> Callable[[Data], Finding]:
        CLAIMS.append(Claim(section, statement, quantity, printed, check))
        return check

    return enter


def errors(data: Data, problem: str) -> xr.DataArray:
    """Largest energy errors with the paper's step sizes, over steps_per_period and scheme."""
    return data["energy_error"].max_energy_error.sel(period_used="printed", problem=problem)


def listed(values: Mapping[str, float], form: str = ".1f") -> str:
    """Names with their values: 'rk4: 1.0; houbolt: 97.3'."""
    return "; ".join(f"{name}: {value:{form}}" for name, value in values.items())


def by_name(array: xr.DataArray) -> dict[str, float]:
    """A one-dimensional array as a mapping from its coordinate to its values."""
    (dimension,) = array.dims
    return dict(zip(array[dimension].values.tolist(), array.values.tolist(), strict=True))
