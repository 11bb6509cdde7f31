"""The whole pipeline as `make` runs it, in a copy of the project, on a small study."""

import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typst
import xarray as xr
import yaml
from snakemake.utils import update_config

import study
from paper.manuscript import TEXTS, numbered, uses
from tests.paper.figures.printing import faults_of_all
from tests.pipeline.additions import ADDED
from tests.pipeline.mutations import mutated
from tests.pipeline.pipeline import SMALL, call_snakemake, copied, hashes_of, make
from tests.pipeline.report import check_contents, check_explorer
from tests.pipeline.texts import check_ledger, check_pages
from tests.test_readme import check_the_results_of_the_readme


@pytest.fixture(scope="module")
def project(tmp_path_factory) -> Path:
    """A copy of the project in which all products have been made; one worker of pytest runs all tests of this file."""
    folder = copied(tmp_path_factory.mktemp("project"))
    make(folder)
    return folder


@pytest.fixture
def copy(project, tmp_path) -> Path:
    """A copy of ``project`` with its results, which a test may change."""
    return shutil.copytree(project, tmp_path / "copy")


def _would_run(folder: Path) -> set[str]:
    """Paths below ``results``, without suffix, of the products that a further call would make."""
    done = call_snakemake(folder, "--summary")
    assert done.returncode == 0, done.stderr[-4000:]
    rows = list(csv.DictReader(done.stdout.splitlines(), delimiter="\t"))
    assert len(rows) > 50
    pending = (Path(row["output_file"]) for row in rows if row["plan"] != "no update")
    return {path.relative_to("results").with_suffix("").as_posix() for path in pending}


def test_everything_is_made(project):
    results = project / "results"
    assert (results / "manuscript.pdf").read_bytes().startswith(b"%PDF")
    assert (results / "explorer.html").read_text().endswith("</html>\n")
    for figure in ("hardening", "softening", "instability", "double_well", "energy_drift"):
        for suffix in (".pdf", ".png", ".svg"):
            assert (results / "figures" / f"{figure}{suffix}").stat().st_size > 5000
        assert len((results / "figures" / f"{figure}.csv").read_text().splitlines()) > 10
    for table in (results / "tables").glob("*.csv"):
        assert len(table.read_text().splitlines()) > 1
        assert "\\toprule" in table.with_suffix(".tex").read_text()


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: text.stem)
def test_the_listed_figures_and_tables_are_those_that_typst_counts(project, text):
    inputs = {"results": str(project / "results")}
    elements = json.loads(typst.query(str(text), "figure", root="/", sys_inputs=inputs, ignore_system_fonts=True))
    figures = [Path(element["body"]["source"]).stem for element in elements if element["kind"] == "image"]
    listed = numbered(text)
    assert [name for label, name in listed if label.startswith("Figure")] == figures
    assert len(listed) - len(figures) == sum(element["kind"] == "table" for element in elements)
    assert "| Figure 1 | `figures/" in (project / "results" / "README.md").read_text()


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="Poppler is not installed")
def test_no_page_of_the_texts_is_overfull(project):
    """Words and figures that run out of the page, which Typst does not report."""
    check_pages(project / "results")


def test_nothing_is_wrong_with_figures_as_they_are_printed(project):
    """Labels that overlap, and text that is cut off or too small, which only drawn figures show."""
    (article,) = (text for text in TEXTS if text.stem == "manuscript")
    assert faults_of_all(project / "results", uses(article.read_text())["figure"]) == {}


def test_datasets_explain_themselves(project):
    for path in (project / "results").rglob("*.nc"):
        ds = study.open_dataset(path.relative_to(project / "results").with_suffix("").as_posix(), project / "results")
        assert {"title", "source", "references", "history", "commit", "packages"} <= set(ds.attrs)
        assert study.__version__ in ds.attrs["version"]
        for name, variable in ds.variables.items():
            assert variable.attrs.get("long_name"), (path, name)
            # values of several quantities have the units of their quantities
            unit = "units" in variable.attrs or ("quantity" in variable.dims and "quantity_units" in ds.coords)
            assert variable.dtype.kind in "UOT" or unit or "flag_values" in variable.attrs, (
                path,
                name,
            )


def test_datasets_keep_the_cf_conventions(project, tmp_path):
    """One file for every set of variables is checked; files with the same variables differ only in their numbers."""
    file_by_variables = {}
    for path in sorted((project / "results").rglob("*.nc")):
        with xr.open_dataset(path) as ds:
            file_by_variables[frozenset(ds.variables)] = path
    files = sorted(file_by_variables.values())
    report = tmp_path / "report.json"
    checker = Path(sys.executable).with_name("compliance-checker")
    options = ["--test", "cf:1.11", "--format", "json_new", "--output", report]
    subprocess.run([checker, *options, *files], capture_output=True, check=False)
    checks_by_file = json.loads(report.read_text())
    assert len(checks_by_file) == len(files) > 20
    for file, checks in checks_by_file.items():
        assert [check for check in checks["cf:1.11"]["all_priorities"] if check["msgs"]] == [], file


def test_the_ledger_is_decided(project):
    check_ledger(project / "results")


def test_the_readme_states_what_the_study_finds(project):
    check_the_results_of_the_readme(project / "results")


def test_a_second_call_has_nothing_to_do(project):
    """An input that changes with every call, so that nothing is ever up to date."""
    assert _would_run(project) == set()


