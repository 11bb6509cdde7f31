"""What single calls of the pipeline leave to the next one, on one dataset that takes seconds."""

import json
import os
import platform
import time
from pathlib import Path

import pytest

from study.pipeline.runs import Run
from tests.pipeline.pipeline import SMALL, call_snakemake, copied

TARGET = "results/energy_drift.nc"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A copy of the project where the dataset is made, as every test leaves it."""
    folder = copied(tmp_path_factory.mktemp("project"))
    _call(folder)
    return folder


def _call(folder: Path, *arguments: str) -> str:
    """What a call that ends well says."""
    done = call_snakemake(folder, TARGET, *arguments)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
    return done.stderr


def test_a_damaged_product_is_made_again_whatever_its_date_and_whatever_run_has_died(folder):
    product = folder / TARGET
    before = product.read_bytes()
    product.write_bytes(b"damaged")
    later = time.time() + 2 * 86_400
    os.utime(product, (later, later))
    died = Run(platform.node(), 2**22 - 3, 1.0)
    (folder / ".snakemake" / "runs" / f"{died.name}.json").write_text(json.dumps(died))
    said = _call(folder)
    assert "is no longer what was made" in said and "dates that lay in the future" in said
    assert product.read_bytes() == before
    assert "is no longer what was made" not in _call(folder)


def test_a_dry_run_clears_nothing_and_the_plan_stays_that_of_the_last_real_one(folder):
    lock = folder / ".snakemake" / "locks" / "0.input.lock"  # a run that enters would lift it
    lock.parent.mkdir(exist_ok=True)
    lock.touch()
    kept = folder / ".snakemake" / "plans" / "last.json"
    before = kept.read_bytes()
    assert json.loads(before)["configuration"]["long_times"]["runs"] == 4  # as the small study says
    done = call_snakemake(folder, "-np", overlays=["config/full.yaml"])
    assert done.returncode == 0 and kept.read_bytes() == before
    lock.unlink()


def test_a_damaged_plan_is_made_anew(folder, tmp_path):
    """Also by a call from elsewhere, which leaves nothing but the plan."""
    kept = folder / ".snakemake" / "plans" / "last.json"
    before = kept.read_bytes()
    for plan in kept.parent.iterdir():
        plan.write_text("")
    options = "--directory", str(folder), "--snakefile", str(folder / "snakefile")
    done = call_snakemake(tmp_path, TARGET, *options, overlays=[folder / SMALL])
    assert done.returncode == 0, done.stderr[-4000:]
    assert kept.read_bytes() == before
    assert not list(tmp_path.iterdir()) and not list((folder / ".snakemake" / "runs").glob("*.json"))


def test_a_folder_of_logs_that_cannot_be_written_is_told_in_a_sentence(folder):
    logs = folder / "results" / "logs"
    kept = logs.rename(folder / "results" / "kept")
    logs.write_text("a file where a folder should be")
    done = call_snakemake(folder, TARGET)
    logs.unlink()
    kept.rename(logs)
    assert done.returncode != 0
    assert f"the folder '{logs}' cannot be made or written" in done.stderr and "Traceback" not in done.stderr
