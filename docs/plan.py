"""The part of the pipeline that makes the site, as JSON: ``python -m docs.plan ROOT < PLAN``.

It reads the plan of the datasets, as ``study.pipeline.plan`` prints it, and prints the step of the site.
"""

import json
import shlex
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from docs.data import OF_SCHEMES
from docs.filled import reads_of_pages
from paper.plan import check_datasets
from paper.products import Product

#: Packages and files of the project that the pages tell of or include.
_TOLD = ("study", "docs", "paper/figures", "paper/published", "examples")
_FILES = ("paper/data.py", "paper/products.py", "paper/orders.py", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff")
#: Products that the site has beside its pages.
PRODUCTS = ("explorer.html", "manuscript.pdf", "supplement.pdf")


def sources(root: Path) -> list[str]:
    """The files that pages are made of, beside datasets."""
    within = (path for folder in _TOLD for path in sorted(root.joinpath(folder).rglob("*")))
    files = [path for path in within if path.is_file() and path.suffix != ".pyc"]
    return [str(path) for path in [*files, *(root / name for name in _FILES)]]


def steps_of(files: Iterable[str], own: Iterable[str], root: Path) -> list[dict[str, Any]]:
    """The step that makes the site of some files of the results and schemes of a user's own."""
    own = list(own)
    places = (place.rpartition(":")[0] for place in own)
    job = {
        "command": shlex.join(["python", "-m", "docs.build", "results", "results/site", *own]),
        "inputs": list(dict.fromkeys([*(f"results/{file}" for file in files), *sources(root), *places])),
    }
    return [{"name": "site", "message": "Site", "outputs": ["results/site/index.html"], "jobs": {"": job}}]


def main(root: str) -> None:
    """Print the step, or end with one sentence that says which dataset the site lacks.

    Raises
    ------
    SystemExit
        If the configuration does not make a dataset that the site reads.
    """
    plan = json.load(sys.stdin)
    site = Product(
        "page", "site", __name__, main, {"schemes": OF_SCHEMES, "pages": [*reads_of_pages(), *PRODUCTS]}, "", {}
    )
    try:
        check_datasets([site], plan["datasets"])
    except ValueError as error:
        raise SystemExit(str(error)) from None
    print(json.dumps({"steps": steps_of(site.files, plan["configuration"].get("own_schemes", []), Path(root))}))


if __name__ == "__main__":
    main(*sys.argv[1:])
