"""The steps that make figures, pages, tables, claims, numbers and texts, derived from the declarations of the paper."""

from collections.abc import Iterable
from pathlib import Path

from paper.manuscript import SHARED, TEXTS
from paper.products import Product
from pipeline.sources import Sources
from pipeline.step import Step, job

#: Folder and file formats of the kinds whose products have one job each; the report shows the last format.
_FILES = {"figure": ("results/figures", ("pdf", "png", "csv", "svg")), "page": ("results", ("html",))}
#: Module that makes all products of a kind in one job, and its output: a file, or a folder of files in some formats.
_WHOLES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "table": ("tables", "results/tables", ("csv", "tex")),
    "claim": ("claims", "results/claims.csv", ()),
    "numbers": ("numbers", "results/numbers.json", ()),
}
#: Headings in the report. The key is the name of a product or, for other products, their kind.
_HEADINGS = {
    "explorer": "Explorer",
    "tables": "Tables",
    "claims": "Ledger of claims",
    "claim": "Ledger of claims",
    "table": "Tables",
    "figure": "Figures",
    "page": "Pages",
}
#: Suffixes of the products that the texts include.
_INCLUDED = (".pdf", ".csv", ".json")


def _data(products: Iterable[Product]) -> list[str]:
    return [f"results/{file}" for product in products for file in product.files]


def _step_with_many_jobs(kind: str, products: list[Product], sources: Sources) -> Step:
    """The step that makes all figures or pages, with one job for each."""
    folder, formats = _FILES[kind]
    jobs = {
        product.name: job(
            ["paper.products", product.module, product.name, "results", f"{folder}/{product.name}.{formats[0]}"],
            [*_data([product]), *sources.of([product.module, "paper.products"])],
        )
        for product in products
    }
    outputs = tuple(f"{folder}/{{job}}.{form}" for form in formats)
    listed = {product.name: (_HEADINGS.get(product.name, _HEADINGS[kind]), product.caption) for product in products}
    return Step(kind, kind.capitalize(), outputs, jobs, report={outputs[-1]: listed}, group="paper")


def _step_with_one_job(kind: str, products: list[Product], sources: Sources) -> Step:
    """The step that makes all tables, claims or numbers in one job: each takes less time than starting a process."""
    name, output, formats = _WHOLES[kind]
    outputs = tuple(f"{output}/{product.name}.{form}" for product in products for form in formats) or (output,)
    modules = [f"paper.{name}.__main__", *(product.module for product in products)]
    task = job([f"paper.{name}", "results", output], [*_data(products), *sources.of(modules)])
    listed = {file: {"": (_HEADINGS[kind], file.removeprefix("results/"))} for file in outputs if file.endswith(".csv")}
    return Step(name, name.capitalize(), outputs, {"": task}, quick=True, report=listed)


def steps_of(products: list[Product], root: Path, sources: Sources) -> list[Step]:
    """The steps that make all products and the texts."""
    by_kind = {kind: [product for product in products if product.kind == kind] for kind in (*_FILES, *_WHOLES)}
    steps = [_step_with_many_jobs(kind, by_kind[kind], sources) for kind in _FILES]
    steps += [_step_with_one_job(kind, by_kind[kind], sources) for kind in _WHOLES]
    included = [file for step in steps for file in step.products if file.endswith(_INCLUDED)]
    included = [file for file in included if not (file.endswith(".csv") and file.startswith("results/figures/"))]
    names = ["paper/references.bib", "CITATION.cff", *(f"paper/text/{path.name}" for path in (*TEXTS, *SHARED))]
    texts = [root / name for name in names]
    task = job(["paper.compile", "results", "results"], [*included, *texts, *sources.of(["paper.compile"])])
    outputs = tuple(f"results/{path.stem}.pdf" for path in TEXTS)
    listed = {file: {"": ("Article", Path(file).stem)} for file in outputs}
    outputs += ("results/README.md",)
    return [
        *steps,
        Step("manuscript", "Article, supplement and replication", outputs, {"": task}, quick=True, report=listed),
    ]


def check_datasets(label: str, files: Iterable[str], datasets: Iterable[str]) -> None:
    """Refuse a product that reads a dataset which the configuration does not make.

    Raises
    ------
    ValueError
        If the configuration does not make such a dataset; the message names the product and the dataset.
    """
    names = {f"{name}.nc" for name in datasets}
    for file in files:
        if file.endswith(".nc") and file not in names:
            name = file.removesuffix(".nc")
            raise ValueError(f"{label} reads '{name}', a dataset that this configuration does not make.")


def check_places(products: Iterable[Product]) -> None:
    """Refuse a table, claim or number that lies outside the folder of its kind.

    Raises
    ------
    ValueError
        If a product lies outside the folder; the message names the product and the folder.
    """
    for product in products:
        folder, *_ = _WHOLES.get(product.kind, ("",))
        if not product.module.startswith(f"paper.{folder}"):
            raise ValueError(f"{product.label} is declared in {product.module}: move it to paper/{folder}.")
