"""Tables as LaTeX."""

import re
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest

import paper
from paper.products import Product
from paper.tables.tex import _DOTS, _SET, tex

PAPER = Path(paper.__file__).parent
#: Characters that pdfLaTeX sets by itself.
SET = set("–—‘’“”äöüÜøóíé×±½·†…")
FRAME = pd.DataFrame(
    {"Scheme & step": ["Wilson-θ, ü and u̇", "HHT_α"], "10 %": ["≤\u00a010 (ωΔt\u00a01.7\u00a0×\u00a010⁻⁶)", "–"]}
)
PRODUCT = Product("table", "steps", "here", lambda: FRAME, {}, "Steps at 1 %", {})


def test_a_table_says_what_it_is_and_what_it_needs():
    source = tex(PRODUCT, FRAME)
    first, *_ = source.splitlines()
    assert first == "% Table 'steps' of the study: Steps at 1 %. In the preamble: \\usepackage{booktabs}"
    assert "\\caption{Steps at 1 \\%}" in source and "\\label{tab:steps}" in source
    assert "HHT\\_\\ensuremath{\\alpha}" in source and "\\ensuremath{\\dot{u}}" in source
    assert "10\\ensuremath{^-}\\ensuremath{^6}" in source and "Scheme \\& step & 10 \\%" in source


def test_every_character_of_the_tables_can_be_set():
    sources = [*PAPER.glob("claims/*.py"), *PAPER.glob("tables/*.py"), *PAPER.glob("../study/scheme/*.py")]
    used = {sign for path in sources for line in path.read_text().splitlines() if "title" in line for sign in line}
    used |= {sign for path in PAPER.glob("tables/*.py") for sign in path.read_text()}
    assert {sign for sign in used if ord(sign) > 127} <= {*map(chr, _SET), *_DOTS, *SET}


#: Width in points by which words of a narrow column may stand out.
OUTSTANDING = 10


def _compiled(source: str, folder: Path) -> str:
    """What pdfLaTeX says about a table in an article of 17 cm."""
    packages = re.findall(r"In the preamble: (.*)", source)[0]
    head = f"\\documentclass{{article}}\\usepackage[a4paper,margin=2cm]{{geometry}}{packages}\\begin{{document}}\n"
    (folder / "text.tex").write_text(f"{head}{source}\\end{{document}}\n")
    command = ["pdflatex", "-interaction=nonstopmode", "text.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace")
    assert done.returncode == 0 and "\n! " not in done.stdout, done.stdout[-3000:]
    return done.stdout


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no TeX is installed")
def test_the_source_compiles(tmp_path):
    signs = "".join(sorted({*map(chr, _SET), *SET}))
    frame = pd.concat([FRAME, pd.DataFrame({column: [signs] for column in FRAME})])
    _compiled(tex(PRODUCT, frame), tmp_path)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no TeX is installed")
def test_the_tables_of_the_study_fit_the_page(tmp_path):
    """A table of the finished study that runs over the end or the margin of a page."""
    sources = sorted((PAPER.parent / "results" / "tables").glob("*.tex"))
    if not sources:
        pytest.skip("results/tables is empty; `make` fills it")
    for path in sources:
        said = _compiled(path.read_text(), tmp_path)
        assert "Float too large" not in said, path.name
        assert all(float(width) < OUTSTANDING for width in re.findall(r"Overfull \\hbox \(([\d.]+)pt", said)), path.name
