"""Claims, their declaration, and their verdicts from the datasets."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import xarray as xr

from paper.asks import OF_THE_TABLES
from paper.claims.terms import MOST
from paper.data import of_the_paper
from paper.products import Product, declare
from paper.published import PROBLEMS, SCHEMES

Data = Mapping[str, xr.Dataset]


class Verdict(StrEnum):
    """Outcome of a check."""

    REPRODUCED = "reproduced"
    QUALIFIED = "reproduced with a qualification"
    NOT_REPRODUCED = "not reproduced"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Finding:
    """Our value as a text, whether the claim holds, and a qualification.

    A claim that holds with a qualification is reproduced with that qualification. If a claim does not hold, its
    qualification is the reason. A claim that the noise of measured times leaves open is not decided.
    """

    ours: str
    holds: bool
    qualification: str = ""
    decided: bool = True

    @property
    def verdict(self) -> Verdict:
        """Verdict from ``decided``, ``holds`` and ``qualification``."""
        if not self.decided:
            return Verdict.UNDECIDED
        if not self.holds:
            return Verdict.NOT_REPRODUCED
        return Verdict.QUALIFIED if self.qualification else Verdict.REPRODUCED


@dataclass(frozen=True)
class Claim:
    """A claim, and the product that checks it.

    Attributes
    ----------
    section
        Number of a section of the paper, or a name in ``OURS``.
    whose
        Who makes the claim: ``XIE`` if it is the paper's.
    statement, words
        The claim in our words, and in a few of the paper's own. Others are not quoted.
    quantity, printed
        The quantity that decides the claim, and its value in the paper, if it is printed there.
    product
        The check.
    """

    section: str
    whose: str
    statement: str
    words: str
    quantity: str
    printed: str
    product: Product


class Declared(dict[str, xr.Dataset]):
    """The datasets that a claim declares, by name."""

    def __init__(self, statement: str, datasets: Mapping[str, xr.Dataset]):
        super().__init__(datasets)
        self.statement = statement

    def __missing__(self, name: str) -> xr.Dataset:
        """Refuse any other dataset."""
        raise ValueError(f"The claim '{self.statement}' reads the dataset '{name}', which it does not declare.")


CLAIMS: list[Claim] = []
#: Who makes a claim: the paper of 1996; its verdicts where it did not compute; common practice; this study.
XIE, XIE_EXTENDED, PRACTICE, STUDY = "Xie", "Xie, extended", "practice", "this study"
#: Sections with claims that are not in the paper, and the prefix of their numbers in the text.
OURS = {"materials": "material_claims", "stability": "stability_claims", "structures": "structure_claims"}
_SECTION_OF_THE_PAPER = re.compile(r"[1-5](\.[1-9])?")
#: Datasets over the schemes of 1996, and of later ones if the configuration says so.
_OVER_SCHEMES = ("accuracy", "cpu_time", "energy_error", "large_steps", "sensitivity", "spectral", "phase_portrait/")


def claim(
    section: str,
    statement: str,
    quantity: str,
    printed: str = "",
    *,
    words: str = "",
    whose: str = STUDY,
    reads: Sequence[str],
    asks: Mapping[str, Any] | None = None,
) -> Callable:
    """Enter the decorated check into the ledger.

    The check takes the datasets that it reads by name. Those of a claim of the paper are cut to the paper's schemes,
    and the configuration must have them all; those of our claims are whole.

    Parameters
    ----------
    section, statement, quantity, printed, words
        As the attributes of :class:`Claim`. A claim of the paper needs its ``words``, any other has none.
    whose
        Who makes the claim, if not the paper.
    reads
        Names of the datasets that the check reads.
    asks
        Requirements on the configuration, as :data:`paper.products.Asks`.

    Raises
    ------
    ValueError
        If the section is neither the paper's nor one in ``OURS``, or a claim of the paper is not quoted.
    """
    from_the_paper = _SECTION_OF_THE_PAPER.fullmatch(section) is not None
    if not from_the_paper and section not in OURS:
        raise ValueError(
            f"The claim '{statement}' is in section '{section}', which is neither numbered as the paper's nor one of "
            f"{', '.join(OURS)}."
        )
    if from_the_paper != bool(words):
        raise ValueError(f"The claim '{statement}' must quote the paper if it is in a section of it, and only then.")

    def enter(check: Callable[[Data], Finding]) -> Callable[[Data], Finding]:
        def decided(**datasets: xr.Dataset) -> Finding:
            seen = {name: _cut(dataset) if from_the_paper else dataset for name, dataset in datasets.items()}
            return check(Declared(statement, seen))

        if isinstance(reads, str):
            raise ValueError(f"{check.__module__}: claim '{check.__name__}' reads a list of datasets, not {reads!r}.")
        own: dict[str, Any] = {}
        for name in reads:
            if name.startswith(_OVER_SCHEMES):
                own[f"{name.replace('/', '.')}.schemes"] = SCHEMES
            if name == "energy_error":
                own |= OF_THE_TABLES
            if name == "cpu_time":
                own["cpu_time.problems"] = PROBLEMS
        product = Product(
            kind="claim",
            name=f"{check.__module__}:{check.__name__}",
            module=check.__module__,
            function=decided,
            reads={name: name for name in reads},
            caption=statement,
            asks=(own if from_the_paper else {}) | dict(asks or {}),
        )
        declare(product)
        said_by = XIE if from_the_paper else whose
        CLAIMS.append(Claim(section, said_by, statement, words, quantity, printed, product))
        return check

    return enter


def _cut(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset with all schemes of the paper cut to them; any other dataset as it is."""
    has_all = "scheme" in dataset.dims and set(SCHEMES) <= set(dataset.scheme.values)
    return of_the_paper(dataset) if has_all else dataset


def errors(data: Data, problem: str) -> xr.DataArray:
    """Largest energy errors with the paper's step sizes, over steps_per_period and scheme."""
    return data["energy_error"].max_energy_error.sel(period_used="printed", problem=problem)


def most(cells: Mapping[str, bool]) -> tuple[bool, list[str]]:
    """Whether a statement holds in most of the cells that it speaks of, and the cells in which it does not."""
    exceptions = [name for name, holds in cells.items() if not holds]
    return len(exceptions) < (1 - MOST) * len(cells), exceptions


def by_name(array: xr.DataArray) -> dict[str, float]:
    """A one-dimensional array as a mapping from its coordinate to its values."""
    (dimension,) = array.dims
    return dict(zip(array[dimension].values.tolist(), array.values.tolist(), strict=True))
