"""Docstrings as pages show them."""

import inspect

import pytest

from docs.docstrings import explained, is_equation, markdown, paragraphs_of, references_of, restructured


def test_every_scheme_states_equations_text_and_references(scheme):
    text = explained(type(scheme))
    equations = [paragraph for paragraph in text.paragraphs if is_equation(paragraph)]
    assert equations and len(text.paragraphs) > len(equations) and text.summary.endswith(".")
    works = (inspect.getdoc(type(scheme)) or "").split("References\n----------\n")[1]
    assert text.references and " ".join(text.references) == " ".join(works.split())


@pytest.mark.parametrize(
    "line, equation",
    [
        ("u₁ = u₀ + Δt u̇₁", True),
        ("u ← u + d₀Δt u̇,    then for i = 1, ..., s", True),
        ("M ü + C u̇ + p(u) = f    at t₀ + γΔt and at t₁", True),
        ("Second order for γ = ½, first order otherwise.", False),
        ("Carries u and u̇.", False),
    ],
)
def test_equations_are_told_from_text(line, equation):
    assert is_equation([line]) is equation
    assert not is_equation([line, "Carries u and u̇."])


def test_equations_after_a_colon_stand_alone():
    assert paragraphs_of(["With h = Δt:", "u ← u + h u̇", "", "", "Text."]) == [
        ["With h = Δt:"],
        ["u ← u + h u̇"],
        ["Text."],
    ]


def test_a_reference_ends_with_a_number():
    lines = ["A. Author, A title, Earthquake Eng.", "Struct. Dyn. 1, 1973, 241-252.", "B. Writer, A book, 2006."]
    assert references_of(lines) == [f"{lines[0]} {lines[1]}", lines[2]]


def test_signs_of_markup_are_kept_as_text():
    assert markdown("|u*| of :class:`study.Scheme` and ``a*b``") == r"\|u\*\| of ``study.Scheme`` and ``a*b``"
    lines = restructured(
        ["With |u|:", "", "u = |v|", "", "References", "----------", "A book, 2006.", "Another, 2007."]
    )
    assert lines[:5] == [r"With \|u\|:", "", ".. rst-class:: equations", "", r"| u = \|v\|"]
    assert lines[-3:] == [r"- \A book, 2006.", r"- \Another, 2007.", ""]
