"""The texts as LaTeX sources."""

import shutil
import subprocess

import pytest

from paper.latex.__main__ import converted
from paper.latex.symbols import in_latex

LAYOUT = "paper/latex/layout.typ"
TEXT = """#import "layout.typ": holds, n, picture, printed, ruled, table-of, tabular
#show: printed.with(title: [On steps], subtitle: [A test], authors: "A. Author", front: [*Abstract.* Short.])
= Introduction <start>
#holds(n.yes)[It is #n.value %.] #holds(n.no)[It is not.] @start cites @motion, @portrait and @steps, with @xie1996.

$ dot.double(u) + p(u) = 0 $ <motion>

#picture("orbit", wide: true)[An orbit at $T\\/20$.] <portrait>

#tabular(ruled(table-of("steps"), align: left))[Steps.] <steps>
"""


@pytest.fixture
def folder(tmp_path, pytestconfig):
    shutil.copy(pytestconfig.rootpath / LAYOUT, tmp_path)
    (tmp_path / "numbers.json").write_text('{"yes": true, "no": false, "value": "3\\u00a0×\\u00a010⁻⁵"}')
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "steps.csv").write_text(f"Scheme,Long\nWilson-θ,{'a word and ' * 12}\n")
    (tmp_path / "text.typ").write_text(TEXT.replace("\\\\", "\\"))
    return tmp_path


def test_numbers_references_and_floats_are_those_of_the_text(folder):
    source = converted(folder, "text.typ")
    assert "3~\\ensuremath{\\times}~10\\textsuperscript{-5} \\%" in source and "It is not" not in source
    assert "Section~\\ref{start} cites \\eqref{motion}, Figure~\\ref{portrait} and Table~\\ref{steps}" in source
    assert "\\begin{equation}\n\\label{motion}\n\\ddot{u}" in source
    assert "\\includegraphics[keepaspectratio]{figures/orbit.pdf}" in source and "\\label{portrait}" in source
    assert "\\label{steps}" in source and "Wilson-\\ensuremath{\\theta}" in source
    assert "\\citep{xie1996}" in source
    # wide columns have widths
    assert "\\real{" in source
    # as do title and abstract, whose heading LaTeX prints
    assert "\\title{On steps" in source and "\\noindent\nShort." in source


def test_a_character_that_latex_does_not_print_is_named():
    assert in_latex("ρ∞ ≤ 10⁻¹⁵, u̇") == (
        "\\ensuremath{\\rho}\\ensuremath{\\infty} \\ensuremath{\\le} 10\\textsuperscript{-15}, \\ensuremath{\\dot u}"
    )
    with pytest.raises(ValueError, match=r"LaTeX does not print '☃' \(U\+2603\); add it to paper/latex/symbols.py"):
        in_latex("☃")


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no TeX is installed")
def test_the_source_compiles(folder, pytestconfig):
    (folder / "figures").mkdir()
    shutil.copy(pytestconfig.rootpath / ".github" / "softening.png", folder / "figures" / "orbit.png")
    # pdfLaTeX takes any format for a name without one
    source = converted(folder, "text.typ").replace("figures/orbit.pdf", "figures/orbit")
    (folder / "text.tex").write_text(source)
    for _ in range(3):  # until references and widths of tables are settled
        done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "text.tex"], cwd=folder, capture_output=True)
    assert done.returncode == 0
    assert b"LaTeX Warning: Reference" not in done.stdout and (folder / "text.pdf").exists()
