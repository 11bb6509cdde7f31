"""The texts, and the numbers, figures and tables that are made for them."""

import inspect
import json
import re
import shutil

import pytest
import typst

import study
from paper.manuscript import LAYOUT, TEXTS, check_uses, numbered, uses
from paper.products import discover
from study.problem.named import makers, printed_periods

SOURCE = """
// n.commented picture("commented")
Of #n.cells cells #if int(n.shown) < 3 [#n.at("drift_20.5")], one of them. As in-between n. is.
#picture("atlas", wide: true)[Text.]
#let rows = table-of("orders").first()
"""


def test_what_a_text_uses():
    assert uses(SOURCE) == {
        "number": {"cells": 3, "shown": 3, "drift_20.5": 3},
        "figure": {"atlas": 4},
        "table": {"orders": 5},
    }


@pytest.mark.parametrize("kind, name, line", [("number", "cells", 3), ("figure", "atlas", 4), ("table", "orders", 5)])
def test_what_is_missing_is_named_with_its_line(tmp_path, kind, name, line):
    (tmp_path / "article.typ").write_text(SOURCE)
    there = uses(SOURCE)
    for folder, suffix, names in (("figures", "pdf", there["figure"]), ("tables", "csv", there["table"])):
        (tmp_path / folder).mkdir()
        for stem in names:
            (tmp_path / folder / f"{stem}.{suffix}").touch()
    (tmp_path / "numbers.json").write_text(json.dumps(there["number"]))
    check_uses(tmp_path / "article.typ", tmp_path)
    if kind == "number":
        (tmp_path / "numbers.json").write_text("{}")
    else:
        shutil.rmtree(tmp_path / f"{kind}s")
    with pytest.raises(SystemExit, match=rf"article\.typ, line {line}: there is no {kind} '{name}' in the results"):
        check_uses(tmp_path / "article.typ", tmp_path)


def test_the_files_of_figures_and_tables_have_their_numbers(tmp_path):
    text = tmp_path / "supplement.typ"
    text.write_text(
        '#picture("atlas")[A.] <a>\n// #picture("no")[]\n#tabular(\n  ruled(table-of("orders")),\n)[B.] <b>\n\n'
        '#tabular(ruled(symbols))[C.] <c>\n\nOf #limits-of(table-of("needs")).\n'
        '#pair(picture("one")[], picture("two")[])'
    )
    figures = [("Figure S1", "atlas"), ("Figure S2", "one"), ("Figure S3", "two")]
    entries = numbered(text)
    assert [entry for entry in entries if entry[0].startswith("Figure")] == figures
    assert [entry for entry in entries if entry[0].startswith("Table")] == [("Table S1", "orders"), ("Table S2", "")]


def _used(kind):
    return set().union(*(uses(text.read_text())[kind] for text in TEXTS))


@pytest.mark.parametrize("kind", ["figure", "table"])
def test_the_texts_use_only_what_is_declared(kind):
    """The site shows all figures and tables, so the texts need not."""
    undeclared = sorted(_used(kind) - {product.name for product in discover() if product.kind == kind})
    assert not undeclared, f"paper/{kind}s/ declares no '{undeclared[0]}', which a text uses"


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: text.stem)
def test_every_figure_and_table_is_cited_in_order(text):
    source = re.sub(r"^//.*$", "", text.read_text(), flags=re.MULTILINE)
    source = re.sub(r"#number-of\(<([\w-]+)>\)", r"@\1", source)
    kinds = {"figure": "#picture(", "table": "#tabular("}
    for start in kinds.values():
        labels = [
            re.findall(r"<([\w-]+)>", source[place.start() :])[0] for place in re.finditer(re.escape(start), source)
        ]
        first_cited = {label: source.find(f"@{label}") for label in labels}
        assert -1 not in first_cited.values(), first_cited
        assert labels == sorted(labels, key=first_cited.get)


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: text.stem)
def test_no_semicolon_follows_a_number(text):
    # Typst reads the semicolon as the end of the expression and does not print it
    assert not re.findall(r"#n\.[\w.]+;", text.read_text())


