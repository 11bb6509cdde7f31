"""``python -m paper.latex RESULTS FOLDER`` writes the texts as LaTeX sources with all that they include.

Pandoc reads the texts with a special layout, and a filter adds the parts that Pandoc omits. pdfLaTeX compiles the
sources.
"""

import shutil
import sys
import tempfile
from pathlib import Path

import pypandoc

from paper.manuscript import TEXTS, check_uses
from study.io import one_sentence, write

_HERE = Path(__file__).parent
_PAPER = _HERE.parent
_OPTIONS = ["--standalone", "--natbib", "--number-sections", "--wrap=preserve", "--metadata=bibliography:references"]
_OPTIONS += [f"--lua-filter={_HERE / 'filter.lua'}", f"--include-in-header={_HERE / 'header.tex'}"]
_OPTIONS += ["-Vbiblio-style=unsrtnat", "-Vnatbiboptions=numbers,sort&compress", "-Vgeometry=a4paper,margin=2.2cm"]


def converted(path: Path) -> str:
    """The LaTeX source of a text with its layout, numbers and tables in the same folder."""
    letter = ["-Vheader-includes=\\newcommand{\\letter}{S}"] if path.stem == "supplement" else []
    source = pypandoc.convert_file(str(path), "latex", format="typst", extra_args=[*_OPTIONS, *letter])
    # LaTeX prints the heading of the abstract itself, and does not support combining accents
    for text, latex in {"\\textbf{Abstract.} ": "", "u\u0307": "\\(\\dot u\\)", "u\u0308": "\\(\\ddot u\\)"}.items():
        source = source.replace(text, latex)
    return source


@one_sentence()
def main(results: Path, output: Path) -> None:
    """Write the sources, their bibliography and their figures into a folder.

    Raises
    ------
    SystemExit
        If a text uses a number, figure or table that the results lack.
    """
    (output / "figures").mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(_PAPER.parent / "CITATION.cff", folder)
        there = Path(shutil.copytree(_PAPER / "text", Path(folder, "paper", "text")))
        shutil.copytree(results / "tables", there / "tables")
        shutil.copy(results / "numbers.json", there)
        shutil.copy(_HERE / "layout.typ", there)
        for text in TEXTS:
            check_uses(text, results)
            write(converted(there / text.name), output / f"{text.stem}.tex")
    write((_PAPER / "references.bib").read_bytes(), output / "references.bib")
    for figure in sorted((results / "figures").glob("*.pdf")):
        write(figure.read_bytes(), output / "figures" / figure.name)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
