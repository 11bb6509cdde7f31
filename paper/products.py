"""Figures, tables, numbers, claims and pages of the paper, each declared where it is made.

A declaration decorates the function that returns the product. An argument of this function takes the dataset of its
name, unless the declaration names another. A declaration may have a caption, and requirements on the configuration. The
pipeline finds all declarations with :func:`discover`. One figure or page is made with ``python -m paper.products MODULE
NAME RESULTS OUTPUT``, and a figure at another width with ``--width MM``.
"""

import argparse
import functools
import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from paper.requirements import value_at
from study.io import one_sentence, read, write

#: Requirements on the configuration by dotted key. The value at the key must contain all entries of a required list. A
#: function checks the value, as :mod:`paper.requirements` describes. Any other required object must equal the value.
#: The key "" stands for the whole configuration. A key that leads into a list of mappings stands for the list of their
#: values.
Requirements = Mapping[str, Any]
#: Name of the dataset that each argument of a function takes, or a list of names.
Reads = Mapping[str, str | Sequence[str]]
#: Folders and modules of ``paper`` that hold declarations.
PLACES = ("claims", "explorer", "figures", "manuscript", "numbers", "pages", "tables")


@dataclass(frozen=True)
class Product:
    """A figure, table, page, set of numbers or claim; or the text of the manuscript, which only has requirements.

    Attributes
    ----------
    kind, name, module
        ``figure``, ``table``, ``page``, ``numbers``, ``claim`` or ``text``; the name of the product; the module that
        declares it.
    function
        Function of the datasets in ``reads`` that returns the product.
    reads
        Name of the dataset that each argument takes, or a list of names. A name with a suffix is a file of the results
        in another format.
    caption
        Sentence for the report of the pipeline; the title of a table.
    requires
        Requirements on the configuration.
    """

    kind: str
    name: str
    module: str
    function: Callable
    reads: Reads
    caption: str
    requires: Requirements

    @property
    def datasets(self) -> list[str]:
        """Names of all datasets and files that the product reads."""
        return [name for names in self.reads.values() for name in ([names] if isinstance(names, str) else names)]

    @property
    def files(self) -> list[str]:
        """The files below the results that the product reads."""
        return [name if Path(name).suffix else f"{name}.nc" for name in self.datasets]

    @property
    def title(self) -> str:
        """The title of a table: its caption, or its name in words."""
        return self.caption or self.name.replace("_", " ").capitalize()

    @property
    def label(self) -> str:
        """Kind and name, for messages."""
        return f"{self.kind} '{self.name}'"


PRODUCTS: dict[tuple[str, str], Product] = {}


def enter(product: Product) -> None:
    """Add a product to ``PRODUCTS``.

    Raises
    ------
    ValueError
        If another product of the same kind has the same name.
    """
    known = PRODUCTS.setdefault((product.kind, product.name), product)
    if known is not product:
        raise ValueError(f"{product.label} is declared twice, in {known.module} and in {product.module}.")


def reads_of(function: Callable, datasets: Reads) -> Reads:
    """Name of the dataset for each argument of a function: the given name, or else the name of the argument.

    Raises
    ------
    ValueError
        If datasets are given for arguments that the function does not have.
    """
    signature = inspect.signature(function)
    defaults = {
        name: name for name, argument in signature.parameters.items() if argument.kind is not argument.VAR_KEYWORD
    }
    try:
        signature.bind(**defaults | dict(datasets))
    except TypeError as error:
        raise ValueError(f"The datasets given do not fit {function.__module__}.{function.__name__}: {error}.") from None
    return defaults | dict(datasets)


def _declared(kind: str, name: str, caption: str, requires: Requirements | None, datasets: Reads) -> Callable:
    def declare(function: Callable) -> Callable:
        module = function.__module__
        named = name or (f"{module}.{function.__name__}" if kind == "numbers" else module.rpartition(".")[-1])
        enter(Product(kind, named, module, function, reads_of(function, datasets), caption, requires or {}))
        return function

    return declare


def figure(
    caption: str, *, name: str = "", requires: Requirements | None = None, **reads: str | Sequence[str]
) -> Callable:
    """Declare a figure that a function of datasets draws. The default name is the name of the module."""
    return _declared("figure", name, caption, requires, reads)


def table(
    title: str = "", *, name: str = "", requires: Requirements | None = None, **reads: str | Sequence[str]
) -> Callable:
    """Declare a table that a function of datasets returns as a frame. The default name is the name of the module."""
    return _declared("table", name, title, requires, reads)


