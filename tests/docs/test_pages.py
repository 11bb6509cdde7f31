"""Pages by hand, the interface, and the step of the pipeline."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml

import study
from docs import filled, interface, plan
from paper import products
from study import datasets
from study.analysis.recommendation import READS
from study.pipeline import configuration
from study.pipeline.experiment import discover
from tests.pipeline.pipeline import call_snakemake, copied
from tests.snippets import blocks, commands, run_command, run_examples

PROJECT = Path(__file__).parents[2]
PAGES = sorted(filled.FOLDER.rglob("*.md"))
GALLERY = [page for page in filled.pages() if page.parent.name == "gallery" and page.stem != "index"]


def _relative(page: Path) -> str:
    return page.relative_to(filled.FOLDER).as_posix()


@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if page not in GALLERY and blocks(page.read_text(), "python")],
    ids=_relative,
)
def test_the_examples_of_a_page_run_in_order(page, tmp_path, monkeypatch):
    seen = run_examples(page.read_text(), page.name, tmp_path, monkeypatch)
    if page.stem == "choose":
        assert (seen["runs"].status == 0).any() and seen["how"].shape == seen["runs"].status.shape
        assert (tmp_path / "duffing.html").stat().st_size > 1e4
    if page.stem == "run":
        assert seen["theory"].order() == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page.read_text(), "yaml")], ids=_relative)
def test_the_configuration_of_a_page_is_accepted(page, tmp_path):
    folder = copied(tmp_path)
    (folder / "mine.yaml").write_text("\n".join(blocks(page.read_text(), "yaml")))
    planned = call_snakemake(folder, "-n", "--quiet", overlays=["mine.yaml"])
    assert planned.returncode == 0, planned.stderr + planned.stdout


COMMANDS = [words for page in PAGES for words in commands(page.read_text())]


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words[0])
def test_the_commands_of_the_pages_run(words, tmp_path):
    run_command(words, tmp_path)


def test_the_commands_are_those_of_the_package():
    assert {"list", "run", "recommend", "assess"} == {words[0] for words in COMMANDS}


def test_a_page_says_what_its_code_gives(tmp_path):
    results = tmp_path / "results"
    results.mkdir()
    (results / "numbers.json").write_text(json.dumps({"claims": "56"}))
    data = xr.Dataset({"u": ("t", [1.0, 2.5])}, attrs={"source": datasets.SOURCE})
    datasets.write(data, results / "own" / "data.nc")
    page = (
        'Of {{n["claims"]}}:\n\n```python\nimport study\n\ntop = study.open("own/data").u.max().item()\n```\n\n'
        "{{number(top)}}.\n\n![A curve](figure:curve)\n"
    )
    assert filled.reads(page) == ["own/data.nc", "figures/curve.svg", "numbers.json"]
    text = filled.filled(page, results)
    assert text.startswith("Of 56:") and "\n2.5.\n" in text and "```{figure} /figures/curve.svg" in text
    lines_first = "# A question?\n\n" + page[page.index("```python") :]
    question, answer, lines = (filled.filled(lines_first, results).index(one) for one in ("?", "2.5", "study.open"))
    assert question < answer < lines
    with pytest.raises(NameError):
        filled.filled(page.replace("number(top)", "number(bottom)"), results)
    with pytest.raises(SystemExit, match="must be named 'results'"):
        filled.filled(page, tmp_path)


def test_a_page_that_recommends_needs_what_that_reads():
    needed = filled.reads('```python\nstudy.recommend("softening", error=0.01)\n```')
    assert needed == [*(f"{name}.nc" for name in READS), "numbers.json"]


@pytest.mark.parametrize("page", GALLERY, ids=_relative)
def test_a_question_has_a_figure_a_paragraph_a_dataset_and_its_lines(page):
    text, figures = page.read_text(), {one.name for one in products.discover(["figures"]) if one.kind == "figure"}
    assert re.match(r"# .*\?\n", text) and len(blocks(text, "python")) == 1
    (shown,) = re.findall(r"\(figure:(\w+)\)", text)
    assert shown in figures and any(file.endswith(".nc") for file in filled.reads(text))
    assert len(re.findall(r"\{\{", text)) >= 2
    assert f"\n{page.stem}\n" in (page.parent / "index.md").read_text()


def test_there_are_enough_questions():
    assert len(GALLERY) >= 8


def test_the_interface_has_every_public_name_once():
    names = [name for group in interface.groups().values() for name in group]
    assert sorted(names) == sorted(interface.public_names()) and {"run", "materials", "Newmark"} <= set(names)
    pages = interface.pages()
    assert ".. autoclass:: study.Newmark" in pages["a_scheme_with_other_parameters"]
    assert f":doc:`houbolt </schemes/houbolt>`, {study.schemes['houbolt'].title}" in pages["what_can_be_run"]
    assert all(f"{name}`" in pages["index"] for name in names)


def _datasets_of_the_short_study() -> tuple[dict, list[str]]:
    experiments = discover()
    short = configuration.check(experiments, yaml.safe_load((PROJECT / "config" / "study.yaml").read_text()))
    return short, configuration.datasets_of(experiments, short)


def test_the_table_of_datasets_names_what_the_short_study_makes():
    _, made = _datasets_of_the_short_study()
    rows = re.findall(r"^\| `([\w/]+)` \|", (filled.FOLDER / "how_to" / "datasets.md").read_text(), re.MULTILINE)
    patterns = {row: re.compile(re.sub("[A-Z]+", r"\\w+", row)) for row in rows}
    assert len(rows) > 20 and len(set(rows)) == len(rows)
    assert [row for row, pattern in patterns.items() if not any(map(pattern.fullmatch, made))] == []
    assert [name for name in made if not any(pattern.fullmatch(name) for pattern in patterns.values())] == []


def test_the_step_of_the_site_depends_on_what_its_pages_show():
    short, made = _datasets_of_the_short_study()
    own = {"own_schemes": ["examples/scheme.py:heun"]}
    given = json.dumps({"configuration": short | own, "datasets": made})
    command = [sys.executable, "-m", "docs.plan", "."]
    done = subprocess.run(command, input=given, cwd=PROJECT, capture_output=True, text=True)
    (step,) = json.loads(done.stdout)["steps"]
    job = step["jobs"][""]
    assert job["command"] == "python -m docs.build results results/site examples/scheme.py:heun"
    wanted = {"results/accuracy.nc", "results/figures/atlas.svg", "results/numbers.json", "results/explorer.html"}
    sources = {
        "study/scheme/houbolt.py",
        "docs/conf.py",
        "docs/static/table.js",
        "CONTRIBUTING.md",
        "examples/scheme.py",
    }
    assert wanted | sources <= set(job["inputs"]) and step["outputs"] == ["results/site/index.html"]
    less = json.dumps({"configuration": short, "datasets": [name for name in made if name != "kinks"]})
    refused = subprocess.run(command, input=less, cwd=PROJECT, capture_output=True, text=True)
    assert refused.stderr == "page 'site' reads 'kinks', a dataset that this configuration does not make.\n"


def test_finding_the_step_takes_neither_jax_nor_the_study():
    code = "import sys, docs.plan; print({'jax', 'study', 'sphinx', 'matplotlib.pyplot'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True)
    assert done.stdout.strip() == "set()", done.stderr


def test_every_how_to_is_on_the_first_page():
    contents = (filled.FOLDER / "index.md").read_text()
    for page in (filled.FOLDER / "how_to").glob("*.md"):
        assert f"how_to/{page.stem}" in contents
    assert np.all([(PROJECT / name).exists() for name in plan.sources(PROJECT)])
