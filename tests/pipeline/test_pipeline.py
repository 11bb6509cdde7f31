"""The whole pipeline as `make` runs it, in a copy of the project."""

import csv
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import study

PROJECT = Path(__file__).parent.parent
#: Wall times differ from run to run; so does what is made of them.
TIMED = {
    "cpu_time",
    "reference_agreement",
    "work_precision",
    "recommendation",
    "solvers",
    "families",
    "needs",
    "claims",
    "numbers",
    "manuscript",
}

# one worker runs this whole file, so that the pipeline runs once for all of it
pytestmark = pytest.mark.slow


def _copy(target: Path) -> Path:
    """What is tracked and what is new, so that sources can be touched."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=PROJECT, capture_output=True, text=True
    ).stdout.split()
    for name in listed:
        if (PROJECT / name).exists():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(PROJECT / name, target / name)
    return target


_COMMAND = [sys.executable, "-m", "snakemake"]


def _snakemake(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    return subprocess.run([*_COMMAND, *arguments], cwd=folder, capture_output=True, text=True, env=environment)


@pytest.fixture(scope="module")
def project(tmp_path_factory) -> Path:
    """A copy of the project with everything made."""
    folder = _copy(tmp_path_factory.mktemp("project"))
    done = _snakemake(folder)
    assert done.returncode == 0, done.stderr[-4000:]
    return folder


def _would_run(folder: Path) -> set[str]:
    """The products that a further call would make again, under ``results`` and without ending."""
    done = _snakemake(folder, "--summary")
    assert done.returncode == 0, done.stderr[-4000:]
    rows = list(csv.DictReader(done.stdout.splitlines(), delimiter="\t"))
    assert len(rows) > 50
    pending = (Path(row["output_file"]) for row in rows if row["plan"] != "no update")
    return {path.relative_to("results").with_suffix("").as_posix() for path in pending}


def _hashes(folder: Path) -> dict[str, str]:
    files = (p for p in (folder / "results").rglob("*") if p.is_file())
    return {
        p.relative_to(folder / "results").as_posix(): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in files
        if p.relative_to(folder / "results").parts[0] not in {"logs", "benchmarks"} and p.stem not in TIMED
    }


def test_everything_is_made(project):
    results = project / "results"
    assert (results / "manuscript.pdf").read_bytes().startswith(b"%PDF")
    assert 1e6 < (results / "explorer.html").stat().st_size < 15e6
    for figure in ("hardening", "softening", "instability", "double_well", "energy_history", "energy_drift"):
        for suffix in (".pdf", ".png", ".svg"):
            assert (results / "figures" / f"{figure}{suffix}").stat().st_size > 5000
    for table in (results / "tables").glob("*.csv"):
        assert len(table.read_text().splitlines()) > 1
        assert "\\toprule" in table.with_suffix(".tex").read_text()


def test_datasets_explain_themselves(project):
    for path in (project / "results").rglob("*.nc"):
        ds = study.open(path.relative_to(project / "results").with_suffix("").as_posix(), project / "results")
        assert {"title", "source", "references", "history", "commit", "packages"} <= set(ds.attrs)
        for name, variable in ds.variables.items():
            assert variable.attrs.get("long_name"), (path, name)
            assert variable.dtype.kind in "UOT" or "units" in variable.attrs or "flag_values" in variable.attrs, (
                path,
                name,
            )


def test_the_ledger_is_decided(project):
    claims = list(csv.DictReader((project / "results" / "claims.csv").read_text().splitlines()))
    assert len(claims) >= 35
    assert {c["verdict"] for c in claims} <= {"reproduced", "reproduced with a qualification", "not reproduced"}
    for claim in claims:
        assert claim["verdict"] == "reproduced" or claim["reason"], claim["claim"]
    numbers = json.loads((project / "results" / "numbers.json").read_text())
    assert numbers["cells_rounded_twice"] == "97"


def test_a_second_call_has_nothing_to_do(project):
    assert _would_run(project) == set()


def test_one_core_gives_the_same_bytes_as_two(project, tmp_path):
    again = _copy(tmp_path)
    # some of everything that is not timed
    products = ["energy_error.nc", "energy_drift.nc", "round_off.nc", "figures/energy_drift.svg", "tables/schemes.csv"]
    done = _snakemake(again, "--cores", "1", "--", *(f"results/{product}" for product in products))
    assert done.returncode == 0, done.stderr[-4000:]
    made = _hashes(again)
    assert set(products) <= set(made)
    assert made.items() <= _hashes(project).items()


def _edited(path: Path):
    path.write_text(path.read_text() + "\n# edited\n")


def test_an_edited_scheme_reruns_what_used_it(project, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(project, copy)
    _edited(copy / "study" / "schemes" / "runge_kutta.py")
    rerun = _would_run(copy)
    assert {"energy_error", "energy_drift", "large_steps", "phase_portrait/hardening", "figures/energy_drift"} <= rerun
    assert not any(name.startswith("reference/") for name in rerun)

    shutil.rmtree(copy)
    shutil.copytree(project, copy)
    _edited(copy / "study" / "schemes" / "alpha.py")
    rerun = _would_run(copy)
    assert "energy_error" in rerun and "figures/instability" in rerun
    assert not {"energy_drift", "houbolt_start", "figures/energy_drift"} & rerun
    assert not any(name.startswith("reference/") for name in rerun)


def test_a_failed_job_leaves_what_was_there_and_is_made_anew(project, tmp_path):
    """Even where its parameters changed with it, which Snakemake has taken note of by then."""
    copy = tmp_path / "copy"
    shutil.copytree(project, copy)
    product, module = copy / "results" / "houbolt_start.nc", copy / "study" / "experiments" / "houbolt_start.py"
    before, source = product.read_bytes(), module.read_text()
    config = copy / "config" / "study.yaml"
    settings = yaml.safe_load(config.read_text())
    settings["houbolt_start"]["periods"] = 50
    config.write_text(yaml.safe_dump(settings))
    module.write_text("raise SystemExit('broken')\n")
    assert _snakemake(copy, "--", "results/houbolt_start.nc").returncode != 0
    assert product.read_bytes() == before
    module.write_text(source)
    assert "houbolt_start" in _would_run(copy)


def test_an_interrupted_atlas_goes_on_with_the_tiles_it_has(project, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(project, copy)
    stability = copy / "results" / "stability"
    missing = [stability / "tiles" / f"{scheme}_0.nc" for scheme in ("central_difference", "rk4")]
    for path in (*missing, stability / "atlas.nc"):
        path.unlink()
    # who runs the tests in the background has interrupts switched off
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from snakemake.cli import main; main()"
    )
    command = [sys.executable, "-c", code, "--cores", "1", "--", "results/stability/atlas.nc"]
    with subprocess.Popen(command, cwd=copy, stderr=subprocess.PIPE, text=True) as interrupted:
        assert any("Finished jobid" in line for line in interrupted.stderr)
        interrupted.send_signal(signal.SIGINT)
        interrupted.communicate()
    assert interrupted.returncode != 0 and sum(path.exists() for path in missing) == 1
    there = {path: path.stat().st_mtime_ns for path in (stability / "tiles").iterdir()}
    done = _snakemake(copy, "--", "results/stability/atlas.nc")
    assert done.returncode == 0, done.stderr[-4000:]
    assert {path: path.stat().st_mtime_ns for path in there} == there
    whole = "stability/atlas.nc"
    assert _hashes(copy)[whole] == _hashes(project)[whole]


def test_an_edited_figure_script_redraws_that_figure(project, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(project, copy)
    _edited(copy / "paper" / "figures" / "instability.py")
    assert _would_run(copy) == {"figures/instability", "manuscript"}


@pytest.mark.parametrize(
    "change, sentence",
    [
        (lambda c: c["cpu_time"].update(repeat=3), "cpu_time has no key 'repeat'; did you mean 'repeats'?"),
        (lambda c: c["large_steps"].update(problems=["hard"]), "there is no problem 'hard'; did you mean 'hardening'?"),
    ],
)
def test_a_wrong_configuration_stops_before_any_work(project, tmp_path, change, sentence):
    config = yaml.safe_load((project / "config" / "study.yaml").read_text())
    change(config)
    (tmp_path / "wrong.yaml").write_text(yaml.safe_dump(config))
    before = _hashes(project)
    done = _snakemake(project, "--configfile", str(tmp_path / "wrong.yaml"))
    assert done.returncode != 0
    assert sentence in done.stdout + done.stderr
    assert _hashes(project) == before


@pytest.mark.parametrize("arguments", [["--lint"], ["--rulegraph"], ["--report", "report.html"]])
def test_the_tools_of_snakemake_work(project, arguments):
    done = _snakemake(project, *arguments)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
