"""What the paper is made of: figures, tables, numbers and claims, each declared where it is made.

A declaration names the datasets that the product reads, by the arguments that take them, the caption, and what the
product asks of the configuration. The pipeline finds all declarations with :func:`discover`, and makes one product with
``python -m paper.products MODULE NAME RESULTS OUTPUT``.
"""

import importlib
import pkgutil
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

#: What is asked of the configuration, by dotted key: a list must contain these values, anything else must be the value;
#: a function of the value returns a sentence if it will not do.
Asked = Mapping[str, Any]


@dataclass(frozen=True)
class Product:
    """A figure, table, set of numbers or claim.

    Attributes
    ----------
    kind, name, module
        ``figure``, ``table``, ``numbers`` or ``claim``; its name; the module that declares it.
    function
        Makes the product of its datasets, given by the names in ``reads``.
    reads
        Argument: the dataset that it takes, by its name in the results, or a list of them. A name with a suffix is
        another file of the results.
    caption
        Sentence for the report of the pipeline.
    asks
        What must be in the configuration for the product to be right.
    """

    kind: str
    name: str
    module: str
    function: Callable
    reads: Mapping[str, str | Sequence[str]]
    caption: str
    asks: Asked

    @property
    def files(self) -> list[str]:
        """The files below the results that the product reads."""
        names = [name for one in self.reads.values() for name in ([one] if isinstance(one, str) else one)]
        return [name if Path(name).suffix else f"{name}.nc" for name in names]


PRODUCTS: dict[tuple[str, str], Product] = {}


def _declared(kind: str, name: str, caption: str, asks: Asked | None, reads: dict) -> Callable:
    def declare(function: Callable) -> Callable:
        module = _name_of(function)
        product = Product(kind, name or module.rpartition(".")[-1], module, function, reads, caption, asks or {})
        known = PRODUCTS.setdefault((kind, product.name), product)
        if known.module != module:
            raise ValueError(f"{kind} '{product.name}' is declared in {known.module} and in {module}.")
        return function

    return declare


def _name_of(function: Callable) -> str:
    """The module of a function."""
    return function.__module__


def figure(caption: str, *, name: str = "", asks: Asked | None = None, **reads: str | Sequence[str]) -> Callable:
    """Declare a figure, of the name of its module if no other is given: a function of datasets that draws it."""
    return _declared("figure", name, caption, asks, reads)


def table(*, name: str = "", asks: Asked | None = None, **reads: str | Sequence[str]) -> Callable:
    """Declare a table, of the name of its module if no other is given: a function of datasets that returns a frame."""
    return _declared("table", name, "", asks, reads)


def numbers(*, asks: Asked | None = None, **reads: str | Sequence[str]) -> Callable:
    """Declare numbers of the text: a function of datasets that returns them by name."""

    def declare(function: Callable) -> Callable:
        return _declared("numbers", f"{_name_of(function)}:{function.__name__}", "", asks, reads)(function)

    return declare


def discover() -> list[Product]:
    """All products of the paper, by kind and name."""
    for folder in ("claims", "figures", "numbers", "tables"):
        package = importlib.import_module(f"paper.{folder}")
        for module in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            importlib.import_module(module.name)
    return sorted(PRODUCTS.values(), key=lambda product: (product.kind, product.name))


def _read(results: Path, name: str) -> Any:
    """A dataset or another file of the results."""
    from paper.data import load, load_table

    return load_table(results / name) if Path(name).suffix == ".csv" else load(results / f"{name}.nc")


def made(product: Product, results: Path) -> Any:
    """What the function of a product returns for the datasets in a folder of results."""
    arguments = {
        argument: _read(results, name) if isinstance(name, str) else [_read(results, one) for one in name]
        for argument, name in product.reads.items()
    }
    return product.function(**arguments)


def main(module: str, name: str, results: str, output: str) -> None:
    """Make one figure or table and write it in all its formats, next to ``output``."""
    importlib.import_module(module)
    kind = module.split(".")[1].removesuffix("s")
    if kind == "figure":
        from paper.figures.style import save as write
    else:
        from paper.tables.writing import write
    write(made(PRODUCTS[kind, name], Path(results)), Path(output))


if __name__ == "__main__":
    from paper import products  # the module that the declarations know, which is not this one while it runs

    products.main(*sys.argv[1:])
