"""``python -m paper.numbers RESULTS OUTPUT`` gathers every number of the manuscript's text into a JSON file."""

import json
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from paper.products import Product, discover, made, reader
from paper.writing import write


def gathered(products: Iterable[Product], read: Callable[[str], Any]) -> dict[str, str]:
    """All numbers by name, as texts.

    Raises
    ------
    ValueError
        If two functions give a number of one name.
    """
    owner: dict[str, str] = {}
    texts: dict[str, str] = {}
    for product in products:
        for name, value in made(product, read).items():
            if name in owner:
                raise ValueError(f"The number '{name}' is given by {owner[name]} and by {product.name}.")
            owner[name] = product.name
            # a minus sign before numbers, but not for hyphens in names
            texts[name] = re.sub(r"(?<![^\W\de])-(?=\d)", "−", str(value))
    return texts


def main(results: Path, output: Path) -> None:
    """Write the numbers of a folder of results."""
    products = [product for product in discover(["numbers"]) if product.kind == "numbers"]
    write(output, json.dumps(gathered(products, reader(results)), indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
