"""Kill the pipeline at random moments, and compare the products of the next calls with those of an undisturbed run.

``python tools/torture.py KILLS OUTPUT`` works in copies of the project. Before every kill some products are removed, so
that the pipeline has work. After every kill a plain call must succeed. OUTPUT is a table of kills, compared
products, differences and unfinished files.
"""

import hashlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd
import psutil

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.pipeline.pipeline import SMALL, call_snakemake, copied

#: Products that are made, removed and compared, by their paths in the folder of the results.
PRODUCTS = (
    "energy_drift.nc",
    "energy_error.nc",
    "houbolt_start.nc",
    "phase_portrait/hardening.nc",
    "phase_portrait/softening.nc",
    "round_off.nc",
    "sensitivity.nc",
    "figures/energy_drift.pdf",
    "figures/hardening.pdf",
    "figures/round_off.pdf",
)
#: Number of products that are removed before each kill.
REMOVED = 3


def _everything(run: subprocess.Popen, moment: float) -> bool:
    time.sleep(moment)
    at_work = run.poll() is None
    os.killpg(run.pid, signal.SIGKILL)
    return at_work


def _snakemake_alone(run: subprocess.Popen, moment: float) -> bool:
    time.sleep(moment)
    at_work = run.poll() is None
    run.kill()
    return at_work


def _one_job(run: subprocess.Popen, moment: float) -> bool:
    """Kill a running job, or the first one that starts if no job is running at that moment."""
    time.sleep(moment)
    jobs: list[psutil.Process] = []
    while not jobs and run.poll() is None:
        jobs = [job for job in _descendants(run) if "python" in job.name()]
    if jobs:
        random.choice(jobs).kill()
    return bool(jobs)


def _a_writer(run: subprocess.Popen, moment: float) -> bool:
    """Kill all jobs as soon as an unfinished file exists, and return whether an unfinished file appeared."""
    folders = {Path(psutil.Process(run.pid).cwd(), "results", name).parent for name in PRODUCTS}
    seen = False
    while not seen and run.poll() is None:
        seen = any(name.endswith(".unfinished") for folder in folders if folder.is_dir() for name in os.listdir(folder))
    for job in _descendants(run):
        job.kill()
    return seen


def _descendants(run: subprocess.Popen) -> list[psutil.Process]:
    try:
        return psutil.Process(run.pid).children(recursive=True)
    except psutil.NoSuchProcess:
        return []


MODES = {
    "everything": _everything,
    "Snakemake alone": _snakemake_alone,
    "one job": _one_job,
    "jobs while a file is written": _a_writer,
}


def _hashes(folder: Path) -> dict[str, str]:
    return {name: hashlib.sha256((folder / "results" / name).read_bytes()).hexdigest() for name in PRODUCTS}


def _killed(folder: Path, mode: str, moment: float) -> bool:
    """Start the pipeline, kill it in a way of ``MODES``, and return whether it was still at work."""
    command = [sys.executable, "-m", "snakemake", *_targets(), "--configfile", str(SMALL)]
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    with (folder / "torture.log").open("a") as log:
        run = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, env=environment, start_new_session=True)
        try:
            at_work = MODES[mode](run, moment)
        except (ProcessLookupError, psutil.NoSuchProcess):  # the run had just ended
            at_work = False
        run.wait()
    return at_work


def _remove(folder: Path, choose: random.Random) -> None:
    for name in choose.sample(PRODUCTS, REMOVED):
        (folder / "results" / name).unlink()


def _undisturbed(folder: Path, choose: random.Random) -> float:
    """Seconds of an undisturbed call with as much work as the killed calls."""
    _remove(folder, choose)
    start = time.monotonic()
    restarted(folder)
    return time.monotonic() - start


def _targets() -> list[str]:
    return [f"results/{name}" for name in PRODUCTS]


def torture(undisturbed: Path, tortured: Path, kills: int, seed: int = 0) -> pd.DataFrame:
    """Kill the pipeline repeatedly in a finished copy of the project; return a table with a row for each kind of kill.

    The moments of the kills are random within the time of an undisturbed call. The kill of jobs that write a file waits
    for an unfinished file instead.

    Raises
    ------
    RuntimeError
        If a call after a kill fails.
    """
    choose, expected, rows = random.Random(seed), _hashes(undisturbed), []
    latest = min(_undisturbed(tortured, choose) for _ in range(2))  # the first call in a copy makes the plan again
    for number in range(kills):
        mode = list(MODES)[number % len(MODES)]
        _remove(tortured, choose)
        at_work = _killed(tortured, mode, choose.uniform(0.0, latest))
        restarted(tortured)
        hashes = _hashes(tortured)
        leftover = len(list((tortured / "results").rglob(".*.unfinished")))
        rows.append((mode, 1, at_work, len(hashes), sum(hashes[name] != expected[name] for name in hashes), leftover))
        print(f"{number + 1} of {kills}: {mode}", file=sys.stderr)
    columns = ["killed", "kills", "of runs at work", "products compared", "differences", "unfinished files left"]
    return pd.DataFrame(rows, columns=columns).groupby("killed", sort=False).sum().astype(int).reset_index()


def restarted(folder: Path) -> None:
    """Make the products with a plain call."""
    process = call_snakemake(folder, *_targets())
    if process.returncode:
        raise RuntimeError(f"a plain call failed in {folder}:\n{(process.stdout + process.stderr)[-4000:]}")


if __name__ == "__main__":
    output = Path(sys.argv[2])
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        undisturbed, tortured = (copied(Path(place, name)) for name in ("undisturbed", "tortured"))
        for project in (undisturbed, tortured):
            restarted(project)
        summary = torture(undisturbed, tortured, int(sys.argv[1]))
    output.write_text(summary.to_csv(index=False))
    print(summary.to_string(index=False))
    sys.exit(bool(summary[["differences", "unfinished files left"]].to_numpy().any()))
