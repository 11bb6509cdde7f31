"""The datasets that the site reads, as the paper does: by name, whole, and only those of the study."""

from pathlib import Path
from typing import Any

from paper.products import reader

#: Datasets and tables that pages of schemes read, by their names in the results.
OF_SCHEMES = (
    "accuracy",
    "energy_error",
    "kinks",
    "large_steps",
    "stability/atlas",
    "stability/robustness",
    "work_precision",
)


class Data:
    """Datasets of a folder of results, each read once.

    Parameters
    ----------
    results
        The folder.
    names
        Names that may be read; the pipeline makes a page again when one of them changes.
    """

    def __init__(self, results: Path, names: tuple[str, ...]):
        self._read, self._names = reader(results), names

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(f"the site reads '{name}' without declaring it.")
        return self._read(name)
