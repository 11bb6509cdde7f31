"""Pages that are written by hand, and the step of the pipeline that builds the site."""

import ast
import inspect
import json
import re
from pathlib import Path

import pytest
import xarray as xr
import yaml

import study
from docs import executed, gallery, plan
from paper import products
from pipeline import configuration
from study import io
from study.declaration.experiment import discover
from tests.pipeline.pipeline import call_snakemake, copied
from tests.snippets import blocks, commands, run_command, run_examples

PROJECT = Path(__file__).parents[2]
PAGES = sorted(plan.PAGES.rglob("*.md"))
GALLERY = [page for page in PAGES if page.parent.name == "gallery" and page.stem != "index"]


def _relative(page: Path) -> str:
    return page.relative_to(plan.PAGES).as_posix()


#: Pages whose examples take three seconds and more; the site runs them too.
LONG = {*(f"how_to/{name}.md" for name in ("choose", "control", "many_runs", "problem", "program")), "index.md"}


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, id=_relative(page), marks=pytest.mark.exhaustive if _relative(page) in LONG else ())
        for page in PAGES
        if page not in GALLERY and blocks(page.read_text(), "python")
    ],
)
def test_the_examples_of_a_page_run_in_order(page, tmp_path, monkeypatch):
    """An example that needs a line which its page does not show."""
    names = run_examples(page.read_text(), page.name, tmp_path, monkeypatch)
    if page.stem == "choose":
        assert (names["runs"].status == 0).any() and names["how"].shape == names["runs"].status.shape
        assert (tmp_path / "duffing.html").stat().st_size > 1e4
    if page.stem == "run":
        assert names["theory"].order() == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("page", [*PAGES, PROJECT / "CONTRIBUTING.md"], ids=lambda page: page.stem)
def test_lines_of_code_fit_a_page(page):
    code = [block for language in ("python", "sh", "text", "yaml") for block in blocks(page.read_text(), language)]
    assert [line for block in code for line in block.splitlines() if len(line) > 88] == []


@pytest.mark.pipeline
@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page.read_text(), "yaml")], ids=_relative)
def test_the_configuration_of_a_page_is_accepted(page, tmp_path):
    """A key of the configuration that a page names wrongly."""
    folder = copied(tmp_path)
    (folder / "mine.yaml").write_text("\n".join(blocks(page.read_text(), "yaml")))
    planned = call_snakemake(folder, "-n", "--quiet", overlays=["mine.yaml"])
    assert planned.returncode == 0, planned.stderr + planned.stdout


COMMANDS = [words for page in PAGES for words in commands(page.read_text())]


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        pytest.param(words, id=words[0], marks=pytest.mark.exhaustive if words[0] == "assess" else ())
        for words in COMMANDS
    ],
)
def test_the_commands_of_the_pages_run(words, tmp_path):
    """An option or a name in a command of a page that does not exist."""
    run_command(words, tmp_path)


def test_the_commands_are_those_of_the_package():
    assert {"list", "run", "recommend", "assess"} == {words[0] for words in COMMANDS}


def test_expressions_of_a_page_use_its_python_the_numbers_and_words(tmp_path):
    results = tmp_path / "results"
    results.mkdir()
    (results / "numbers.json").write_text(json.dumps({"claims": "56"}))
    data = xr.Dataset({"u": ("t", [1.0, 2.5])}, attrs={"source": io.SOURCE})
    io.write(data, results / "own" / "data.nc")
    page = '```python\nimport study\n\ntop = study.open_dataset("own/data").u.max().item()\nprint(top)\n```\n'
    shown, names = executed.run(page, results)
    assert shown == page + "\n```text\n2.5\n```\n"
    assert eval('n["claims"], number(top), listed("ab")', names) == ("56", "2.5", "a and b")