def page(
    caption: str, *, name: str = "", requires: Requirements | None = None, **reads: str | Sequence[str]
) -> Callable:
    """Declare a page that a function of datasets returns as HTML. The default name is the name of the module."""
    return _declared("page", name, caption, requires, reads)


def numbers(*, requires: Requirements | None = None, **reads: str | Sequence[str]) -> Callable:
    """Declare numbers of the text, which a function of datasets returns by name."""
    return _declared("numbers", "", "", requires, reads)


def discover(places: Iterable[str] = PLACES) -> list[Product]:
    """Import the modules in some places of the paper, and return their products, sorted by kind and name."""
    for place in places:
        package = importlib.import_module(f"paper.{place}")
        for module in pkgutil.iter_modules(getattr(package, "__path__", []), f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)
    prefixes = tuple(f"paper.{place}" for place in places)
    products = [product for product in PRODUCTS.values() if product.module.startswith(prefixes)]
    return sorted(products, key=lambda product: (product.kind, product.name))


def check(products: Iterable[Product], config: dict) -> None:
    """Refuse a configuration that does not meet a requirement of a product.

    Raises
    ------
    ValueError
        If a requirement is not met. The message is one sentence that names the key. If the requirement is a function
        of an existing value, the function words the message. Every other message also names the product.
    """
    for product in products:
        for key, requirement in product.requires.items():
            try:
                value = value_at(config, key)
            except (KeyError, TypeError):
                raise ValueError(f"{key} is missing, and {product.label} needs it.") from None
            if callable(requirement):
                if wrong := requirement(value):
                    raise ValueError(f"{key} {wrong}.".lstrip())
            elif isinstance(requirement, list) and not isinstance(value, list):
                raise ValueError(f"{key} must be a list for {product.label}, not {value!r}.")
            elif isinstance(requirement, list):
                missing = [entry for entry in requirement if entry not in value]
                if missing:
                    raise ValueError(f"{key} lacks {missing[0]!r}, which {product.label} needs.")
            elif value != requirement:
                raise ValueError(f"{key} must be {requirement!r} for {product.label}, not {value!r}.")


def reader(results: Path) -> Callable[[str], Any]:
    """A function that reads a dataset or another file of the results by name, each file once."""
    return functools.cache(lambda name: read(results / (name if Path(name).suffix else f"{name}.nc")))


def content_of(product: Product, read: Callable[[str], Any]) -> Any:
    """Read the datasets of a product, and return the result of its function."""
    return product.function(
        **{
            argument: read(names) if isinstance(names, str) else [read(name) for name in names]
            for argument, names in product.reads.items()
        }
    )


@one_sentence()
def main(module: str, name: str, results: str, output: str, width: float | None = None) -> None:
    """Make one figure, in all its formats next to ``output``, or one page.

    A figure has its own width unless ``width`` gives another in millimetres.

    Raises
    ------
    SystemExit
        If the module has no such product, if a width is given for a page, or if the function of a figure does not
        return a figure. The message is one sentence.
    """
    importlib.import_module(module)
    matches = [product for product in PRODUCTS.values() if product.module == module and product.name == name]
    if not matches:
        raise SystemExit(f"{module} declares no product '{name}'.")
    (product,) = matches
    if product.kind != "figure":
        if width is not None:
            raise SystemExit(f"{product.label} has no width.")
        write(content_of(product, reader(Path(results))), output)
        return
    # imported by name, so that only figures depend on the source of the style
    style = importlib.import_module("paper.figures.style")
    picture = content_of(product, reader(Path(results)))
    if not hasattr(picture, "savefig"):
        raise SystemExit(f"{product.label} must return a figure, not {picture!r}.")
    style.save(picture if width is None else style.at_width(picture, width), Path(output))


def _width(text: str) -> float:
    """A width in millimetres between 20 and 2000."""
    with suppress(ValueError):
        if 20 <= float(text) <= 2000:
            return float(text)
    raise argparse.ArgumentTypeError(f"'{text}' is not a number of millimetres between 20 and 2000")


if __name__ == "__main__":
    from paper import products  # declarations enter this module and not its copy ``__main__``

    parser = argparse.ArgumentParser("python -m paper.products", description="Make one figure or page.")
    for argument in ("module", "name", "results", "output"):
        parser.add_argument(argument)
    parser.add_argument(
        "--width", type=_width, metavar="MM", help="width of a figure in millimetres, in place of its own"
    )
    products.main(**vars(parser.parse_args()))
