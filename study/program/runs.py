"""All runs of a program, which are kept on disk and made concurrently.

The source of a program does not determine its runs: it may read files, variables of the environment and libraries.
Every assessment therefore repeats one kept run of each scheme, and one that failed, before it uses any of them.
"""

import hashlib
import io as streams
import json
import math
import os
import pickle
import shutil
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
from study.program.attempt import Run, attempt, difference
from study.program.definition import Program, data_read
from study.settings import cores
from study.warn import warn
from study.words import listed, percent

#: Version of the format of files; a run in a file of another version is made again.
FORM = 4

#: Names of arrays in the file of a run: ``words`` has its scheme, status and reason, ``numbers`` its step, seconds and
#: elapsed time, and ``t`` its times.
WORDS, NUMBERS, T = "words", "numbers", "t"

#: Largest time of the kept run that is repeated, as a fraction of the time of all kept runs of its scheme.
REPEATED = 0.01

#: Relative difference of a run from its repetition by which a program has changed: at least the first number, at most
#: the second, and between them ten times the difference of an earlier repetition.
ROUND_OFF, CHANGED = 1e-6, 0.1

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
    """Runs of a program; each run is made once, except kept runs of each scheme, which are repeated.

    For each scheme, a run that completed and a run that failed are repeated. If a repeated run differs from the kept
    one, the program has changed: all kept runs are removed, and a warning states the difference.

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
    by_job
        All requested runs for which there was time, by scheme and step.
    late
        Whether a requested run was left out, because the time did not suffice or Ctrl-C ended the runs.
    interrupted
        Whether Ctrl-C has ended the runs.
    """

    def __init__(self, program: Program, seconds: float = math.inf, report: Callable[..., None] = lambda *words: None):
        self.program, self.by_job, self._report = program, dict[Job, Run](), report
        self._workers = program.workers or cores()
        key = json.dumps([FORM, program.identity(), float(program.duration).hex()])
        self._folder, self._checked, self._unsure = program.place / _digest(key), False, set[str]()
        self._pool = self._start()
        self._end, self._first, self.late, self.interrupted = time.monotonic() + seconds, 0.0, False, False

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
        data, worker_data = data_read(self.program.run), dict[str, bytes]()
        with suppress(BrokenProcessPool):  # a function of a notebook cannot be loaded in another process
            worker_data = pool.submit(data_read, self.program.run).result()
            if data == worker_data:
                return pool
        pool.shutdown()
        if names := [f"'{name}'" for name in data if worker_data and data[name] != worker_data.get(name)]:
            warn(
                f"the runs of '{self.program.title}' are made one after the other, because other processes would read "
                f"another value of {listed(names)}: pass it to the function by functools.partial."
            )
        return None

    def __enter__(self) -> "Runs":
        return self

    def __exit__(self, *exception: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def _place(self, scheme: str) -> Path:
        return self._folder / _digest(scheme)

    def _path(self, scheme: str, dt: float, repeat: int = 0) -> Path:
        return self._place(scheme) / f"{float(dt).hex()}_{repeat}.npz"

    def _check_kept(self) -> None:
        """Repeat kept runs of each scheme, and remove all kept runs if one differs from its repetition.

        The repeated runs are the finest completed one that takes little time, because coarse runs may miss a change,
        and a failed one, because its cause may be gone.
        """
        if self._checked:
            return
        self._checked = True
        kept = {(run.scheme, run.dt): run for scheme in self.program.all_schemes for run in self._sample(scheme)}
        if kept:
            schemes = listed(dict.fromkeys(scheme for scheme, _ in kept))
            self._report(f"one kept run of {schemes} is repeated, in case the program has changed")
        repetitions = {(run.scheme, run.dt): run for run in self._attempts([*kept])}
        self._unsure = {scheme for scheme, dt in kept if (scheme, dt) not in repetitions}
        completes = {scheme for (scheme, _), run in kept.items() if run.completed}
        changes = [
            change
            for (scheme, dt), run in kept.items()
            # where other runs complete, a failure may give other reasons, such as a time or the name of a file
            if (scheme, dt) in repetitions
            and (run.completed or repetitions[scheme, dt].completed or scheme not in completes)
            and (change := self._change(run, repetitions[scheme, dt]))
        ]
        if changes:
            # renamed first, so that a run that is killed here leaves no part of the kept runs
            discarded = self._folder.with_suffix(f".{os.getpid()}")
            self._folder.rename(discarded)
            shutil.rmtree(discarded)
            warn(
                f"the kept runs of '{self.program.title}' are discarded, because the program has changed or gives "
                f"other results each time: {changes[0]}."
            )
        for run in repetitions.values():
            _keep(run, self._path(run.scheme, run.dt))

    def _sample(self, scheme: str) -> list[Run]:
        """The kept runs of a scheme that are repeated: at most one that completed, and one that failed.

        The first is the finest completed run that takes at most the fraction ``REPEATED`` of the time of all runs, or
        the shortest run. The second is the shortest failed run; one that a time limit ended is
        repeated only if no run completed.
        """
        kept = [_read(path) for path in self._place(scheme).glob("*_0.npz")]
        completed = [run for run in kept if run.completed]
        limit = max(REPEATED * sum(run.elapsed for run in kept), min((run.elapsed for run in completed), default=0.0))
        finest = sorted((run for run in completed if run.elapsed <= limit), key=lambda run: run.dt)
        failed = [run for run in kept if not run.completed and not (completed and run.status == "timed_out")]
        return finest[:1] + sorted(failed, key=lambda run: run.elapsed)[:1]

    def _change(self, kept: Run, repetition: Run) -> str:
        """How a run differs from its repetition, in words; empty if it does not."""
        run = f"its run with '{kept.scheme}' at Δt = {kept.dt:.4g} s"
        kept_end, new_end = (
            (record.status, record.reason * (record.status != "timed_out")) for record in (kept, repetition)
        )
        if kept_end != new_end:
            before, after = kept.reason or kept.status, repetition.reason or repetition.status
            return f"{run}, which ended with '{before}', ends with '{after}'"
        deviation = difference(kept, repetition)
        if math.isinf(deviation):
            return f"{run} returns other times or quantities than the kept run"
        repeated = [_read(path) for path in self._place(kept.scheme).glob("*_1.npz")]
        noise = [difference(_read(self._path(second.scheme, second.dt)), second) for second in repeated]
        threshold = min(max(ROUND_OFF, 10 * max(noise, default=0.0)), CHANGED)
        return f"{run} differs by {percent(deviation)} from the kept run" if deviation > threshold else ""

    def run(self, requested: Iterable[Job], repeat: int = 0) -> list[Run]:
        """Read the wanted runs that are on disk, make the others for which there is time, and return these runs.

        ``repeat`` is the number of a repetition; zero stands for the first runs, which are added to ``made``.
        """
        self._check_kept()
        jobs = {job: self._path(*job, repeat) for job in requested}
        missing = [
            job
            for job, path in jobs.items()
            if job[0] in self._unsure or not path.exists() or self._waited_less(_read(path))
        ]
        expected = self._expected(missing)
        late = {*missing} - {*(missing := self._in_time(expected))}
        ends = time.monotonic() + self._wait([expected[job] for job in missing])
        waiting = {*missing}
        try:
            if missing:
                schemes, finest = ", ".join(dict.fromkeys(s for s, _ in missing)), min(dt for _, dt in missing)
                description = f"{len(missing)} run{'s' * (len(missing) > 1)} of {schemes} down to Δt = {finest:.4g} s"
                self._report(f"{description}{_to_go(ends)}", ends - time.monotonic())
            for number, run in enumerate(self._attempts(missing), start=1):
                _keep(run, jobs[run.scheme, run.dt])
                waiting.remove((run.scheme, run.dt))
                failure = "" if run.completed else f", {run.reason}"
                self._report(
                    f"{run.scheme}, Δt = {run.dt:.4g} s: {run.seconds:.3g} s ({number} of {len(missing)} runs"
                    f"{_to_go(ends)}){failure}"
                )
        except KeyboardInterrupt:  # the runs so far are returned, and no other run begins
            self._end, self.interrupted = -math.inf, True
        late |= waiting
        self.late |= bool(late) or self.interrupted
        runs = [_read(path) for job, path in jobs.items() if job not in late]
        if not repeat:
            self.by_job |= {(run.scheme, run.dt): run for run in runs}
        return runs

    def _expected(self, jobs: list[Job]) -> dict[Job, float]:
        """Estimated time in s of each run, from the least time per step in the completed runs of its scheme.

        Without such a run it is the longest time that any scheme took for its first run.
        """
        work = dict[str, float]()  # time in s of a run with a step of one second, by scheme
        for run in self.by_job.values():
            if run.completed:
                work[run.scheme] = min(work.get(run.scheme, math.inf), run.elapsed * run.dt)
        return {(s, dt): work[s] / dt if s in work else self._first for s, dt in jobs}

    def _wait(self, times: list[float]) -> float:
        """Expected wall time in s of all runs if several are made at once; ``times`` holds the time of every run."""
        return max(max(times, default=0.0), sum(times) / self._at_once)

    def _in_time(self, expected: dict[Job, float]) -> list[Job]:
        """The runs that are expected to end in time, the shortest first."""
        remaining, jobs = self._end - time.monotonic(), []
        total = remaining * self._at_once
        for job in sorted(expected, key=expected.__getitem__):
            total -= expected[job]
            # a run has only one worker, so it must also end in time by itself
            jobs += [job] if expected[job] < remaining and total > 0 else []
        return jobs

    def _waited_less(self, run: Run) -> bool:
        """Whether a run was stopped at a time limit that is shorter than the present one."""
        limit = getattr(self.program.run, "time_limit", None)
        return run.status == "timed_out" and (limit is None or run.elapsed < limit)

    def _attempts(self, jobs: list[Job]) -> Iterator[Run]:
        """Make runs, and yield each run when it ends; runs that are expected to end late do not begin."""
        if self._pool is None:
            for job in jobs:
                if not self._late(job):
                    yield self._measured(attempt(self.program.run, *job, self.program.duration))
            return
        waiting = {self._submit(job): job for job in jobs if not self._late(job)}
        lost = []
        for future in as_completed(waiting):
            if future.cancelled():
                continue
            try:
                run = self._measured(future.result())
            except BrokenProcessPool:  # one run has ended its process, which also ends all waiting runs
                lost.append(waiting[future])
                continue
            for pending, job in waiting.items():
                if self._late(job):
                    pending.cancel()
            yield run
        self._pool = self._start() if lost else self._pool
        for job in lost:
            yield self._alone(job)

    def _late(self, job: Job) -> bool:
        """Whether a run that begins now is expected to end late."""
        return time.monotonic() + self._expected([job])[job] > self._end

    def _measured(self, run: Run) -> Run:
        """The run, after its time has been noted if it is the first of its scheme, which may include compilation."""
        if run.scheme not in {scheme for scheme, _ in self.by_job}:
            self._first = max(self._first, run.elapsed)
        return run

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


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _to_go(ends: float) -> str:
    """Time that remains until the monotonic clock reads ``ends``, in words; empty if none remains."""
    remaining = ends - time.monotonic()
    return f", about {remaining:.2g} s to go" if remaining > 0 else ""


def _keep(run: Run, path: Path) -> None:
    content = streams.BytesIO()
    values = {f"{QUANTITY}{name}": array for name, array in run.values.items()}
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
        remedy = "remove it, and the run is made again."
        raise NotRead(f"'{path}' cannot be used, because it is damaged ({error}): {remedy}") from None
