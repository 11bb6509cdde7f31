"""The reference of a program: steps are halved until two schemes agree, and one run of each scheme is repeated."""

import math
from collections.abc import Iterable

import numpy as np

from study.program.attempt import Run, difference
from study.program.definition import Program
from study.program.runs import Job, Runs
from study.program.truth import FEWEST_RUNS, Estimate, Truth, agreed, estimate
from study.sizes import CERTAIN
from study.words import listed, percent

#: ``WITHOUT_USE`` has the statuses of runs that return invalid results. ``FRUITLESS`` is the number of consecutive runs
#: with these statuses after which a scheme is not run at finer steps.
FRUITLESS, WITHOUT_USE = 4, ("nothing", "unusable")

#: Relative difference of two runs that round-off explains, and the ratio of two such differences, one after the other,
#: that the order of no scheme explains.
ROUND_OFF, SUDDEN = 1e-11, 1e6


class NoTruth(ValueError):
    """The runs of a program give no reference; the message states why, in one sentence."""


class Refinement:
    """The runs of a program, and the reference that follows from the runs with halved steps.

    Parameters
    ----------
    program, runs
        The program and its runs.
    smallest
        Smallest allowed error.

    Attributes
    ----------
    truth
        The reference, on which two schemes agree.
    remarks
        Sentences on the program as a whole.
    seconds
        Wall time of all runs that gave the reference, in s.
    noise
        Relative difference between a run of each scheme and its repetition, by scheme. It is infinite if the scheme
        ignores the step, or if the repeated run fails or returns other quantities or times.

    Raises
    ------
    NoTruth
        If fewer than two schemes run to the end at three successively halved steps, or a quantity is always zero.
    """

    def __init__(self, program: Program, runs: Runs, smallest: float):
        self._program, self._runs, self._smallest = program, runs, smallest
        self._shapes: dict[str, tuple] = {}
        self.remarks: list[str] = []
        self.noise = dict.fromkeys(program.all_schemes, 0.0)
        self.truth = self._find_truth()
        self.seconds = sum(run.elapsed for run in runs.by_job.values())
        self._repeat()

    def runs_of(self, scheme: str) -> list[Run]:
        """Runs of a scheme, the largest step first."""
        runs = [run for run in self._runs.by_job.values() if run.scheme == scheme]
        return sorted(runs, key=lambda run: -run.dt)

    def run(self, jobs: Iterable[Job]) -> list[Run]:
        """Make the runs for which there is time, and return them.

        A run whose quantities differ in name or shape from the quantities of the first run counts as failed.
        """
        runs = self._runs.run(jobs)
        for run in runs:
            shapes = {name: values.shape[1:] for name, values in run.values.items()}
            self._shapes = self._shapes or shapes
            if run.completed and shapes != self._shapes:
                reason = f"it returned {_listed(shapes)}, and the first run {_listed(self._shapes)}"
                self._runs.by_job[run.scheme, run.dt] = run._replace(status="unusable", reason=reason)
        return runs

    def _find_truth(self) -> Truth:
        """Halve the steps until two schemes agree to a tenth of the smallest error, and return the reference.

        Halving also ends at the program's finest step, if no scheme can be refined, if the time runs out, or if the two
        schemes converge to different motions.
        """
        target, truth, apart, done = self._smallest / CERTAIN, None, 0, set[str]()
        steps = [self._program.largest]
        while True:
            refined = [s for s in self._program.all_schemes if s not in done and not self._ends(s)]
            self.run((s, step) for s in refined for step in steps if (s, step) not in self._runs.by_job)
            estimated = [*(s for s in refined if not self._ignores(s)), *done]
            estimates = {s: estimate(self.last_completed(s), self._program.quantities) for s in estimated}
            completed = {s: value for s, value in estimates.items() if value}
            known = {s: value for s, value in completed.items() if not self._repeats(s, completed)}
            truth = agreed(known.values())
            if truth:
                self._check_sizes(truth)
                apart = apart + 1 if truth.apart and all(estimates.values()) else 0
                if max(truth.uncertainty.values()) <= target or apart > 1:
                    break
                work = {s: self._work(value, target) for s, value in known.items()}
                # only the two schemes that need the least work are refined, unless they converge to different motions
                pair = sorted(work, key=work.__getitem__)[:2]
                pair_truth = agreed(known[s] for s in pair)
                done = set() if truth.apart or (pair_truth and pair_truth.apart) else completed.keys() - pair
            steps.append(steps[-1] / 2)
            if not refined or self._runs.late or steps[-1] < self._program.smallest * (1 - 1e-9):
                break
        if truth is None:
            raise KeyboardInterrupt if self._runs.interrupted else NoTruth(self._lack_of_truth())
        self._judge(truth, target, apart > 1)
        return truth

    def _lack_of_truth(self) -> str:
        """Sentence on the schemes that give no reference, and why."""
        schemes_by_reason = dict[str, list[str]]()
        for scheme in self._program.all_schemes:
            if len(self.last_completed(scheme)) < FEWEST_RUNS and not self.noise[scheme]:
                schemes_by_reason.setdefault(self._reason(scheme), []).append(f"'{scheme}'")
        ends = [
            f"{listed(schemes)} end{'s' * (len(schemes) == 1)} {reason}"
            for reason, schemes in schemes_by_reason.items()
        ]
        return (
            f"there is no reference for '{self._program.title}', as fewer than two different schemes complete "
            f"{FEWEST_RUNS} runs at successively halved steps{' in the given time' * self._runs.late}: "
            f"{'; '.join(self.remarks + ends)}."
        )

    def _work(self, known: Estimate, target: float) -> float:
        """Estimated time in s of a run with the error ``target``, as if the scheme were of second order."""
        return self.runs_of(known.scheme)[-1].seconds * math.sqrt(max(1.0, max(known.error.values()) / target))

    def _check_sizes(self, truth: Truth) -> None:
        for name, size in truth.sizes.items():
            if not size:
                raise NoTruth(
                    f"the quantity '{name}' of '{self._program.title}' is zero at all times, so that an error relative "
                    "to it has no meaning; leave it out."
                )

    def last_completed(self, scheme: str) -> list[Run]:
        """Runs of a scheme at all steps finer than the finest step at which it failed."""
        runs = self.runs_of(scheme)
        failed = [place for place, run in enumerate(runs) if not run.completed]
        return runs[failed[-1] + 1 :] if failed else runs

    def _ends(self, scheme: str) -> bool:
        """Whether a scheme is not run at finer steps.

        The reason is that it ignores the step, that its finest run timed out, or that its last ``FRUITLESS`` runs
        returned invalid results.
        """
        last = [run.status for run in self.runs_of(scheme)[-FRUITLESS:]]
        fruitless = len(last) == FRUITLESS and all(status in WITHOUT_USE for status in last)
        return self.noise[scheme] > 0 or last[-1:] == ["timed_out"] or fruitless

    def _reason(self, scheme: str) -> str:
        failed = [run for run in self.runs_of(scheme) if not run.completed]
        return f"at Δt = {failed[-1].dt:.4g} s: {failed[-1].reason}" if failed else "with too few steps to halve"

    def _ignores(self, scheme: str) -> bool:
        """Whether a scheme ignores the step. If so, add a remark.

        Its two finest runs then agree to the last digit; or to round-off, although the runs before them are far apart,
        as where a program has a finest step of its own.
        """
        runs = self.last_completed(scheme)[-3:]
        if self.noise[scheme] or len(runs) < 2:
            return bool(self.noise[scheme])
        *before, coarse, fine = runs
        apart = _apart(coarse, fine)
        if apart == 0 or (apart < ROUND_OFF and any(_apart(run, coarse) > SUDDEN * apart for run in before)):
            self.noise[scheme] = math.inf
            self.remarks.append(
                f"'{scheme}' ignores the step: its runs at {coarse.dt:.4g} s and {fine.dt:.4g} s are the same to "
                f"{'round-off' if apart else 'the last digit'}"
            )
        return bool(self.noise[scheme])

    def _repeats(self, scheme: str, others: Iterable[str]) -> bool:
        """Whether all runs of a scheme are those of an earlier one to round-off. If so, add a remark."""
        runs = {run.dt: run for run in self.last_completed(scheme)}
        for other in others:
            if other == scheme:
                return False
            common = [(runs[run.dt], run) for run in self.last_completed(other) if run.dt in runs]
            if common and all(_apart(*pair) < ROUND_OFF for pair in common):
                remark = (
                    f"'{scheme}' returns the results of '{other}' to round-off, and is no second witness: the program "
                    "may ignore its scheme"
                )
                self.remarks += [remark] if remark not in self.remarks else []
                return True
        return False

    def _judge(self, truth: Truth, target: float, apart: bool) -> None:
        """Add a remark if the reference is not accurate enough for the smallest error, or holds at few times only."""
        name = max(truth.uncertainty, key=lambda quantity: truth.uncertainty[quantity])
        uncertainty = truth.uncertainty[name]
        if uncertainty <= target:
            if truth.fixed and (unseen := [quantity for quantity, error in truth.between.items() if error > target]):
                self.remarks.append(f"{_output(truth, unseen[0], target)}: its errors hold at these times only")
            last = self.last_completed(truth.best.scheme)[-1]
            skipped = round((last.t[1] - last.t[0]) / last.dt) if len(last.t) > 1 else 1
            if skipped > 1 and not truth.fixed:
                self.remarks.append(
                    f"a run has an output after every {skipped} steps, and errors between the outputs are not seen: "
                    "write every step"
                )
            return
        if truth.between[name] > uncertainty / 2 and not (truth.fixed or self._runs.late):
            self.remarks.append(
                f"{_output(truth, name, target)}: no step is recommended for its errors below "
                f"{percent(CERTAIN * uncertainty)}"
                if math.isfinite(uncertainty)
                else f"{_output(truth, name, target)}: no step is recommended"
            )
            return
        pair = f"'{truth.best.scheme}' and '{truth.witness.scheme}'"
        steps = f"at steps of {truth.best.dt:.4g} s and {truth.witness.dt:.4g} s"
        if self._runs.late:
            cause = "the time has run out"
        elif apart:
            cause = "halving changes each by far less, so they solve different problems"
        else:
            cause = "steps cannot be finer"
        self.remarks.append(
            f"{pair} agree to {percent(uncertainty)} of '{name}' only, {steps}, and {cause}: no step is recommended "
            f"for its errors below {percent(CERTAIN * uncertainty)}"
        )

    def _repeat(self) -> None:
        """Repeat the coarsest completed run of every scheme that does not ignore the step.

        A remark is added if a repetition fails or differs too much.
        """
        first = {s: next((run for run in self.runs_of(s) if run.completed), None) for s in self._program.all_schemes}
        known = {s: run for s, run in first.items() if run is not None and not self.noise[s]}
        repetitions = self._runs.run([(s, run.dt) for s, run in reversed(known.items())], repeat=1)
        for repetition in repetitions:
            noise = math.inf
            if repetition.completed:
                noise = difference(known[repetition.scheme], repetition, self.truth.sizes)
            self.noise[repetition.scheme] = noise
            if noise * CERTAIN > self._smallest:
                self.remarks.append(
                    f"'{repetition.scheme}' depends on the order of runs: a repeated run at {repetition.dt:.4g} s "
                    + (f"differs by {percent(noise)}" if repetition.completed else repetition.reason)
                )


