"""The steps that the schemes of a program need: halved until two of them agree, then tried about the answer."""

import math
import time
import zlib
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from study.program.attempt import Run
from study.program.curves import same_values
from study.program.definition import Program
from study.program.runs import Runs
from study.program.truth import FEWEST_RUNS, Estimate, Truth, agreed, estimate
from study.words import percent

#: Least ratio of an error to the uncertainty of the truth.
CERTAIN = 10.0

#: Ratio of two steps, of which one keeps an error and one does not, that is small enough.
NEAR = 1.25

#: Steps up to an octave below a recommended one, most of them random, in addition to one of those that halve; and the
#: part of a recommended step down to which steps count as tried.
CONFIRMED, TWENTIETH = 4, 1 / 20

#: Part of the finest step of the truth down to which a scheme that keeps no error is tried.
FINER = 1 / 32

#: Ratio of the errors of a run and of one with half its step from which on the scheme goes to another motion.
STUCK = 0.9

#: A quantity, and the error that it is allowed.
Limit = tuple[str, float]

#: A scheme and a step.
Job = tuple[str, float]


class NoTruth(ValueError):
    """The runs of a program give no truth; the message says why, in one sentence."""


class Needed(NamedTuple):
    """The largest step that keeps an error, the round one below it, and what confirms that; zero if there is none."""

    largest: float
    recommended: float
    tried: int
    worst: float


