"""What a run of the pipeline finds in its folder: runs that live, and what runs that died have left there.

``python study/pipeline/runs.py PID`` enters the process PID of Snakemake as a run of the current folder. It prints as
JSON the name of the run, and sentences for the reader. It is a script that imports nothing of the study, and so starts
in a tenth of a second. Runs are known by files in ``.snakemake/runs``, and their jobs by the environment variable
``STUDY_RUN``. While no run lives, it ends jobs that have survived theirs, removes their unfinished files, and lifts the
lock. While one lives, the process is not entered. ``python study/pipeline/runs.py cancel`` cancels the jobs of the
folder in the queue of a cluster.
"""

import fcntl
import json
import os
import platform
import shutil
import subprocess
import sys
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import platformdirs
import psutil

#: Environment variable with the name of the run that a job belongs to.
VARIABLE = "STUDY_RUN"

#: Folder of the files that name runs, and that of Snakemake's locks.
RUNS, LOCKS = Path(".snakemake", "runs"), Path(".snakemake", "locks")

#: The start of a process is known to these seconds, since it is counted from the start of the machine.
CLOCK = 5.0

#: Folders in which a run writes.
WRITTEN = ("results", ".snakemake/plans")

#: First byte of what zlib has compressed.
ZLIB = b"\x78"

#: Seconds that a job has to end before it is killed.
PATIENCE = 3.0

#: Seconds in which Slurm's queue answers.
ANSWER = 5.0

#: A date this many seconds ahead lies in the future, and is not a clock that ticks a little faster elsewhere.
AHEAD = 60.0

#: Folders of sources, whose dates tell, beside those of the results, what must be made again.
SOURCES = ("config", "study", "reference", "paper", "docs", "examples")


class Run(NamedTuple):
    """A process of Snakemake on a machine, known by the time of its start too."""

    host: str
    pid: int
    started: float

    @property
    def name(self) -> str:
        """Name of its file, and of its jobs."""
        return f"{self.host}-{self.pid}-{self.started:.2f}"

    @property
    def is_here(self) -> bool:
        """Whether it runs or ran on this machine, so that its process can be looked for."""
        return self.host == platform.node()

    def lives(self) -> bool:
        """Whether its process is there; of another machine nobody knows, so that it counts as alive."""
        return not self.is_here or self._process() is not None

    def is_elsewhere(self) -> bool:
        """Whether its process is at work in another folder, of which this one is a copy."""
        process = self._process() if self.is_here else None
        try:
            return process is not None and not os.path.samefile(process.cwd(), Path.cwd())
        except (psutil.Error, OSError):  # the process of somebody else, or one that ends
            return False

    def _process(self) -> psutil.Process | None:
        try:
            process = psutil.Process(self.pid)
            same = abs(process.create_time() - self.started) < CLOCK
            return process if same and process.status() != psutil.STATUS_ZOMBIE else None
        except psutil.NoSuchProcess:
            return None


def of_process(pid: int) -> Run:
    """The run of a process of this machine."""
    return Run(platform.node(), pid, psutil.Process(pid).create_time())


def known() -> list[Run]:
    """The runs of this folder; other files of runs are removed."""
    found = []
    for file in sorted(RUNS.glob("*.json")):
        try:
            run = Run(*json.loads(file.read_text()))
        except (ValueError, TypeError):  # the file of a run that died while it wrote it
            file.unlink(missing_ok=True)
            continue
        if run.is_elsewhere():  # the file was copied with its folder
            file.unlink(missing_ok=True)
        else:
            found.append(run)
    return found


def jobs_of(names: set[str]) -> Iterator[psutil.Process]:
    """Processes of jobs of these runs."""
    for process in psutil.process_iter():
        try:
            if process.environ().get(VARIABLE) in names:
                yield process
        except (psutil.Error, OSError):  # processes of others, and those that have ended meanwhile
            continue


def queued_jobs() -> list[str]:
    """Numbers of the jobs in Slurm's queue that Snakemake has sent from this folder; none if there is no Slurm.

    Raises
    ------
    subprocess.TimeoutExpired
        If the queue does not answer.
    """
    if shutil.which("squeue") is None:
        return []
    command = ["squeue", "--me", "--noheader", "--format=%i|%k|%Z"]
    listed = subprocess.run(command, capture_output=True, text=True, timeout=ANSWER)
    jobs = [line.split("|", 2) for line in listed.stdout.splitlines() if line.count("|") >= 2]
    ours = ("rule_", "group_")  # as Snakemake comments its jobs; another job may have started Snakemake itself
    return [number for number, comment, folder in jobs if comment.startswith(ours) and Path(folder) == Path.cwd()]


def cancel_queued() -> int:
    """Cancel the jobs in Slurm's queue that come from this folder; how many there were."""
    queued = queued_jobs()
    if queued:
        subprocess.run(["scancel", *queued], check=False)
    return len(queued)


def end(processes: list[psutil.Process]) -> None:
    """End processes, by force where they do not end themselves."""
    for process in processes:
        try:
            process.terminate()
        except psutil.NoSuchProcess:
            continue
    _, alive = psutil.wait_procs(processes, PATIENCE)
    for process in alive:
        process.kill()
    psutil.wait_procs(alive, PATIENCE)


