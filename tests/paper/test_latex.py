"""The texts as LaTeX sources."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import paper
from paper.latex.__main__ import converted

PAPER = Path(paper.__file__).parent
#: Characters that pdfLaTeX prints with its usual encodings.
PRINTED = set("–—‘’“”äöüÜøóíé×±½√·†…\u2011\u00a0\u0307\u0308")
TEXT = """#import "layout.typ": holds, n, number-of, picture, printed, ruled, table-of, tabular
#show: printed.with(title: [On steps], subtitle: [A test], authors: "A. Author", front: [*Abstract.* Short.])
= Introduction <start>
#holds(n.yes)[It is #n.value %.] #holds(n.no)[It is not.] @start cites @motion, @portrait and @steps, with @xie1996.
Figures~#number-of(<portrait>) and 2.

$ dot.double(u) + p(u) = 0 $ <motion>

#picture("orbit", wide: true)[An orbit at $T\\/20$.] <portrait>

#tabular(ruled(table-of("steps"), align: left))[Steps.] <steps>
"""


@pytest.fixture
def folder(tmp_path):
    shutil.copy(PAPER / "latex" / "layout.typ", tmp_path)
    (tmp_path / "numbers.json").write_text('{"yes": true, "no": false, "value": "3\\u00a0×\\u00a010⁻⁵"}')
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "steps.csv").write_text(f"Scheme,Long\nWilson-θ u̇,{'a word and ' * 12}\n")
    (tmp_path / "text.typ").write_text(TEXT)
    return tmp_path


def test_numbers_references_and_floats_are_those_of_the_text(folder):
    source = converted(folder / "text.typ")
    assert "3~×~10⁻⁵ \\%" in source and "It is not" not in source
    cited = ", ".join(f"\\autoref{{{label}}}" for label in ("motion", "portrait"))
    assert f"\\autoref{{start}} cites {cited} and \\autoref{{steps}}" in source and "\\citep{xie1996}" in source
    assert "Figures~\\ref{portrait} and 2." in source
    assert "\\label{start}" in source and "\\begin{equation}\\label{motion}\n\\ddot{u}" in source
    assert "{figures/orbit.pdf}" in source and "\\label{portrait}" in source
    assert "\\label{steps}" in source and "Wilson-θ \\(\\dot u\\)" in source and "\\real{" in source
    assert "\\title{On steps}" in source and "\\begin{abstract}\nShort." in source


def test_latex_prints_the_characters_of_the_texts():
    declared = {chr(int(code, 16)) for code in re.findall(r"\\sign{(\w+)}", (PAPER / "latex/header.tex").read_text())}
    sources = [*PAPER.glob("text/*.typ"), *PAPER.glob("claims/*.py"), *PAPER.glob("tables/*.py"), *PAPER.glob("*.bib")]
    used = {character for path in sources for character in path.read_text() if ord(character) > 127}
    assert used <= declared | PRINTED


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no TeX is installed")
def test_the_source_compiles(folder, pytestconfig):
    (folder / "figures").mkdir()
    shutil.copy(pytestconfig.rootpath / ".github" / "softening.png", folder / "figures" / "orbit.png")
    # pdfLaTeX finds a picture of any format by a name without a suffix
    (folder / "text.tex").write_text(converted(folder / "text.typ").replace("figures/orbit.pdf", "figures/orbit"))
    for _ in range(3):  # repeated until references and widths of tables are settled
        done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "text.tex"], cwd=folder, capture_output=True)
    assert done.returncode == 0
    assert b"LaTeX Warning: Reference" not in done.stdout and (folder / "text.pdf").exists()