@pytest.mark.parametrize("page", PAGES, ids=_relative)
def test_a_page_prints_numbers_of_the_article_as_they_are(page):
    """Arithmetic on a number of the article, which is a text."""
    for expression in re.findall(r"\{eval\}`([^`]+)`", page.read_text()):
        for node in ast.walk(ast.parse(expression, mode="eval")):
            if isinstance(node, ast.BinOp | ast.Call):
                assert not re.search(r"\bn\[", ast.unparse(node)), expression


@pytest.mark.parametrize("page", GALLERY, ids=_relative)
def test_a_question_has_a_figure_numbers_and_its_python(page):
    text, figures = (
        page.read_text(),
        {product.name for product in products.discover(["figures"]) if product.kind == "figure"},
    )
    assert re.match(r"# .*\?\n", text) and len(blocks(text, "python")) == 1 and "study.open_dataset(" in text
    assert set(re.findall(r"figures/(\w+)\.svg", text)) <= figures and "```{figure}" in text
    assert text.count("{eval}`") >= 2 and f"\n{page.stem}\n" in (page.parent / "index.md").read_text()


def test_the_index_of_the_gallery_shows_every_question_and_has_its_script(tmp_path):
    grid = gallery.grid()
    assert sorted(gallery.questions()) == GALLERY and grid.count("```{figure}") == len(GALLERY) >= 8
    assert "[Which scheme damps least?](damping.md)" in grid and ":target: damping.html" in grid
    gallery.write_scripts(tmp_path)
    (code,) = blocks((plan.PAGES / "gallery" / "damping.md").read_text(), "python")
    assert (tmp_path / "damping.py").read_text() == code and "<damping.py>" in (tmp_path / "damping.md").read_text()


@pytest.mark.parametrize("page", PAGES, ids=_relative)
def test_links_that_sphinx_does_not_check_lead_to_products(page):
    for link in re.findall(r'\b(?:href|src)="([^"]*)"', page.read_text()):
        assert (page.parent / link).resolve().relative_to(plan.PAGES).as_posix() in plan.PRODUCTS


def test_the_interface_has_every_public_name_once():
    text = (plan.PAGES / "interface" / "index.md").read_text()
    listed = [*re.findall(r"^   ([\w]+)$", text, re.MULTILINE), *re.findall(r"py:data:: (\w+)", text)]
    public = {name for name in dir(study) if name[0] != "_" and not inspect.ismodule(getattr(study, name))}
    assert sorted(listed) == sorted(public - {"problems", "schemes", "observers", "estimators", "controllers"})


def test_the_table_of_datasets_names_what_the_short_study_makes():
    experiments = discover()
    short = configuration.check(experiments, yaml.safe_load((PROJECT / "config" / "study.yaml").read_text()))
    datasets = configuration.datasets_of(experiments, short)
    rows = re.findall(r"^\| `([\w/]+)` \|", (plan.PAGES / "how_to" / "datasets.md").read_text(), re.MULTILINE)
    patterns = {row: re.compile(re.sub("[A-Z]+", r"\\w+", row)) for row in rows}
    assert len(rows) > 20 and len(set(rows)) == len(rows)
    assert [row for row, pattern in patterns.items() if not any(map(pattern.fullmatch, datasets))] == []
    assert [name for name in datasets if not any(pattern.fullmatch(name) for pattern in patterns.values())] == []


def test_the_site_depends_on_what_its_pages_show():
    shown = {"accuracy.nc", "assessment/driven.html", "needs.nc", "figures/atlas.svg", "numbers.json", "explorer.html"}
    assert shown <= set(plan.reads())
    sources = {"study/scheme/houbolt.py", "docs/conf.py", "docs/static/table.js", "CONTRIBUTING.md"}
    assert {PROJECT / name for name in sources} <= set(plan.shown(PROJECT))


def test_every_how_to_is_on_the_first_page():
    contents = (plan.PAGES / "index.md").read_text()
    for page in (plan.PAGES / "how_to").glob("*.md"):
        assert f"how_to/{page.stem}" in contents
