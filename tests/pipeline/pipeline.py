"""Calls of the pipeline in copies of the project."""

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).parents[2]
SMALL = Path("config", "small.yaml")
#: Command of Snakemake with interrupts enabled, because a shell disables them in tests that it runs in the background.
SNAKEMAKE = [
    sys.executable,
    "-c",
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from snakemake.cli import main; main()",
]
#: Names without suffix of products with measured times, which differ from run to run, and of products made from them.
TIMED = {
    "cpu_time",
    "reference_agreement",
    "work_precision",
    "assessment",
    "solvers",
    "families",
    "claims",
    "numbers",
    "tables",
    "manuscript",
    "supplement",
    "replication",
}


def copied(target: Path) -> Path:
    """Copy tracked and new files of the project, so that sources can be edited."""
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
    """Make the products with these paths below the results, or all products."""
    done = call_snakemake(folder, *(f"results/{product}" for product in products), **options)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]


def hashes_of(folder: Path) -> dict[str, str]:
    """Digests of products by path below the results of a folder, except products that depend on measured times."""
    files = (p for p in (folder / "results").rglob("*") if p.is_file())
    return {
        p.relative_to(folder / "results").as_posix(): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in files
        if p.relative_to(folder / "results").parts[0] not in {"logs", "benchmarks"} and p.stem not in TIMED
    }
