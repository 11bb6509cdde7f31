"""The part of the pipeline that makes figures, tables and text, as JSON: ``python -m paper.plan ROOT < PLAN``.

It reads the plan of the datasets, as ``study.pipeline.plan`` prints it, and prints the steps of the paper.
"""

import json
import shlex
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import grimp

from paper.manuscript import LAYOUT, TEXTS
from paper.products import Product, check, discover

#: Folder and formats of each kind of product that is a file of its own; the report of the pipeline shows the last.
FILES = {"figure": ("results/figures", ("pdf", "png", "svg")), "page": ("results", ("html",))}
#: Headings of the report by name of a page, by output of a step, and by kind of product.
HEADINGS = {
    "explorer": "Explorer",
    "tables": "Tables",
    "claims": "Ledger of claims",
    "results/claims.csv": "Ledger of claims",
    "table": "Tables",
    "figure": "Figures",
    "page": "Pages",
}
#: Module that makes all products of a kind at once, where it writes, and the formats if each product has its own files.
WHOLES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "table": ("tables", "results/tables", ("csv", "tex")),
    "claim": ("claims", "results/claims.csv", ()),
    "numbers": ("numbers", "results/numbers.json", ()),
}
#: What lies beside the modules that read it.
BESIDE = (".csv", ".js", ".css", ".html")
#: Formats that the texts include, their sources beside the modules, and what they become.
INCLUDED = (".pdf", ".csv", ".json")
SOURCES = ["paper/references.bib", "CITATION.cff", *(f"paper/text/{path.name}" for path in [*TEXTS, LAYOUT])]
PDFS = [f"results/{path.stem}.pdf" for path in TEXTS]


class _Sources:
    """The files of modules of the paper and of all modules that these import."""

    def __init__(self, root: Path):
        self._root, self._graph = root, grimp.build_graph("paper", cache_dir=None)

    def of(self, *modules: str) -> list[str]:
        found = set(modules).union(*map(self._graph.find_upstream_modules, modules))
        styles = [self._root / "paper" / "style.mplstyle"] if "paper.figures.style" in found else []
        paths = [self._root.joinpath(*name.split(".")) for name in sorted(found)]
        files = [path / "__init__.py" if path.is_dir() else path.with_suffix(".py") for path in paths]
        # beside the modules lie numbers that were printed in 1996, and what the page consists of
        beside = (path for folder in {path.parent for path in files} for path in folder.glob("*.*"))
        return [str(path) for path in [*files, *styles, *sorted(path for path in beside if path.suffix in BESIDE)]]


def _step(name: str, message: str, outputs: Iterable[str], jobs: dict[str, dict], **more: Any) -> dict[str, Any]:
    return {"name": name, "message": message, "outputs": list(outputs), "jobs": jobs, **more}


def _job(arguments: Iterable[str], inputs: Iterable[str]) -> dict[str, Any]:
    return {"command": shlex.join(["python", "-m", *arguments]), "inputs": list(dict.fromkeys(inputs))}


def _of_each(kind: str, products: list[Product], sources: _Sources) -> dict[str, Any]:
    """The step that makes every figure or page, a job each."""
    folder, formats = FILES[kind]
    chosen = [one for one in products if one.kind == kind]

    def job(one: Product) -> dict[str, Any]:
        arguments = ("paper.products", one.module, one.name, "results", f"{folder}/{one.name}.{formats[0]}")
        return _job(arguments, [*_data(one), *sources.of(one.module, "paper.products")])

    outputs = [f"{folder}/{{job}}.{form}" for form in formats]
    listed = {one.name: (HEADINGS.get(one.name, HEADINGS[kind]), one.caption) for one in chosen}
    jobs = {one.name: job(one) for one in chosen}
    return _step(kind, kind.capitalize(), outputs, jobs, report={outputs[-1]: listed}, group="paper")


def _of_all(kind: str, products: list[Product], sources: _Sources) -> dict[str, Any]:
    """The step that makes all tables, claims or numbers, which take less time than a process to start."""
    name, output, formats = WHOLES[kind]
    chosen = [one for one in products if one.kind == kind]
    outputs = [f"{output}/{one.name}.{form}" for one in chosen for form in formats] or [output]
    files = [file for one in chosen for file in _data(one)]
    modules = sources.of(f"paper.{name}.__main__", *(one.module for one in chosen))
    job = _job((f"paper.{name}", "results", output), [*files, *modules])
    headings = {file: HEADINGS.get(file, HEADINGS.get(kind, "")) for file in outputs if file.endswith(".csv")}
    listed = {file: {"": (heading, file.removeprefix("results/"))} for file, heading in headings.items()}
    return _step(name, name.capitalize(), outputs, {"": job}, quick=True, report=listed)


def _data(product: Product) -> list[str]:
    return [f"results/{file}" for file in product.files]


def _made_by(steps: Iterable[dict[str, Any]]) -> list[str]:
    return [output.replace("{job}", job) for step in steps for output in step["outputs"] for job in step["jobs"]]


def steps_of(products: list[Product], root: Path) -> list[dict[str, Any]]:
    """The steps that make all products and the manuscript."""
    sources = _Sources(root)
    steps = [_of_each(kind, products, sources) for kind in FILES]
    steps += [_of_all(kind, products, sources) for kind in WHOLES]
    included = [file for file in _made_by(steps) if file.endswith(INCLUDED)]
    inputs = [*included, *(str(root / name) for name in SOURCES), *sources.of("paper.compile")]
    job = _job(("paper.compile", "results", "results"), inputs)
    listed = {file: {"": ("Article", Path(file).stem)} for file in PDFS}
    return [*steps, _step("manuscript", "Article and supplement", PDFS, {"": job}, quick=True, report=listed)]


def check_datasets(products: Iterable[Product], datasets: Iterable[str]) -> None:
    """Refuse a product that reads a dataset which the configuration does not make.

    Raises
    ------
    ValueError
        With one sentence that names both.
    """
    known = set(datasets)
    for one in products:
        for file in one.files:
            if file.endswith(".nc") and file.removesuffix(".nc") not in known:
                name = file.removesuffix(".nc")
                raise ValueError(f"{one.label} reads '{name}', a dataset that this configuration does not make.")


def check_places(products: Iterable[Product]) -> None:
    """Refuse a table, claim or number outside of the folder in which its kind is looked for.

    Raises
    ------
    ValueError
        With one sentence that names the folder.
    """
    for one in products:
        folder, *_ = WHOLES.get(one.kind, ("",))
        if not one.module.startswith(f"paper.{folder}"):
            raise ValueError(
                f"{one.label} is declared in {one.module} and looked for in paper/{folder}: move it there."
            )


def main(root: str) -> None:
    """Print the steps, or end with one sentence that says what the paper lacks.

    Raises
    ------
    SystemExit
        If the paper asks of the configuration what is not there.
    """
    plan = json.load(sys.stdin)
    try:
        products = discover()
        check_places(products)
        check_datasets(products, plan["datasets"])
        check(products, plan["configuration"])
    except ValueError as error:
        raise SystemExit(str(error)) from None
    steps = steps_of(products, Path(root))
    print(json.dumps({"products": _made_by(steps), "steps": steps}))


if __name__ == "__main__":
    main(*sys.argv[1:])
