"""``python -m paper.numbers RESULTS OUTPUT`` gathers every number and fact of the text into a JSON file."""

import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from paper.products import Product, content_of, discover, reader
from paper.wording import in_sentence
from study.io import one_sentence, write
from study.words import printed


def gathered(products: Iterable[Product], read: Callable[[str], Any]) -> dict[str, str | bool | None]:
    """All numbers of the products by name: numbers as texts, facts as true or false, and None for missing numbers.

    Raises
    ------
    ValueError
        If two functions give a number with the same name.
    """
    owner: dict[str, str] = {}
    texts: dict[str, str | bool | None] = {}
    for product in products:
        for name, value in content_of(product, read).items():
            if name in owner:
                raise ValueError(f"The number '{name}' is given by {owner[name]} and by {product.name}.")
            owner[name] = product.name
            fact = isinstance(value, bool | np.bool_)
            texts[name] = bool(value) if fact else None if value is None else printed(in_sentence(str(value)))
    return texts


def commits(products: Iterable[Product], read: Callable[[str], Any]) -> str | None:
    """Commits of all datasets that the products read; None if no commit is known.

    A commit to which uncommitted changes were added is marked.
    """
    reads = [names for product in products for names in product.reads.values()]
    names = {name for names in reads for name in ([names] if isinstance(names, str) else names)}
    described = {read(name).attrs.get("commit", "unknown") for name in names if not Path(name).suffix} - {"unknown"}
    commits = sorted(
        commit.removesuffix("-dirty")[:12] + (" with changes" if commit.endswith("-dirty") else "")
        for commit in described
    )
    return " and ".join(commits) or None


@one_sentence()
def main(results: Path, output: Path) -> None:
    """Write the numbers from a folder of results as JSON."""
    products = [product for product in discover(["numbers"]) if product.kind == "numbers"]
    read = reader(results)
    numbers = {**gathered(products, read), "commits": commits(products, read)}
    write(json.dumps(numbers, indent=1, ensure_ascii=False) + "\n", output)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