def _output(truth: Truth, name: str, target: float) -> str:
    """Sentence on an output that is too coarse to follow a quantity: its spacing, and the spacing that it needs.

    The error of cubic splines is proportional to the fourth power of the spacing.
    """
    t, error = truth.best.motion[name].t, truth.between[name]
    gap = t[1] - t[0]
    needs = f"times about {gap * (target / error) ** 0.25:.2g} s apart" if math.isfinite(error) else "more times"
    return (
        f"the output of '{name}', {len(t)} times {gap:.4g} s apart at steps of {truth.best.dt:.4g} s, is too coarse to "
        f"follow it to {percent(target)}, which needs {needs}"
    )


def _listed(shapes: dict[str, tuple]) -> str:
    return ", ".join(f"'{name}'" + (f" of {len(shape)} axes" if shape else "") for name, shape in shapes.items())


def _apart(coarse: Run, fine: Run) -> float:
    """Largest difference of two runs at their common times, over the largest value of the quantity; ∞ if none moves."""
    ratio, apart = round(coarse.dt / fine.dt), []
    for name, coarse_values in coarse.values.items():
        if not coarse_values.any():
            continue
        fine_values = fine.values[name]
        if coarse_values.ndim and len(coarse.t) != len(fine.t):
            fine_values = fine_values[(ratio - 1) * (fine.t[0] > 0) :: ratio]
            coarse_values, fine_values = coarse_values[: len(fine_values)], fine_values[: len(coarse_values)]
        is_one = coarse_values.shape == fine_values.shape
        apart.append(np.abs(coarse_values - fine_values).max() / np.abs(coarse_values).max() if is_one else math.inf)
    return float(max(apart, default=math.inf))
