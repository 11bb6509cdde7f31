"""The steps that the schemes of a program need for an error, from its reference and few runs."""

import math
import zlib
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from study.program.attempt import WHOLE
from study.program.definition import Program
from study.program.refinement import Refinement
from study.program.runs import Job, Runs
from study.program.truth import FEWEST_RUNS
from study.sizes import CERTAIN, Limit, Needed, needed
from study.words import percent

#: Maximum ratio of the next larger step tried to the largest step that keeps an error. Above this ratio, a step in
#: between is tried.
NEAR = 1.25

#: Runs at random steps up to an octave below a recommended step: minimum number, maximum number, and time in s that
#: these runs may take in any case.
FEWEST_CONFIRMING, MOST_CONFIRMING, CHEAP = 4, 64, 0.5

#: Finest step at which a scheme that keeps no error is tried, as a fraction of the finest step of the reference.
FINER = 1 / 32

#: Largest ratio of a scheme's error at half a step to its error at the whole step; above it, the scheme converges to
#: another motion.
STUCK = 0.9


class Search:
    """The search for the steps of all schemes.

    Parameters
    ----------
    program
        The program.
    allowed
        Allowed errors, the largest first.
    round_step
        Function of a step and of the spacing of a record, which is None without a record. It returns the largest round
        step up to the given step.
    seconds
        Wall time in s from now. No run begins that is expected to end later.
    report
        Function of a sentence on the current work and, if it is known, the expected time of this work in s.

    Attributes
    ----------
    refinement
        The runs, and the reference.
    errors
        Error of each quantity in every run, by scheme and step; NaN if the run failed.

    Raises
    ------
    NoTruth
        As :class:`Refinement`.
    """

    def __init__(
        self,
        program: Program,
        allowed: list[float],
        round_step: Callable[[float, float | None], float],
        seconds: float,
        report: Callable[..., None],
    ):
        self.program, self.allowed, self._round_step = program, allowed, round_step
        self.errors: dict[Job, dict[str, float]] = {}
        self._late = False
        with Runs(program, seconds, report) as runs:
            self.refinement = Refinement(program, runs, allowed[-1])
            self.truth = self.refinement.truth
            self._measure()
            # Larger errors come first, because coarse steps suffice for them. The search is repeated, because a run for
            # a smaller error may also exceed a larger one.
            while any([self._search(error) for error in allowed]):
                pass
            self._late = runs.late
        self._remark(runs.interrupted)

    def _remark(self, interrupted: bool) -> None:
        """Add remarks on an interruption, and on schemes whose runs fail or cannot be compared.

        Failed runs are named if their times are unequal, which says nothing about their errors, or if they are over
        half of the runs of a scheme that keeps no error.
        """
        if interrupted:
            self.refinement.remarks.append("interrupted: no step is recommended where more runs were needed")
        limits = [(name, error) for name in self.truth.uncertainty for error in self.allowed]
        for scheme in self.program.schemes:
            runs = self.refinement.runs_of(scheme)
            failed = [run for run in runs if not run.completed]
            unequal = [run for run in failed if run.status == "unequal_times"]
            keeps = any(self.needed(scheme, limit).largest for limit in limits)
            incomparable = [
                run for run in runs if run.completed and self.truth.fixed and not self.truth.shares_times(run)
            ]
            if incomparable and any(
                self.truth.between[name] * CERTAIN > self.allowed[-1] for name in self.truth.between
            ):
                self.refinement.remarks.append(
                    f"the runs of '{scheme}' have other times at other steps, such as Δt = {incomparable[0].dt:.4g} s, "
                    f"and cannot be compared: {WHOLE}"
                )
            if failed := failed if 2 * len(failed) > len(runs) and not keeps else unequal:
                self.refinement.remarks.append(
                    f"{len(failed)} of {len(runs)} runs of '{scheme}' failed: at Δt = {failed[-1].dt:.4g} s, "
                    f"{failed[-1].reason}"
                )

    def _search(self, error: float) -> bool:
        """Make runs until every scheme has a verdict on an allowed error; return whether any run was made."""
        count = len(self.errors)
        while self.refinement.run(job for scheme in self.program.schemes for job in self._next_jobs(scheme, error)):
            self._measure()
        return len(self.errors) > count

    def _measure(self) -> None:
        """Add the errors of the new runs to ``errors``."""
        runs = (run for scheme in self.program.all_schemes for run in self.refinement.runs_of(scheme))
        new = [run for run in runs if (run.scheme, run.dt) not in self.errors]
        self.errors |= {(run.scheme, run.dt): self.truth.errors(run) for run in new}

    def certain(self, scheme: str, limit: Limit) -> bool:
        """Whether the reference and the runs of a scheme are accurate enough to judge an error."""
        return limit[1] >= CERTAIN * max(self.truth.uncertainty[limit[0]], self.refinement.noise[scheme])

    def needed(self, scheme: str, limit: Limit) -> Needed:
        """What the runs of a scheme need for an error."""
        name, allowed = limit
        dt, error = np.array([(dt, by_quantity[name]) for (s, dt), by_quantity in self.errors.items() if s == scheme]).T
        return needed(dt, error, allowed, self._round)

    def _next_jobs(self, scheme: str, error: float) -> list[Job]:
        """The next runs of a scheme for an allowed error; empty if no run is needed."""
        limits = [(name, error) for name in self.truth.uncertainty]
        steps = {step for limit in limits if self.certain(scheme, limit) for step in self._next(scheme, limit)}
        return [(scheme, step) for step in sorted(steps, reverse=True)]

    def _next(self, scheme: str, limit: Limit) -> list[float]:
        """Next steps to try for an allowed error; empty if no step is needed, or finer steps are of no use.

        If no step keeps the error, the next step is half of the finest step tried. Otherwise the next steps are, one
        after the other: a step between the largest step that keeps the error and the next larger step tried, the round
        step, and random steps that confirm it.
        """
        tried = {dt for s, dt in self.errors if s == scheme}
        largest, step, *_ = self.needed(scheme, limit)
        if not largest:
            finer = min(tried) / 2
            least = max(self.program.smallest, FINER * self.truth.best.dt)
            return [finer] if finer >= least and not self._hopeless(scheme, limit[0]) else []
        fails = min((dt for dt in tried if dt > largest), default=math.inf)
        if largest * NEAR < fails < math.inf:
            middle = self._round(math.sqrt(largest * fails))
            if largest < middle < fails:
                return [middle]
        if step not in tried:
            return [step]
        # one of the halved steps of the reference lies in this octave, and is not random
        count = self._confirming(scheme, step)
        missing = count + 1 - sum(step / 2 <= dt < step for dt in tried)
        return [dt for dt in self._random(scheme, step, count) if dt not in tried][: max(missing, 0)]

    def _confirming(self, scheme: str, step: float) -> int:
        """Number of random steps that confirm a recommended step.

        The number is at least ``FEWEST_CONFIRMING`` and at most ``MOST_CONFIRMING``. Between these limits, the runs may
        take a share of a quarter of the time of the reference, but at least ``CHEAP`` seconds. All combinations of
        scheme, quantity and allowed error have equal shares.
        """
        if self._late:
            return FEWEST_CONFIRMING
        limits = len(self.program.schemes) * len(self.allowed) * len(self.truth.uncertainty)
        affordable = max(self.refinement.seconds / (4 * limits), CHEAP)
        (run,) = (run for run in self.refinement.runs_of(scheme) if run.dt == step)
        # mean time of a run at a random step up to an octave below ``step``
        seconds = run.elapsed / math.log(2)
        return int(np.clip(affordable / seconds, FEWEST_CONFIRMING, MOST_CONFIRMING))

    def _round(self, step: float) -> float:
        return self._round_step(step, self.program.spacing)

    def _random(self, scheme: str, step: float, count: int) -> list[float]:
        """At most ``count`` random steps up to an octave below a step, the same steps in every search."""
        random = np.random.default_rng(zlib.crc32(f"{scheme} {step:.12g}".encode()))
        drawn = dict.fromkeys(self.program.fitted(step * 2.0**-part) for part in random.random(count))
        return [dt for dt in drawn if dt < step and dt >= self.program.smallest]

    def _hopeless(self, scheme: str, name: str) -> bool:
        """Whether finer steps are of no use, because the finest run timed out, or halving hardly reduces the error.

        In the second case a remark is added.
        """
        runs = self.refinement.runs_of(scheme)
        if runs[-1].status == "timed_out":
            return True
        finest = list[float]()
        for run in reversed(self.refinement.last_completed(scheme)):
            if not finest or run.dt > 1.99 * finest[-1]:
                finest.append(run.dt)
        last = [self.errors[scheme, dt][name] for dt in finest[:FEWEST_RUNS]]
        # only at steps as fine as the reference, because errors of an impact may persist over octaves of coarser steps
        stuck = len(last) == FEWEST_RUNS and finest[0] <= self.truth.best.dt * (1 + 1e-9)
        stuck = stuck and all(fine > STUCK * coarse for fine, coarse in pairwise(last))
        if stuck and last[0] > 2 * self.truth.between[name]:
            remark = (
                f"'{scheme}' converges to another motion: halving its steps to {finest[0]:.4g} s leaves an error of "
                f"{percent(last[0])} of '{name}'"
            )
            remarks = self.refinement.remarks
            remarks += [remark] if remark not in remarks else []
        return stuck

    def unfinished(self, scheme: str, limit: Limit) -> bool:
        """Whether the time ran out before the step for an error was found."""
        return self._late and bool(self._next(scheme, limit))
