"""The start of a call of Snakemake: its plan, lock and worker. This module imports only the standard library."""

import fcntl
import hashlib
import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

#: Folders whose Python files and pages the plan depends on.
ROOMS = ("study", "reference", "pipeline", "paper", "docs")
#: Files with the plan of the last call and the lock of a run.
PLAN, LOCK = Path(".snakemake/plan.json"), Path(".snakemake/lock")
#: Minimum number of free bytes before a run begins.
ROOM = 2**24


class Refused(Exception):
    """The pipeline cannot make a plan or begin a run; the message states the reason."""


def planned(root: str, configuration: Any) -> dict[str, Any]:
    """The plan of :mod:`pipeline.plan`, kept until a source, the configuration or a folder in it changes.

    Raises
    ------
    Refused
        If the configuration cannot be run to its end, the folder cannot be written, or too little disk space is free.
    """
    try:
        for folder in ("results/logs", "results/benchmarks", PLAN.parent):
            Path(folder).mkdir(parents=True, exist_ok=True)
        if (free := shutil.disk_usage(".").free) < ROOM:
            raise Refused(f"only {free:,} bytes are free in '{Path.cwd()}': make room, and call again.")
        return _planned(root, json.dumps(configuration), str([*_listings(configuration)]))
    except OSError as error:
        raise Refused(f"'{error.filename}' cannot be written: {error.strerror}.") from None


def _listings(value: Any) -> Iterator[list[tuple[str, int]]]:
    """Names and times of change of the files in each folder that a configuration names."""
    if isinstance(value, str) and os.path.isdir(value):
        yield sorted((part.name, part.stat().st_mtime_ns) for part in os.scandir(value))
    elif isinstance(value, dict | list):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _listings(part)


def _planned(root: str, configuration: str, listings: str) -> dict[str, Any]:
    files = sorted(path for room in ROOMS for path in Path(root, room).rglob("*") if path.suffix in (".py", ".md"))
    content = b"".join(str(path).encode() + path.read_bytes() for path in files)
    key = hashlib.sha256(f"{sys.version}{root}{configuration}{listings}".encode() + content).hexdigest()
    if PLAN.exists() and (plan := json.loads(PLAN.read_text()))["key"] == key:
        return plan
    command = [sys.executable, "-m", "pipeline.plan", root]
    done = subprocess.run(command, input=configuration, capture_output=True, text=True)
    if done.returncode:
        raise Refused(done.stderr)
    plan = json.loads(done.stdout) | {"key": key}
    if "refused" in plan:
        raise Refused(plan["refused"])
    unfinished = PLAN.with_suffix(f".{os.getpid()}")
    unfinished.write_text(json.dumps(plan))
    unfinished.replace(PLAN)
    return plan


def begun(configuration: Any, local: bool) -> tuple:
    """Begin a run in the current folder.

    The run takes the lock of the folder, removes unfinished files and stores its configuration. A local run starts the
    worker. A run on a cluster cancels the queued jobs of a killed run.

    Returns
    -------
    tuple
        Handles that the process must keep until it ends. The kernel then lifts the lock, and the worker ends.

    Raises
    ------
    Refused
        If another run is at work in the folder.
    """
    lock = LOCK.open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise Refused(f"another run is at work in '{Path.cwd()}': wait for it, or end it.") from None
    for unfinished in list(Path("results").rglob(".*.unfinished")):  # left by a killed run: files, or the site
        shutil.rmtree(unfinished) if unfinished.is_dir() else unfinished.unlink()
    Path("results/configuration.json").write_text(json.dumps(configuration))
    if local:
        return lock, _worker()
    _cancel_queued()
    return (lock,)


def _worker() -> subprocess.Popen:
    for socket_of_killed in Path(".snakemake").glob("worker.*"):
        socket_of_killed.unlink(missing_ok=True)
    # each run has its own path, because the worker of the last run may end, and remove its path, after this run began
    os.environ["STUDY_WORKER"] = f".snakemake/worker.{os.getpid()}"
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(os.environ["STUDY_WORKER"])
        listener.listen(1000)
        number = listener.fileno()
        command = [sys.executable, "-m", "pipeline.worker", str(number)]
        environment = os.environ | {"OMP_NUM_THREADS": "1"}  # the jobs together use all cores
        return subprocess.Popen(
            command, pass_fds=[number], stdin=subprocess.PIPE, start_new_session=True, env=environment
        )


def _cancel_queued() -> None:
    """Cancel the jobs that a killed run has submitted to Slurm from this folder."""
    if shutil.which("squeue"):
        command = ["squeue", "--me", "--noheader", "--format=%i|%k|%Z"]
        listed = subprocess.run(command, capture_output=True, text=True).stdout.splitlines()
        jobs = [line.split("|", 2) for line in listed]
        # comments of Snakemake's jobs begin with these words; other jobs of the folder, such as this run, continue
        ours = [
            job for job, comment, place in jobs if comment.startswith(("rule_", "group_")) and place == str(Path.cwd())
        ]
        if ours:
            subprocess.run(["scancel", *ours])