def test_a_failed_job_states_why_and_is_made_again(copy):
    """A job that fails or reads an undeclared dataset in silence, or whose product is not made again."""
    product, module = copy / "results" / "houbolt_start.nc", copy / "study" / "experiments" / "houbolt_start.py"
    before, source = product.read_bytes(), module.read_text()
    module.write_text(source.replace("error = np.empty(", "raise ValueError('broken')\n    error = np.empty("))
    assert module.read_text() != source
    undeclared = ADDED["study/experiments/last_displacement.py"].replace('["reference/hardening"]', "[]")
    undeclared = undeclared.replace(
        "    end = run(", '    from study import io\n\n    io.open_dataset("spectral")\n    end = run('
    )
    (copy / "study/experiments/last_displacement.py").write_text(undeclared)
    done = call_snakemake(copy, "--keep-going", "results/houbolt_start.nc", "results/last_displacement.nc")
    assert done.returncode != 0 and "study.experiments.houbolt_start: broken" in done.stderr
    log = (copy / "results" / "logs" / "last_displacement.log").read_text()
    assert "the dataset 'spectral' is read without being declared" in log
    module.write_text(source)
    make(copy, "houbolt_start.nc")
    assert product.read_bytes() == before


def test_the_linter_of_snakemake_has_nothing_to_say(project):
    """A rule that Snakemake accepts but advises against."""
    done = call_snakemake(project, "--lint")
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]


def test_one_core_gives_the_same_bytes_as_two(project, tmp_path):
    """A product that depends on the number of cores or on when it is made."""
    again = copied(tmp_path)
    products = {"figures/energy_drift.svg", "stability/tiles/rk4_0.nc"}
    done = call_snakemake(again, "--cores", "1", *(f"results/{product}" for product in products))
    assert done.returncode == 0, done.stderr[-4000:]
    hashes = hashes_of(again)
    assert products <= set(hashes)
    assert hashes.items() <= hashes_of(project).items()


def test_an_edited_figure_script_redraws_that_figure(copy):
    """An edited script after which its figure is not drawn again, or after which too much is."""
    script = copy / "paper" / "figures" / "instability.py"
    script.write_text(script.read_text() + "\n# edited\n")
    assert _would_run(copy) == {"figures/instability", "manuscript", "supplement", "replication", "README"}


def test_a_wrong_configuration_stops_before_any_work(project, tmp_path):
    """A wrong key that Snakemake reports with a traceback, or after it has changed results."""
    (tmp_path / "wrong.yaml").write_text("{cpu_time: {repeat: 3}}")
    before = hashes_of(project)
    done = call_snakemake(project, overlays=[SMALL, tmp_path / "wrong.yaml"])
    assert done.returncode != 0
    assert "cpu_time has no key 'repeat'; did you mean 'repeats'?" in done.stdout + done.stderr
    assert "Traceback" not in done.stderr and hashes_of(project) == before


def test_an_archive_alone_makes_a_figure_again(project, tmp_path):
    """A file that a figure needs and the archive lacks."""
    command = [sys.executable, "-m", "pipeline.archive", ".", tmp_path / "archive.zip"]
    subprocess.run(command, cwd=project, check=True, capture_output=True)
    unpacked = tmp_path / "unpacked"
    shutil.unpack_archive(tmp_path / "archive.zip", unpacked)
    crate = {node["@id"]: node for node in json.loads((unpacked / "ro-crate-metadata.json").read_text())["@graph"]}
    run = crate["#run"]
    assert run["@type"] == "CreateAction" and run["instrument"] == {"@id": "snakefile"}
    assert {"@id": "results/energy_error.nc"} in run["result"] and {"@id": "configuration.yaml"} in run["object"]
    assert run["startTime"] <= run["endTime"] and crate["#package-jax"]["version"]
    figure = unpacked / "results" / "figures" / "instability.svg"
    for suffix in (".svg", ".pdf", ".png"):
        figure.with_suffix(suffix).unlink()
    make(unpacked, "figures/instability.svg")
    assert figure.read_bytes() == (project / "results" / "figures" / "instability.svg").read_bytes()


@pytest.fixture(scope="module")
def report(project):
    """Path of the page of Snakemake's report, in the unpacked report."""
    done = call_snakemake(project, "--report", "report.zip")
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
    shutil.unpack_archive(project / "report.zip", project / "unpacked")
    return project / "unpacked" / "report" / "report.html"


def test_the_report_opens_on_a_description_and_lists_what_was_made(project, report):
    check_contents(report, project / "results")


def test_the_explorer_opens_within_the_report(report, browser):
    check_explorer(report, browser)


def test_what_is_added_in_one_file_is_made(copy):
    """A list outside the file of an experiment, figure, table, claim or number that must name it too."""
    for name, text in ADDED.items():
        (copy / name).write_text(text)
    (copy / SMALL).write_text((copy / SMALL).read_text() + "\nlast_displacement: {steps: 50}\n")
    make(copy, "last_displacement.nc", "figures/last.png", "tables/last.csv", "claims.csv", "numbers.json")
    results = copy / "results"
    assert 0 < abs(study.open_dataset("last_displacement", results).u.item()) < 1.5
    assert "The last displacement is finite." in (results / "claims.csv").read_text()
    assert "last_displacement" in json.loads((results / "numbers.json").read_text())


#: Configuration with short runs, coarse grids and other values at which a product once failed.
UNUSUAL = {
    "phase_portrait": {"hardening": {"dt": 0.011, "duration": 0.5}},
    "sensitivity": {"duration": 5.0},
    "spectral": {"damping_ratios": [0.0, 0.3], "exponents": {"first": -2, "per_decade": 15}},
    "stability": {"bifurcation": {"shown": 7, "steps": 40}},
    "cpu_time": {"repeats": 1},
}


def test_what_is_accepted_runs_to_the_end(copy):
    """A configuration that is accepted but whose products fail, such as one number of steps where a fit needs two."""
    changes = mutated(2)
    update_config(changes, UNUSUAL)
    (copy / "changes.yaml").write_text(yaml.safe_dump(changes))
    make(copy, overlays=[SMALL, "changes.yaml"])
