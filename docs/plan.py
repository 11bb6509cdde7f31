"""The inputs of the site."""

import re
from pathlib import Path

from paper.products import discover

PAGES = Path(__file__).parent / "pages"
#: Datasets that pages of schemes read.
SCHEME_DATASETS = (
    "accuracy",
    "energy_error",
    "kinks",
    "large_steps",
    "order_under_reality",
    "stability/atlas",
    "structures",
    "work_precision",
    "needs",
)
#: File of the article's numbers.
NUMBERS = "numbers.json"
#: Declarations of all tables of the study, and the name of the table of claims.
TABLES, LEDGER = tuple(product for product in discover(["tables"]) if product.kind == "table"), "claims"
#: Declarations of all figures of the study.
FIGURES = tuple(product for product in discover(["figures"]) if product.kind == "figure")
#: Files of the results that are copied into the site.
PRODUCTS = ("explorer.html", "manuscript.pdf", "supplement.pdf", "replication.pdf", "assessment/driven.html")

#: Folders and files of the project that pages show or document.
_FOLDERS = ("study", "docs", "examples", "conformance/verdicts", "conformance/reports")
_FILES = ("CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "conformance/README.md")


def shown(root: Path) -> list[Path]:
    """The files of the project that pages show or document."""
    within = (path for folder in _FOLDERS for path in sorted(root.joinpath(folder).rglob("*")) if path.is_file())
    # caches of Python and of ruff are not sources
    files = [path for path in within if path.suffix != ".pyc" and ".ruff_cache" not in path.parts]
    return [*files, *(root / name for name in _FILES)]


def reads() -> list[str]:
    """The files of the results that the site reads."""
    questions = "\n".join(page.read_text(encoding="utf-8") for page in sorted(PAGES.glob("gallery/*.md")))
    opened = re.findall(r'study\.open_dataset\("([\w/]+)"\)', questions)
    datasets = dict.fromkeys([*SCHEME_DATASETS, "decisions", "spectral", "spectrum", "runs/yielding", *opened])
    figures = [f"figures/{figure.name}.svg" for figure in FIGURES]
    tables = [f"tables/{table.name}.csv" for table in TABLES]
    return [*(f"{name}.nc" for name in datasets), *figures, NUMBERS, *tables, *PRODUCTS]
