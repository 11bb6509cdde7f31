"""Claims, their declaration, and their verdicts from the datasets."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import xarray as xr

from paper.data import schemes_of_1996
from paper.products import Product, Requirements, enter, reads_of
from paper.published import SCHEMES
from paper.terms import MOST


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
    qualification is the reason. ``decided`` is false if the noise of measured times leaves the claim open.
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
        Source of the claim, such as an author; ``XIE`` for the paper of 1996.
    statement, words
        The claim in our words, and a short quotation. Only claims of the paper have a quotation.
    quantity, printed
        The quantity that decides the claim, and its value in the paper, if it is printed there.
    product
        Product that checks the claim.
    """

    section: str
    whose: str
    statement: str
    words: str
    quantity: str
    printed: str
    product: Product


CLAIMS: list[Claim] = []
#: Sources of claims: the paper of 1996; its verdicts, extended beyond its own runs; common practice; this study.
XIE, XIE_EXTENDED, PRACTICE, STUDY = "Xie", "Xie, extended", "practice", "this study"
#: Sections of claims that the paper does not make. The text quotes counts of the claims of a section under names that
#: begin with the given prefix.
OURS = {
    "adaptive": "adaptive_claims",
    "materials": "material_claims",
    "schemes": "scheme_claims",
    "stability": "stability_claims",
    "structures": "structure_claims",
}
#: Prefixes of names of datasets. If a claim of the paper reads such a dataset, the dataset must have all schemes of
#: 1996.
_OVER_SCHEMES = ("accuracy", "cpu_time", "energy_error", "large_steps", "sensitivity", "spectral", "phase_portrait/")


def claim(
    section: str,
    statement: str,
    quantity: str,
    printed: str = "",
    *,
    words: str = "",
    whose: str = STUDY,
    requires: Requirements | None = None,
    **reads: str | Sequence[str],
) -> Callable:
    """Enter the decorated check, a function of datasets, into the ledger.

    The check of a claim of the paper receives datasets with the paper's schemes only, and the configuration must have
    all of these schemes. Checks of other claims receive whole datasets.

    Parameters
    ----------
    section, statement, quantity, printed, words
        Attributes of :class:`Claim`. A claim of the paper needs ``words``; other claims have none.
    whose
        Source of the claim, ignored for a claim of the paper, whose source is ``XIE``.
    requires, reads
        As in :class:`paper.products.Product`.

    Raises
    ------
    ValueError
        If a claim of the paper has no quotation, or if a claim in a section of ``OURS`` has one.
    """
    from_the_paper = section not in OURS
    if from_the_paper != bool(words):
        raise ValueError(
            f"The claim '{statement}' is in section '{section}'. Claims in {', '.join(OURS)} quote nothing; any other "
            "section is one of the paper, and its claims need the paper's words."
        )

    def declare(check: Callable[..., Finding]) -> Callable[..., Finding]:
        read = reads_of(check, reads)
        product = Product("claim", statement, check.__module__, check, read, statement, requires or {})
        if from_the_paper:
            over_schemes = [name.replace("/", ".") for name in product.datasets if name.startswith(_OVER_SCHEMES)]
            needed = {f"{name}.schemes": SCHEMES for name in over_schemes} | dict(requires or {})
            product = replace(product, function=_on_schemes_of_1996(check), requires=needed)
        enter(product)
        CLAIMS.append(Claim(section, XIE if from_the_paper else whose, statement, words, quantity, printed, product))
        return check

    return declare


def _on_schemes_of_1996(check: Callable[..., Finding]) -> Callable[..., Finding]:
    """The check, on datasets reduced to the schemes of the paper. A dataset that lacks one of these is not reduced."""

    def cut(data: Any) -> Any:
        over_schemes = isinstance(data, xr.Dataset) and "scheme" in data.dims
        return schemes_of_1996(data) if over_schemes and set(SCHEMES) <= set(data.scheme.values) else data

    return lambda **datasets: check(**{name: cut(data) for name, data in datasets.items()})


def errors(energy_error: xr.Dataset, problem: str) -> xr.DataArray:
    """Largest energy errors in percent on a problem, over (steps_per_period, scheme), with the printed period."""
    return 100 * energy_error.max_energy_error.sel(period_used="printed", problem=problem)


def most(cells: Mapping[str, bool]) -> tuple[bool, list[str]]:
    """Whether a statement holds in most of its cells, and the names of the cells in which it does not hold."""
    exceptions = [name for name, holds in cells.items() if not holds]
    return len(exceptions) < (1 - MOST) * len(cells), exceptions


def when(condition: object, sentence: str) -> str:
    """The sentence if the condition holds, and an empty text otherwise."""
    return sentence if condition else ""


def by_name(array: xr.DataArray) -> dict[str, float]:
    """A one-dimensional array as a mapping from its coordinate to its values."""
    (dimension,) = array.dims
    return dict(zip(array[dimension].values.tolist(), array.values.tolist(), strict=True))
