"""All runs of a program, which are kept on disk and made concurrently."""

import hashlib
import io as streams
import json
import math
import os
import pickle
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from study.io import NotRead, write
from study.program.attempt import Run, attempt
from study.program.definition import Program
from study.settings import cores

#: Version of the format of files; a run in a file of another version is made again.
FORM = 2

#: Names of arrays in the file of a run: ``words`` has its scheme, status and reason, ``numbers`` its step, seconds and
#: elapsed time, and ``t`` its times.
WORDS, NUMBERS, T = "words", "numbers", "t"

#: Name of a scheme, and a step in s.
Job = tuple[str, float]

#: Prefix of the names of quantities in the file of a run.
QUANTITY = "quantity "


def _picklable(program: Program) -> bool:
    try:
        pickle.dumps(program.run)
    except (pickle.PicklingError, AttributeError, TypeError):
        return False
    return True


class Runs:
    """Runs of a program; each run is made once.

    Parameters
    ----------
    program
        The program.
    seconds
        Wall time in s from now. No run begins that is expected to end later.
    report
        Function of a sentence on the current work and, if it is known, the expected time of this work in s.

    Attributes
    ----------
    made
        All requested runs for which there was time, by scheme and step.
    late
        Whether a requested run was left out, because the time did not suffice or Ctrl-C ended the runs.
    interrupted
        Whether Ctrl-C has ended the runs.
    """

    def __init__(self, program: Program, seconds: float = math.inf, report: Callable[..., None] = lambda *words: None):
        self.program, self.made, self._report = program, dict[Job, Run](), report
        self._workers = program.workers or cores()
        self._identity, self._pool = program.identity(), self._start()
        self._end, self.late, self.interrupted = time.monotonic() + seconds, False, False

    @property
    def _at_once(self) -> int:
        return self._workers if self._pool else 1

    def _start(self) -> Executor | None:
        """The pool of workers; None if the runs are made one after the other in this process.

        The workers are threads if ``starts_a_process`` of the program's function is true, and otherwise processes.
        """
        if getattr(self.program.run, "starts_a_process", False):
            return ThreadPoolExecutor(self._workers)
        if self.program.workers == 1 or not _picklable(self.program):
            return None
        pool = ProcessPoolExecutor(self._workers, mp_context=get_context("spawn"))
        try:
            pool.submit(os.getpid).result()
        except BrokenProcessPool:
            raise RuntimeError(
                f"the processes for the runs of '{self.program.title}' end at once: put the code that starts them "
                'under `if __name__ == "__main__":`, or give the program workers=1.'
            ) from None
        return pool

    def __enter__(self) -> "Runs":
        return self

    def __exit__(self, *of_error: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def _path(self, scheme: str, dt: float, repeat: int) -> Path:
        key = json.dumps([FORM, self._identity, scheme, float(dt).hex(), float(self.program.duration).hex(), repeat])
        return self.program.place / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.npz"

    def run(self, wanted: Iterable[Job], repeat: int = 0) -> list[Run]:
        """Read the wanted runs that are on disk, make the others for which there is time, and return these runs.

        ``repeat`` is the number of a repetition; zero stands for the first runs, which are added to ``made``.
        """
        jobs = {job: self._path(*job, repeat) for job in wanted}
        missing = [job for job, path in jobs.items() if not path.exists() or self._waited_less(_read(path))]
        expected = self._expected(missing)
        late = {*missing} - {*(missing := self._in_time(expected))}
        self.late |= bool(late)
        ends = time.monotonic() + self._wait([expected[job] for job in missing])
        waiting = {*missing}
        try:
            if missing:
                schemes, finest = ", ".join(dict.fromkeys(s for s, _ in missing)), min(dt for _, dt in missing)
                what = f"{len(missing)} run{'s' * (len(missing) > 1)} of {schemes} down to Δt = {finest:.4g} s"
                self._report(f"{what}{_to_go(ends)}", ends - time.monotonic())
            for number, run in enumerate(self._made(missing), start=1):
                _keep(run, jobs[run.scheme, run.dt])
                waiting.remove((run.scheme, run.dt))
                ended = "" if run.completed else f", {run.reason}"
                self._report(
                    f"{run.scheme}, Δt = {run.dt:.4g} s: {run.seconds:.3g} s ({number} of {len(missing)} runs"
                    f"{_to_go(ends)}){ended}"
                )
        except KeyboardInterrupt:  # the runs so far are returned, and no other run begins
            self._end, self.late, self.interrupted = -math.inf, True, True
            late |= waiting
        found = [_read(path) for job, path in jobs.items() if job not in late]
        if not repeat:
            self.made |= {(run.scheme, run.dt): run for run in found}
        return found

    def _expected(self, jobs: list[Job]) -> dict[Job, float]:
        """Estimated time in s of each run, from the least time per step in the completed runs of its scheme.

        It is zero if the scheme has no completed run.
        """
        work = dict[str, float]()  # time in s of a run with a step of one second, by scheme
        for run in self.made.values():
            if run.completed:
                work[run.scheme] = min(work.get(run.scheme, math.inf), run.elapsed * run.dt)
        return {(s, dt): work.get(s, 0.0) / dt for s, dt in jobs}

    def _wait(self, each: list[float]) -> float:
        """Expected wall time in s of all runs if several are made at once; ``each`` holds the time of every run."""
        return max(max(each, default=0.0), sum(each) / self._at_once)

    def _in_time(self, expected: dict[Job, float]) -> list[Job]:
        """The runs that are expected to end in time, the shortest first."""
        left, found = self._end - time.monotonic(), []
        of_all = left * self._at_once
        for job in sorted(expected, key=expected.__getitem__):
            of_all -= expected[job]
            # a run has only one worker, so it must also end in time by itself
            found += [job] if expected[job] < left and of_all > 0 else []
        return found

    def _waited_less(self, run: Run) -> bool:
        """Whether a run was stopped at a time limit that is shorter than the present one."""
        limit = getattr(self.program.run, "time_limit", None)
        return run.status == "timed_out" and (limit is None or run.elapsed < limit)

    def _made(self, jobs: list[Job]) -> Iterator[Run]:
        """Make runs, and yield each run when it ends."""
        if self._pool is None:
            yield from (attempt(self.program.run, *job, self.program.duration) for job in jobs)
            return
        waiting = {self._submit(job): job for job in jobs}
        lost = []
        for one in as_completed(waiting):
            try:
                yield one.result()
            except BrokenProcessPool:  # one run has ended its process, which also ends all waiting runs
                lost.append(waiting[one])
        self._pool = self._start() if lost else self._pool
        for job in lost:
            yield self._alone(job)

    def _submit(self, job: Job) -> Future:
        assert self._pool is not None
        return self._pool.submit(attempt, self.program.run, *job, self.program.duration)

    def _alone(self, job: Job) -> Run:
        """Make a run alone, and record it as failed if it ends its process."""
        with suppress(BrokenProcessPool):
            return self._submit(job).result()
        self._pool = self._start()
        reason = "its process ended without an exception, as after a segmentation fault"
        return Run(*job, "signal", reason, np.nan, 0.0, np.empty(0), {})


def _to_go(ends: float) -> str:
    """Time that remains until the monotonic clock reads ``ends``, in words; empty if none remains."""
    left = ends - time.monotonic()
    return f", about {left:.2g} s to go" if left > 0 else ""


def _keep(run: Run, path: Path) -> None:
    content = streams.BytesIO()
    values = {f"{QUANTITY}{name}": one for name, one in run.values.items()}
    words, numbers = np.array([run.scheme, run.status, run.reason]), np.array([run.dt, run.seconds, run.elapsed])
    named: dict[str, Any] = {WORDS: words, NUMBERS: numbers, T: run.t} | values
    np.savez(content, **named)
    write(content.getvalue(), path)


def _read(path: Path) -> Run:
    try:
        with np.load(path, allow_pickle=False) as file:
            scheme, status, reason = map(str, file[WORDS])
            dt, seconds, elapsed = file[NUMBERS].tolist()
            values = {key.removeprefix(QUANTITY): file[key] for key in file.files if key.startswith(QUANTITY)}
            return Run(scheme, dt, status, reason, seconds, elapsed, file[T], values)
    except (OSError, ValueError, KeyError, BadZipFile) as error:
        again = "remove it, and the run is made again."
        raise NotRead(f"'{path}' cannot be used, because it is damaged ({error}): {again}") from None