class Search:
    """The search for the steps of all schemes.

    Parameters
    ----------
    program
        The program.
    allowed
        Allowed errors, the largest first.
    round_step
        The largest round step up to another one, for the spacing of a record or None.
    seconds
        Wall time after which no run begins that would end later.
    tell
        Takes a sentence on what is being done.

    Attributes
    ----------
    truth
        What two schemes agree on.
    errors
        Error of every run, by scheme and step: of each quantity.
    remarks
        Sentences on the program as a whole.
    noise
        Relative difference of a repeated run of each scheme; infinite if the scheme ignores the step.
    """

    def __init__(
        self,
        program: Program,
        allowed: list[float],
        round_step: Callable[[float, float | None], float],
        seconds: float,
        tell: Callable[[str], None],
    ):
        self.program, self.allowed, self._round_step = program, allowed, round_step
        self._end, self.out_of_time = time.monotonic() + seconds, False
        self.remarks: list[str] = []
        self.noise = dict.fromkeys(program.all_schemes, 0.0)
        self.errors: dict[tuple[str, float], dict[str, float]] = {}
        with Runs(program, tell) as self._runs:
            self.truth = self._find_truth()
            self._repeat()
            while self._run([job for scheme in program.schemes for job in self._wanted(scheme)]):
                pass

    # runs

    def of(self, scheme: str) -> list[Run]:
        """Runs of a scheme, the largest step first."""
        found = [run for run in self._runs.made.values() if run.scheme == scheme]
        return sorted(found, key=lambda run: -run.dt)

    def _run(self, jobs: Iterable[Job]) -> list[Job]:
        """Make the runs for which there is time, and return which."""
        made = self._in_time(jobs)
        for run in self._runs.run(made):
            if run.completed:
                shapes = {name: one.shape[1:] for name, one in run.values.items()}
                if not hasattr(self, "_shapes"):
                    self._shapes = shapes
                if shapes != self._shapes:
                    reason = f"it returned {_listed(shapes)}, and the first run {_listed(self._shapes)}"
                    run = self._runs.made[run.scheme, run.dt] = run._replace(status="unusable", reason=reason)
            if hasattr(self, "truth"):
                self.errors[run.scheme, run.dt] = self.truth.errors(run)
        return made

    def _in_time(self, jobs: Iterable[Job]) -> list[Job]:
        """The runs that will end in time, if a step takes as long as in the finest run of its scheme."""
        left, found = (self._end - time.monotonic()) * self._runs.workers, []
        expected = {job: self._expected(*job) for job in jobs}
        for job in sorted(expected, key=expected.__getitem__):
            left -= expected[job]
            found += [job] if left > 0 else []
        self.out_of_time |= len(found) < len(expected)
        return found

    def _expected(self, scheme: str, dt: float) -> float:
        """Seconds that a run will take; none if no run of its scheme is known."""
        known = [run for run in self.of(scheme) if run.completed]
        return known[-1].seconds * known[-1].dt / dt if known else 0.0

    # truth

    def _find_truth(self) -> Truth:
        """Halve the steps until two schemes agree to a tenth of the smallest error."""
        wanted, truth, apart, done = self.allowed[-1] / CERTAIN, None, 0, set[str]()
        steps = [self.program.largest]
        while True:
            refined = [s for s in self.program.all_schemes if s not in done and not self._ends(s)]
            self._run((s, step) for s in refined for step in steps if (s, step) not in self._runs.made)
            estimates = {s: estimate(self._last_completed(s)) for s in refined if not self._ignores(s)} | {
                s: estimate(self._last_completed(s)) for s in done
            }
            truth = agreed(one for one in estimates.values() if one)
            if truth:
                if zero := [name for name, size in truth.sizes.items() if not size]:
                    raise NoTruth(
                        f"the quantity '{zero[0]}' of '{self.program.title}' is zero all the time, so that an error "
                        "relative to it has no meaning; leave it out."
                    )
                apart = apart + 1 if truth.apart and all(estimates.values()) else 0
                if max(truth.uncertainty.values()) <= wanted or apart > 1:
                    break
                work = {s: self._work(one, wanted) for s, one in estimates.items() if one}
                # as long as schemes agree, the two that need the least work decide
                done = set() if truth.apart else set(sorted(work, key=work.__getitem__)[2:])
            steps.append(steps[-1] / 2)
            if not refined or self.out_of_time or steps[-1] < self.program.smallest * (1 - 1e-9):
                break
        if truth is None:
            reasons = "; ".join(self.remarks + [f"'{s}' {self._reason(s)}" for s in self.program.all_schemes])
            raise NoTruth(
                f"there is no truth for '{self.program.title}', as fewer than two schemes complete {FEWEST_RUNS} runs "
                f"at steps that halve: {reasons}."
            )
        self.errors = {job: truth.errors(run) for job, run in self._runs.made.items()}
        self._judge(truth, wanted, apart > 1)
        return truth

    def _work(self, one: Estimate, wanted: float) -> float:
        """Seconds in which a scheme of second order would reach an error."""
        return self.of(one.scheme)[-1].seconds * math.sqrt(max(1.0, max(one.error.values()) / wanted))

    def _last_completed(self, scheme: str) -> list[Run]:
        """Runs of a scheme at its finest steps, from the last failure on."""
        runs = self.of(scheme)
        failed = [place for place, run in enumerate(runs) if not run.completed]
        return runs[failed[-1] + 1 :] if failed else runs

    def _ends(self, scheme: str) -> bool:
        """Whether finer runs of a scheme have no use."""
        runs = self.of(scheme)
        return self.noise[scheme] > 0 or bool(runs and runs[-1].status == "timed_out")

    def _reason(self, scheme: str) -> str:
        failed = [run for run in self.of(scheme) if not run.completed]
        return f"ends at Δt = {failed[-1].dt:.4g} s: {failed[-1].reason}" if failed else "has too few steps to halve"

    def _ignores(self, scheme: str) -> bool:
        """Whether two runs of a scheme are the same to the last digit; a remark says so."""
        runs = self._last_completed(scheme)[-2:]
        if self.noise[scheme] or len(runs) < 2:
            return bool(self.noise[scheme])
        coarse, fine = runs
        ratio = round(coarse.dt / fine.dt)
        if all(same_values(coarse, fine, name, ratio) for name in coarse.values):
            self.noise[scheme] = math.inf
            self.remarks.append(
                f"'{scheme}' ignores the step: its runs at {coarse.dt:.4g} s and {fine.dt:.4g} s are the same to the "
                "last digit"
            )
        return bool(self.noise[scheme])

    def _judge(self, truth: Truth, wanted: float, apart: bool) -> None:
        """A remark if the truth is not as good as the smallest error needs."""
        name = max(truth.uncertainty, key=lambda one: truth.uncertainty[one])
        off = truth.uncertainty[name]
        if off <= wanted:
            return
        pair = f"'{truth.best.scheme}' and '{truth.witness.scheme}'"
        steps = f"at steps of {truth.best.dt:.4g} s and {truth.witness.dt:.4g} s"
        why = "halving changes each by far less, so they solve different problems" if apart else "none finer may be run"
        why = "the time is over" if self.out_of_time else why
        self.remarks.append(
            f"{pair} agree to {percent(off)} of '{name}' only, {steps}, and {why}: no step is named for errors "
            f"below {percent(CERTAIN * off)}"
        )

    def _repeat(self) -> None:
        """Repeat a cheap run of every scheme, which must return the same."""
        first = {s: next((run for run in self.of(s) if run.completed), None) for s in self.program.all_schemes}
        known = {s: run for s, run in first.items() if run is not None and not self.noise[s]}
        again = self._runs.run([(s, run.dt) for s, run in reversed(known.items())], repeat=1)
        for other in again:
            one, self.noise[other.scheme] = known[other.scheme], math.inf
            if other.completed and other.t.shape == one.t.shape and other.values.keys() == one.values.keys():
                sizes = self.truth.sizes
                apart = {n: np.abs(one.values[n] - other.values[n]).max() / sizes[n] for n in sizes}
                self.noise[other.scheme] = max(apart.values())
            if self.noise[other.scheme] * CERTAIN > self.allowed[-1]:
                self.remarks.append(
                    f"'{other.scheme}' depends on the order of runs: a repeated run at {other.dt:.4g} s "
                    + (f"differs by {percent(self.noise[other.scheme])}" if other.completed else other.reason)
                )

    # steps

    def certain(self, scheme: str, limit: Limit) -> bool:
        """Whether the truth, and the runs of a scheme, are good enough to judge an error."""
        return limit[1] >= CERTAIN * max(self.truth.uncertainty[limit[0]], self.noise[scheme])

    def largest(self, scheme: str, limit: Limit) -> tuple[float, float]:
        """Largest step tried below which all keep an error, zero if there is none, and the next one above."""
        name, allowed = limit
        errors = {dt: one[name] for (s, dt), one in self.errors.items() if s == scheme}
        fails = min((dt for dt, error in errors.items() if not error <= allowed), default=math.inf)
        return max((dt for dt in errors if dt < fails), default=0.0), fails

    def _wanted(self, scheme: str) -> list[Job]:
        """The next runs of a scheme; none if all is known."""
        limits = [(name, error) for name in self.truth.uncertainty for error in self.allowed]
        steps = {step for limit in limits if self.certain(scheme, limit) for step in self._next(scheme, limit)}
        return [(scheme, step) for step in sorted(steps, reverse=True)]

    def _next(self, scheme: str, limit: Limit) -> list[float]:
        """Steps to try for one error: finer ones, closer ones, the round one, or random ones below it."""
        tried = {dt for s, dt in self.errors if s == scheme}
        largest, fails = self.largest(scheme, limit)
        if not largest:
            finer = min(tried) / 2
            least = max(self.program.smallest, FINER * self.truth.best.dt)
            return [finer] if finer >= least and not self._hopeless(scheme, limit[0]) else []
        if largest * NEAR < fails < math.inf:
            between = self._round(math.sqrt(largest * fails))
            if largest < between < fails:
                return [between]
        step = self._round(largest)
        if step not in tried:
            return [step]
        # one of those that halve is there
        missing = CONFIRMED + 1 - sum(step / 2 <= dt < step for dt in tried)
        return [one for one in self._random(scheme, step, missing) if one not in tried] if missing > 0 else []

    def _round(self, step: float) -> float:
        return self._round_step(step, self.program.spacing)

    def _random(self, scheme: str, step: float, count: int) -> set[float]:
        """Random steps up to an octave below another one, the same whenever they are drawn."""
        random = np.random.default_rng(zlib.crc32(f"{scheme} {step:.12g}".encode()))
        drawn = {self.program.fitted(step * 2.0**-part) for part in random.random(count)}
        return {one for one in drawn if one < step and one >= self.program.smallest}

    def _hopeless(self, scheme: str, name: str) -> bool:
        """Whether halving does not help a scheme any more; a remark says so."""
        runs = self.of(scheme)
        if runs[-1].status == "timed_out":
            return True
        last = [self.errors[scheme, run.dt][name] for run in self._last_completed(scheme)[-FEWEST_RUNS:]]
        stuck = len(last) == FEWEST_RUNS and all(b > STUCK * a for a, b in pairwise(last))
        if stuck:
            remark = f"'{scheme}' goes to another motion: it keeps an error of {percent(last[-1])} of '{name}'"
            self.remarks += [remark] if remark not in self.remarks else []
        return stuck

    def unfinished(self, scheme: str, limit: Limit) -> bool:
        """Whether the time was over before the steps for an error were known."""
        return self.out_of_time and bool(self._next(scheme, limit))

    def needed(self, scheme: str, limit: Limit) -> Needed:
        """What the runs say about an error."""
        largest, _ = self.largest(scheme, limit)
        if not largest:
            return Needed(0.0, 0.0, 0, math.nan)
        step = self._round(largest)
        around = [
            one[limit[0]] for (s, dt), one in self.errors.items() if s == scheme and TWENTIETH * step <= dt <= step
        ]
        return Needed(largest, step, len(around), max(around) / limit[1])


def _listed(shapes: dict[str, tuple]) -> str:
    return ", ".join(f"'{name}'" + (f" of {len(shape)} axes" if shape else "") for name, shape in shapes.items())
