"""``python -m paper.numbers RESULTS OUTPUT`` gathers every number and fact of the text into a JSON file."""

import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from paper.printing import printed
from paper.products import Product, discover, made, reader
from paper.writing import write


def gathered(products: Iterable[Product], read: Callable[[str], Any]) -> dict[str, str | bool | None]:
    """All numbers by name, as texts; facts as true or false; None for what the study has not made.

    Raises
    ------
    ValueError
        If two functions give a number of one name.
    """
    owner: dict[str, str] = {}
    texts: dict[str, str | bool | None] = {}
    for product in products:
        for name, value in made(product, read).items():
            if name in owner:
                raise ValueError(f"The number '{name}' is given by {owner[name]} and by {product.name}.")
            owner[name] = product.name
            if isinstance(value, bool | np.bool_):
                texts[name] = bool(value)
            else:
                texts[name] = value if value is None else printed(str(value))
    return texts


def main(results: Path, output: Path) -> None:
    """Write the numbers of a folder of results."""
    products = [product for product in discover(["numbers"]) if product.kind == "numbers"]
    write(output, json.dumps(gathered(products, reader(results)), indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