def test_every_problem_that_is_not_one_of_1996_is_stated_with_the_numbers_of_its_source():
    """A problem that the supplement leaves out, or defines with other numbers than the code."""
    rows = re.findall(r'^  \(\s*"([^"]+)",\s*\[(.*?)\],?\s*\),$', TEXTS[1].read_text(), re.MULTILINE | re.DOTALL)
    names = {study.problems[name].title: name for name in study.problems if name not in printed_periods}
    titles = {title[0].upper() + title[1:]: name for title, name in names.items()}
    missing, unknown = titles.keys() - dict(rows), dict(rows).keys() - titles
    assert not missing, f"add a row to `definitions` in paper/text/supplement.typ for {missing}"
    assert not unknown, f"`definitions` in paper/text/supplement.typ has rows of no registered problem: {unknown}"
    for title, stated in rows:
        source = inspect.getsource(inspect.getmodule(makers[titles[title]]))
        decimals = set(re.findall(r"\d+\.\d+", stated))
        assert decimals <= set(re.findall(r"\d+\.\d+", source)), title


def test_facts_are_what_holds_takes_and_numbers_are_not():
    names = {name for text in TEXTS for name in re.findall(r"#holds\(n\.(\w+)\)", text.read_text())}
    assert names
    # a fact in the printed text would appear as true or false
    for text in TEXTS:
        printed = re.sub(r"#holds\(n\.\w+\)", "", text.read_text())
        assert not names & set(uses(printed)["number"])


FACTS = """#import "layout.typ": holds, given
#set page(height: auto, width: 10cm)
#holds(n.yes)[true] #holds(n.no)[false] #holds(n.absent)[absent] #given(n.number)[number] #given(n.absent)[none]
"""


def _compiled(folder, numbers):
    (folder / "numbers.json").write_text(json.dumps(numbers))
    (folder / "layout.typ").write_text(LAYOUT.read_text())
    (folder / "text.typ").write_text(FACTS.replace("holds, given", "holds, given, n"))
    return typst.query(str(folder / "text.typ"), "<none>", root="/", sys_inputs={"results": str(folder)})


def test_a_fact_must_be_true_or_false(tmp_path):
    _compiled(tmp_path, {"yes": True, "no": False, "absent": None, "number": "3"})
    with pytest.raises(RuntimeError, match="a fact is true or false, not"):
        _compiled(tmp_path, {"yes": "True", "no": False, "absent": None, "number": "3"})


#: Pattern of the keys of returned mappings: at the start of a line, in a comprehension, or in an assignment.
_KEY = re.compile(r'^ +f?"([^"]+)": |\{f"([^"]+)": |^ +\w+\[f?"([^"]+)"\] = ', re.MULTILINE)


def _keys(function):
    """Regular expressions of the keys of the mapping that a function returns."""
    body = inspect.getsource(function).partition("\ndef ")[2]
    body = re.sub("^ +return .*", lambda line: re.sub(r'[{,] ?(?="\w+": )', "\n ", line[0]), body, flags=re.MULTILINE)
    keys = (next(filter(None, match.groups())) for match in _KEY.finditer(body))
    return {re.sub(r"\\\{.+?\\\}", ".+", re.escape(key)) for key in keys}


@pytest.mark.slow
@pytest.mark.parametrize("product", [p for p in discover(["numbers"]) if p.kind == "numbers"], ids=lambda p: p.name)
def test_every_number_is_used(product):
    pages = "".join(page.read_text() for page in LAYOUT.parents[2].joinpath("docs", "pages").rglob("*.md"))
    used = _used("number") | {*re.findall(r'n\["(\w+)"\]', pages)}
    keys = _keys(product.function)
    assert keys
    unused = {key for key in keys if not any(re.fullmatch(key, name) for name in used)}
    assert not unused


@pytest.mark.parametrize("text", sorted(LAYOUT.parent.glob("*.typ")), ids=lambda path: path.stem)
def test_no_semicolon_follows_a_number_or_a_fact(text):
    """Typst ends the expression at a semicolon, and does not print it."""
    prose = re.sub(r"//.*", "", text.read_text())
    assert re.findall(r"#[a-z][\w.-]*;|#(?:holds|given)\([\w.]+\)\[[^\[\]]*\];", prose) == []
