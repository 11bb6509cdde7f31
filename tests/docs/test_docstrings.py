"""Docstrings and formulas as pages show them."""

import ast
import inspect
import re
from pathlib import Path

import pytest

from docs.docstrings import parsed, references_of, restructured
from docs.mathml import mathml

PROJECT = Path(__file__).parents[2]
#: Pattern of the formulas of a docstring: blocks, and formulas within a line.
FORMULA = re.compile(r"^( *)\.\. math::\n\n((?:\1 +.*\n|\n)+)|:math:`([^`]*)`", re.MULTILINE)


def test_every_scheme_states_equations_text_and_references(scheme):
    text = parsed(type(scheme))
    assert text["Summary"][-1].endswith(".") and "\n.. math::" in str(text)
    works = (inspect.getdoc(type(scheme)) or "").split("References\n----------\n")[1]
    assert [work.removeprefix("- \\") for work in text["References"]] == references_of(works.splitlines())


def test_a_docstring_for_numpydoc():
    lines = ["With u:", "", ".. math::", "", "    u_1 = |v|", "", "References", "----------"]
    works = ["N. Author, A title, Earthquake Eng.", "Struct. Dyn. 1, 1973, 241-252.", "B. Writer, A book, 2006."]
    assert restructured([*lines, *works]) == [
        *lines,
        r"- \N. Author, A title, Earthquake Eng. Struct. Dyn. 1, 1973, 241-252.",
        r"- \B. Writer, A book, 2006.",
        "",
    ]
    assert restructured(["A summary."]) == ["A summary.", ""]
    assert restructured(["α_m ≤ θ_{k−1}"]) == [r"α\ :sub:`m`\  ≤ θ\ :sub:`k−1`\ ", ""]


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["study", "reference"])
def test_the_formulas_of_all_docstrings_become_mathml(folder):
    formulas = 0
    for path in (PROJECT / folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                for _, block, inline in FORMULA.findall(f"{ast.get_docstring(node)}\n"):
                    assert "<math" in mathml(inspect.cleandoc(block) or inline, "block" if block else "inline")
                    formulas += 1
    assert formulas > 5


def test_formulas_become_mathml():
    assert "<msub><mover><mi>u</mi>" in mathml(r"\ddot u_1", "inline")
    assert mathml("u &= 1\n\nv &= 2", "block") == mathml(r"u &= 1 \\ v &= 2", "block")
    assert mathml("u &= 1\n\nv &= 2", "block").count("<mtr>") == 2
    with pytest.raises(ValueError, match=r"'u \\unknown' has '\\unknown', which cannot be set as MathML"):
        mathml(r"u \unknown", "inline")
