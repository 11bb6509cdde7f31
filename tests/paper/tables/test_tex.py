"""Tables as LaTeX."""

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


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no TeX is installed")
def test_the_source_compiles(tmp_path):
    signs = "".join(sorted({*map(chr, _SET), *SET}))
    frame = pd.concat([FRAME, pd.DataFrame({column: [signs] for column in FRAME})])
    head, end = "\\documentclass{article}\\usepackage{booktabs}\\begin{document}\n", "\\end{document}\n"
    (tmp_path / "text.tex").write_text(head + tex(PRODUCT, frame) + end)
    command = ["pdflatex", "-interaction=nonstopmode", "text.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True)
    assert done.returncode == 0 and b"\n! " not in done.stdout, done.stdout[-3000:]
