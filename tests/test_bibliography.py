"""One bibliography: the text, the docstrings, the schemes and the files for catalogues cite the same works."""

import ast
import re
from collections import Counter

import pytest

import study
from paper.manuscript import TEXTS
from study import io
from study.scheme.base import Wrapper
from tests import bibliography
from tests.bibliography import PROJECT

WORKS = bibliography.works()
REFERENCES = {key: bibliography.reference(work) for key, work in WORKS.items()}
SOURCES = [path for folder in ("study", "reference", "paper") for path in sorted((PROJECT / folder).rglob("*.py"))]
#: Authors, year and DOI of every work, by key.
LABELS = {key: (bibliography.label(work), work.get("doi", "")) for key, work in WORKS.items()}
SCHEMES = {name: (type(scheme), scheme.source, scheme.doi) for name, scheme in study.schemes.items()}
SCHEMES |= {wrapper.__name__: (wrapper, wrapper.source, wrapper.doi) for wrapper in Wrapper.__subclasses__()}
_DOI = r"10\.\d{4,9}/(?:[^\s\"\]()]|\([^\s()]*\))*(?:\w|\(\d+\))"
#: Fields that a work of each kind needs in addition to author, title and year.
NEEDED = {
    "article": {"journal", "shortjournal", "volume", "pages"},
    "book": {"publisher"},
    "inproceedings": {"booktitle", "shortbooktitle", "pages"},
    "phdthesis": {"school"},
    "techreport": {"type", "number", "institution"},
}


def _docstrings():
    """Yield every docstring with a section References, and its place in the sources."""
    for path in SOURCES:
        text = path.read_text()
        for node in ast.walk(ast.parse(text)) if "References\n" in text else ():
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                docstring = ast.get_docstring(node) or ""
                if "References\n-----" in docstring:
                    yield f"{path.relative_to(PROJECT)}:{getattr(node, 'name', '')}", docstring


def _keys_of_the_text() -> set[str]:
    texts = "\n".join(path.read_text() for path in TEXTS)
    text = re.sub(r"^[ \t]*//.*$", "", texts, flags=re.MULTILINE)
    return set(re.findall(r"(?:@|cite\(<)([a-z]+\d{4}[a-z]*)", text))


@pytest.mark.parametrize("key", WORKS)
def test_a_work_has_what_its_kind_needs(key):
    work = WORKS[key]
    assert re.fullmatch(rf"[a-z]+{work['year']}[a-z]*", key)
    assert {"author", "title", "year"} | NEEDED[work["kind"]] <= work.keys()
    assert re.fullmatch(_DOI, work.get("doi", "10.1000/1"))
    assert re.fullmatch(r"[\w:]+(--[\w:]+)?", work.get("pages", "1"))
    assert work.get("unconfirmed", "all")  # if present, the field names the unconfirmed part


def test_works_are_sorted_and_have_a_doi_of_their_own():
    assert list(WORKS) == sorted(WORKS)
    counts = Counter(work["doi"].lower() for work in WORKS.values() if "doi" in work)
    assert [doi for doi, count in counts.items() if count > 1] == []
    assert len(counts) > 40


def test_the_text_cites_works_that_are_there():
    keys = _keys_of_the_text()
    assert len(keys) > 30
    assert keys - WORKS.keys() == set()


def test_every_work_is_cited():
    in_schemes = {key for key, label in LABELS.items() if label in {scheme[1:] for scheme in SCHEMES.values()}}
    in_docstrings = {key for _, docstring in _docstrings() for key in bibliography.cited_in(docstring, REFERENCES)}
    cited = _keys_of_the_text() | in_schemes | in_docstrings
    assert WORKS.keys() - cited == set()


@pytest.mark.parametrize("name", SCHEMES)
def test_the_source_of_a_scheme_is_a_work_that_its_docstring_cites(name):
    scheme, source, doi = SCHEMES[name]
    cited = bibliography.cited_in(scheme.__doc__, REFERENCES)
    assert (source, doi) in [LABELS[key] for key in cited]


def test_every_doi_in_the_files_is_that_of_a_work():
    known = {work.get("doi") for work in WORKS.values()}
    files = [*SOURCES, PROJECT / "README.md", PROJECT / "CITATION.cff"]
    unknown_by_file = {path.name: set(re.findall(_DOI, path.read_text())) - known for path in files}
    assert {name: unknown for name, unknown in unknown_by_file.items() if unknown} == {}


def test_datasets_name_the_paper_as_the_bibliography_does():
    paper = bibliography.reference(WORKS["xie1996"] | {"shortjournal": WORKS["xie1996"]["journal"]})
    assert f"{paper}, doi:{WORKS['xie1996']['doi']}" == io.PAPER


@pytest.mark.parametrize(
    "section",
    [
        "N. M. Newmark, A method of computation, 1959.",
        REFERENCES["bathe2012"].replace("2012", "2013") + ".",
        f"{REFERENCES['bathe2012']}, and more.",
    ],
)
def test_a_docstring_that_differs_is_refused(section):
    with pytest.raises(ValueError, match=r"references\.bib has no such work"):
        bibliography.cited_in(f"A scheme.\n\nReferences\n----------\n{section}", REFERENCES)


def test_a_docstring_may_name_a_place_in_a_work():
    section = f"{REFERENCES['hairer2006']}, sections I.5.1 and XIII. {REFERENCES['simo1992exact']} (a body that spins)."
    cited = bibliography.cited_in(f"A scheme.\n\nReferences\n----------\n{section}", REFERENCES)
    assert cited == ["hairer2006", "simo1992exact"]


@pytest.mark.parametrize(
    "doi",
    [
        "10.1002/(SICI)1097-0207(19961230)39:24<4199::AID-NME39>3.0.CO;2-Y",
        "10.1061/(ASCE)0733-9399(2002)128:9(935)",
        "10.1115/1.2900803",
    ],
)
def test_a_doi_is_found_whole(doi):
    assert re.findall(_DOI, f'doi = "{doi}"\n{doi}. See {doi}, or https://doi.org/{doi}') == [doi] * 4


@pytest.mark.parametrize(
    "written, read",
    [
        (r"F{\"u}hrer", "Führer"),
        (r"F\"uhrer", "Führer"),
        (r"F\"{u}hrer", "Führer"),
        (r"Nyg{\aa}rd and {\O}ksendal", "Nyg{å}rd and {Ø}ksendal"),
        (r"Ko\v{c}i{\'c} {\'\i}", "Kočić í"),
        (r"Stra{\ss}e \& Co", r"Stra{ß}e \& Co"),
    ],
)
def test_accents_of_latex_are_letters(written, read, tmp_path, monkeypatch):
    monkeypatch.setattr(bibliography, "FILE", tmp_path / "references.bib")
    bibliography.FILE.write_text(f"@book{{one2000,\n  title = {{{written}}}\n}}\n")
    title = bibliography.works()["one2000"]["title"]
    assert title.replace("{", "").replace("}", "") == read.replace("{", "").replace("}", "")


def test_another_command_of_latex_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(bibliography, "FILE", tmp_path / "references.bib")
    bibliography.FILE.write_text("@book{one2000,\n  title = {The \\emph{method}}\n}\n")
    with pytest.raises(ValueError, match=r"title of 'one2000' has '\\\\emph\{method\}'; write the letter itself"):
        bibliography.works()
