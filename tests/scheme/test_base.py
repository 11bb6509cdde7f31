"""Declared properties of schemes."""

from typing import ClassVar

import pytest

import study


def test_a_scheme_is_printed_in_a_few_lines_with_order_limit_and_source(scheme):
    lines = repr(scheme).splitlines()
    assert len(lines) == 4 and max(map(len, lines)) <= 130
    assert lines[0].startswith(f"{scheme.title}: ") and lines[1].startswith(f"{type(scheme).__name__}(")
    assert f"order {scheme.order}" in lines[2] and "stable" in lines[2] and scheme.source in lines[3]


def test_a_scheme_that_states_little_is_printed_too():
    class Bare(study.OneStep):
        title: str = "bare"
        source: ClassVar[str] = "nobody (2000)"
        doi: ClassVar[str] = ""
        order = 1
        explicit = True
        start = increment = lambda self, *arguments: None  # type: ignore[assignment]

    assert repr(Bare()) == "bare\nBare()\nexplicit, order 1\nsource: nobody (2000)"


def test_a_class_without_source_is_told_what_to_define():
    class Unsourced(study.OneStep):
        title: str = "unsourced"
        order = 1
        explicit = True
        increment = lambda self, *arguments: None  # type: ignore[assignment]  # noqa: E731

    with pytest.raises(TypeError) as error:
        Unsourced()  # type: ignore[abstract]
    assert str(error.value) == (
        "Unsourced is a scheme and must define doi (Digital object identifier of the source, empty if it has none) and "
        "source (Author and year of the first publication)."
    )


def test_a_limit_of_zero_that_a_class_states_is_not_warned_about():
    scheme = study.schemes["dormand_prince6"]
    assert study.Compensated(scheme=scheme).stability_limit == scheme.stability_limit == 0