def removed_programs() -> Iterator[str]:
    """Remove compiled programs that cannot be read from JAX's cache, with a sentence.

    JAX does not replace them: each process would read them in vain, warn, and compile again. Only files that were
    written since the last check are read.
    """
    folder = platformdirs.user_cache_path("time-integration-study") / platform.node()
    checked = folder.with_name(f"{folder.name}.checked")
    if not os.access(folder.parent, os.W_OK):  # there is no cache yet, or it is somebody else's
        return
    now, last = time.time_ns(), checked.stat().st_mtime_ns if checked.exists() else 0
    recent = [file for file in folder.glob("*-cache") if file.stat().st_ctime_ns >= last]
    damaged = [file for file in recent if not _is_whole(file.read_bytes())]
    for file in damaged:
        file.unlink(missing_ok=True)
    if damaged:
        yield f"compiled programs in JAX's cache that cannot be read are removed: {len(damaged)}."
    if recent:
        checked.touch()
        os.utime(checked, ns=(now, now))


def _is_whole(program: bytes) -> bool:
    """Whether a compressed program can be read; of another compression than that of Python itself nobody knows."""
    if program and program[:1] != ZLIB:
        return True
    try:
        return bool(zlib.decompress(program))
    except zlib.error:
        return False


def _writer_lives(unfinished: Path) -> bool:
    """Whether the process that writes a file, whose number its name holds, is there."""
    number = unfinished.name.split(".")[-3]
    return number.isdecimal() and _status(int(number)) not in (None, psutil.STATUS_ZOMBIE)


def _status(pid: int) -> str | None:
    try:
        return psutil.Process(pid).status()
    except psutil.NoSuchProcess:
        return None


def cleared(dead: list[Run]) -> Iterator[str]:
    """Put away what dead runs have left, with a sentence for each kind of it."""
    surviving = list(jobs_of({run.name for run in dead}))
    if surviving:
        end(surviving)
        yield f"processes that had survived a run that died are ended, and their jobs start anew: {len(surviving)}."
    try:
        if dead and (number := cancel_queued()):
            yield f"jobs in Slurm's queue that had survived a run that died are cancelled, and start anew: {number}."
    except subprocess.TimeoutExpired:
        yield "Slurm's queue does not answer; jobs of a run that died may still be in it."
    begun = [file for folder in WRITTEN for file in Path(folder).rglob(".*.unfinished") if not _writer_lives(file)]
    for file in begun:
        shutil.rmtree(file) if file.is_dir() else file.unlink(missing_ok=True)
    if begun:
        yield f"files that a dead run had begun to write are removed, and no product among them: {len(begun)}."
    locks = list(LOCKS.glob("*")) if LOCKS.is_dir() else []
    for lock in locks:
        lock.unlink(missing_ok=True)
    if locks:
        yield "the folder was locked, and no run is at work in it; the lock is lifted."
    for run in dead:
        RUNS.joinpath(f"{run.name}.json").unlink(missing_ok=True)


def redated(now: float) -> Iterator[str]:
    """Set dates in the future to now: what is made of such a file would look older than it for ever."""
    root = Path(__file__).parents[2]
    folders = [Path("results"), *(root / name for name in SOURCES)]
    ahead = [
        file
        for folder in folders
        for file in folder.rglob("*")
        if file.is_file() and file.stat().st_mtime > now + AHEAD
    ]
    mended = {file for file in ahead if _has_date(file, now)}
    if mended:
        first = min(mended)
        yield f"dates that lay in the future, such as that of '{first}', are set to now: {len(mended)}."
    for file in ahead:
        if file not in mended:
            yield f"the date of '{file}' lies in the future and cannot be set; every call makes anew what reads it."


def _has_date(file: Path, date: float) -> bool:
    """Give a file a date, and tell whether it has it."""
    try:
        os.utime(file, (date, date))
    except OSError:
        return False
    return True


class Entered(NamedTuple):
    """The name of a run if no other one lives, and what was found in sentences."""

    name: str | None
    told: list[str]


def entered(pid: int) -> Entered:
    """Enter a process as a run of this folder, after everything dead is put away.

    Of two processes that enter at once, one waits for the other.
    """
    RUNS.mkdir(parents=True, exist_ok=True)
    with (RUNS / "entrance").open("w") as entrance:
        fcntl.flock(entrance, fcntl.LOCK_EX)
        return _entered(pid)


def _entered(pid: int) -> Entered:
    runs = [run for run in known() if run.pid != pid or not run.is_here]
    living = [run for run in runs if run.lives()]
    dead = [run for run in runs if run not in living]
    told = [
        f"process {run.pid} on '{run.host}' is at work in this folder since {time.ctime(run.started)}: wait for it, or "
        + ("end it." if run.is_here else "if it is dead, remove '" + str(RUNS / f"{run.name}.json") + "'.")
        for run in living
    ]
    if living:
        return Entered(None, told)
    told += [*cleared(dead), *removed_programs(), *redated(time.time())]
    new = of_process(pid)
    file = RUNS / f"{new.name}.json"
    file.with_suffix(".new").write_text(json.dumps(new))
    file.with_suffix(".new").replace(file)
    return Entered(new.name, told)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["cancel"]:
            try:
                cancel_queued()
            except subprocess.TimeoutExpired:
                raise SystemExit("Slurm's queue does not answer; jobs of this folder may still be in it.") from None
        case [pid]:
            print(json.dumps(entered(int(pid))))
