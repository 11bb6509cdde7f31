"""The pipeline in copies of the project."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).parents[2]
SMALL = Path("tests", "pipeline", "small.yaml")


def copied(target: Path) -> Path:
    """Copy what is tracked and what is new, so that sources can be edited."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=PROJECT, capture_output=True, text=True
    ).stdout.split()
    for name in listed:
        if (PROJECT / name).exists():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(PROJECT / name, target / name)
    return target


def call_snakemake(folder: Path, *arguments: str, overlays=(SMALL,)) -> subprocess.CompletedProcess:
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    command = [sys.executable, "-m", "snakemake", *arguments, "--configfile", *map(str, overlays)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)


def make(folder: Path, *products: str, **options) -> None:
    """Make products below the results, or all."""
    done = call_snakemake(folder, *(f"results/{product}" for product in products), **options)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
