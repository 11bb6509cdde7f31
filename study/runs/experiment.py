"""Errors and costs of the schemes at many step sizes: the data from which needs and decisions follow."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated

import numpy as np
import pandas as pd
import xarray as xr
from annotated_types import Ge, Le, Len
from typing_extensions import TypedDict

from study import io
from study.assessment.reference import NoReference
from study.assessment.steps import spacing
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Checked, Count, FallingErrors, ProblemName, Schemes, rising, section
from study.marching.result import STATUSES_OR_NOT_RUN
from study.problem.inelastic import SCALES
from study.problem.named import approximate_periods, problems, time_scale_names, time_scales
from study.runs.measured import Motion, Starts, measured, quantities_of
from study.runs.needs import COSTS, DECIDED, keeps, moves_right, place_of_need
from study.runs.records import DIVIDING
from study.runs.schema import described, divides
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name
from study.sizes import CERTAIN, Limit, unbroken

#: Number of steps in a time scale at the coarsest step.
COARSEST = 4
#: Integer fractions and multiples of a record's spacing that are tried.
OF_SPACING = (*reversed(DIVIDING), *(1 / number for number in DIVIDING[1:]))
#: Number of steps in an octave that confirm a step, with one unknown and with several, whose runs take longer.
CONFIRMING, CONFIRMING_SEVERAL = 30, 4
#: Number of steps in a time scale of one unknown from which on, with smooth forces, the fewer steps of several unknowns
#: confirm a step. All others that were tried changed none of the 680 needs of the two springs.
FINE = 1000
#: Largest number of starts from which all steps are run if they march side by side.
FEW_STARTS = 4
#: Number of next finer steps of two digits that also confirm a step of several unknowns.
NEXT = 2
#: Factor of the number of steps that confirm a step of one unknown if the step is coarse.
DENSER = 3
#: Relative distances of further steps from whole numbers of steps in a time scale, and the number up to which they are
#: run. A resonance holds some schemes at an even number of steps in a period: the error is small there only, and the
#: narrower the finer the step is.
BESIDE, COARSE = (1e-4, 3e-4, 1e-3), 200


#: Durations in time scales, in ascending order.
Lengths = Annotated[list[Annotated[float, Ge(0.1), Le(10_000)]], Len(1, 10), Checked(rising)]


@section
class _Length(TypedDict):
    """Durations of runs in time scales, the finest number of steps in a time scale, and the number of other starts."""

    periods: Lengths
    decided: float
    finest: Count
    starts: Annotated[int, Ge(0), Le(1000)]


@section
class _Runs(TypedDict):
    problems: dict[ProblemName, _Length]
    schemes: Schemes
    allowed_errors: FallingErrors


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each problem."""
    shared = {key: options[key] for key in ("schemes", "allowed_errors")}
    return {name: {"problem": name, **length, **shared} for name, length in options["problems"].items()}


def _check(options: Options, configuration: Mapping) -> str | None:
    if options["decided"] not in options["periods"]:
        return f"decided: {options['decided']:g} is not one of the periods."
    if options["problem"] not in approximate_periods | SCALES | time_scales:
        return "problem: its steps cannot be counted; declare a time_scale with @named."
    return None


def _reads(options: Options) -> Iterable[str]:
    return [f"reference/{options['problem']}"] if options["problem"] in approximate_periods else []


def two_digits(number: float) -> int:
    """The least whole number not below ``number`` that has at most two digits other than zeros at the end."""
    unit = max(10 ** (math.floor(math.log10(number)) - 1), 1)
    return math.ceil(number / unit * (1 - 1e-12)) * int(unit)


def time_scale(problem: str) -> float:
    """Time by which steps are counted, in s: exact period of a spring, or the time scale of another problem."""
    if problem in approximate_periods:
        return io.open_dataset(f"reference/{problem}").period.item()
    return (SCALES | time_scales)[problem]


class _Ladder:
    """Runs of one scheme at numbers of steps in a time scale, from coarse to fine.

    Attributes
    ----------
    rows
        A row for each number of steps and each duration, from the problem's own start.
    varied
        A row for each run from another start.
    confirming
        Numbers of steps that were tried only to confirm coarser ones.
    """

    def __init__(
        self,
        scheme: Scheme,
        motion: Motion,
        starts: list[Starts],
        scale: float,
        periods: list[float],
        decided: float,
    ):
        self.scheme, self.motion, self.starts, self.scale = scheme, motion, starts, scale
        self.periods, self.decided = np.array(periods), periods.index(decided)
        self.several = sum(len(group.problems) for group in starts) > 1
        self.rows, self.varied = pd.DataFrame(), pd.DataFrame()
        self._own = self._largest = pd.DataFrame()
        self.confirming: set[float] = set()

    def _rows(self, starts: Starts, counts: Iterable[float], lengths: Mapping[int, Sequence[float]]) -> pd.DataFrame:
        """Runs at each number of steps, from some starts, over the numbers of periods that ``lengths`` has for each."""
        runs = pd.DataFrame(
            [(start, count, length) for start, periods in lengths.items() for count in counts for length in periods],
            columns=["start", "steps_per_period", "periods"],
        )
        runs = runs.assign(step_size=self.scale / runs.steps_per_period, duration=self.scale * runs.periods)
        shorter = [self.scale * length for length in self.periods[:-1]]
        return measured(self.scheme, starts, runs, shorter).drop(columns=["step_size", "duration"])

    def _others(self, starts: Starts) -> dict[int, list[float]]:
        """The decided number of periods for each start but the problem's own."""
        return {k: [self.periods[self.decided]] for k in range(starts is self.starts[0], len(starts.problems))}

    def run(self, counts: Iterable[float]) -> None:
        """Make runs from the problem's own start, and from few starts that march side by side also from the others."""
        if counts := sorted(counts):
            few = len(self.starts) == 1 < len(self.starts[0].problems) <= FEW_STARTS
            together = range(len(self.starts[0].problems) if few else 1)
            rows = self._rows(self.starts[0], counts, {k: [*self.periods] for k in together})
            self.rows = pd.concat([self.rows, rows[rows.start == 0]], ignore_index=True)
            if few:
                self.varied = pd.concat([self.varied, rows[rows.start > 0]], ignore_index=True)
            self._own, self._largest = self._errors()

    def vary(self, counts: Iterable[float]) -> None:
        """Make runs from other starts over the number of periods that decides.

        All numbers of periods would double the time with kinks of the force. They changed none of the 378 needs of the
        yielding oscillator, and none of the stiff and soft springs.
        """
        for starts in self.starts:
            if others := self._others(starts):
                self.varied = pd.concat([self.varied, self._rows(starts, counts, others)], ignore_index=True)
        self._own, self._largest = self._errors()

    def _errors(self) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Errors from the own start, and the largest from all starts, in ascending (steps_per_period, periods)."""
        names, index = self.motion.names, ["steps_per_period", "periods"]
        error = self.rows.set_index(index)[names].sort_index()
        if not len(self.varied):
            return error, error * np.nan
        worst = self.varied.fillna(dict.fromkeys(names, np.inf)).groupby(index)[names].max().reindex(error.index)
        return error, np.maximum(worst, error.fillna(np.inf))

    def dataset(self) -> xr.Dataset:
        """The runs over (steps_per_period, periods), and ``error`` and ``largest_error`` also over quantity."""
        names, order = self.motion.names, ("steps_per_period", "quantity", "periods")
        ds = self.rows.drop(columns=[*names, "start"]).set_index([order[0], order[2]]).to_xarray()
        both = (self._own, self._largest)
        error, largest = (errors.to_xarray().to_dataarray("quantity").transpose(*order) for errors in both)
        return ds.assign(error=error, largest_error=largest)

    def needed(self, limits: list[Limit], dividing: bool = False) -> list[tuple[float, float]]:
        """The number of steps that each limit needs, infinite if there is none, and the next smaller number tried.

        Every limit is in the list twice, without and with the bounds of the whole motion. ``dividing`` admits only
        steps that divide the spacing of a record.
        """
        names, shape = [*self._own], (-1, len(self.periods), self._own.shape[1])
        worst = np.fmax(self._own.values, self._largest.values).reshape(shape)[::-1]
        fine_first = self._own.index.unique("steps_per_period").values[::-1]
        counted = (divides(self.scale / fine_first, self.motion.spacing) == 1) | (not dividing)
        proposed, results = ~np.isin(fine_first, [*self.confirming]), list[tuple[float, float]]()
        for right in (True, moves_right(worst[:, self.decided], names)):
            for quantity, allowed in limits:
                errors = worst[..., names.index(quantity)]
                kept = keeps(errors, self.periods, self.periods[self.decided], allowed) & right
                place = place_of_need(kept, counted, proposed)
                coarser = fine_first[counted & ~unbroken(kept | ~counted)].max(initial=0.0)
                results.append((fine_first[place] if place >= 0 else math.inf, coarser))
        return results

    def search(self, limits: list[Limit], finest: int) -> None:
        """Make runs at half octaves until a finer octave confirms each need, then between need and next coarser step.

        All numbers of steps of two digits in between are tried. Under a record, numbers whose steps divide its spacing
        are tried too. Then finer steps confirm each need, up to twice as many. The steps that are needed and the next
        finer ones are run from all starts, with kinks of the force all finer ones that confirm a need, and all steps if
        the starts are few and march side by side.
        """
        top = COARSEST
        while True:
            known = set(self.rows.get("steps_per_period", ()))
            needed = self.needed(limits) if known else [(math.inf, 0.0)]
            dividing = self.needed(limits, dividing=True) if known and np.isfinite(self.motion.spacing) else []
            confirming = {count for need, _ in needed for count in self._finer(need, finest)}
            if top <= finest and max(known, default=0) <= max((need for need, _ in needed + dividing), default=0.0):
                self.run(self._octave(top) - known)
                top *= 2
            elif new := self._between(needed) - known:
                self.run(new)
            elif finer := confirming - known:
                self.confirming |= {count for count in finer if count != two_digits(count)}
                self.run(finer)
            elif others := self._to_vary([need for need, _ in needed + dividing if need < math.inf], known, confirming):
                self.vary(others)
            else:
                return

    def _octave(self, top: float) -> set[float]:
        """Numbers of steps from ``top`` up to twice as many: half octaves, and those that divide a record's spacing."""
        dividing = self.scale / (self.motion.spacing * np.array(OF_SPACING))  # NaN without a record
        return {two_digits(top), two_digits(top * math.sqrt(2)), *dividing[(dividing >= top) & (dividing < 2 * top)]}

    def _between(self, needed: list[tuple[float, float]]) -> set[float]:
        """All numbers of two digits between each need and the next coarser one, or the middle one of several unknowns.

        With several unknowns a run costs as much as its steps, so their intervals are halved.
        """
        numbers = [between(coarser, need) for need, coarser in needed]
        if self.motion.several:
            numbers = [counts[len(counts) // 2 :][:1] for counts in numbers]
        return {count for counts in numbers for count in counts}

    def _to_vary(self, needs: list[float], known: set[float], confirming: set[float]) -> set[float]:
        """Numbers of steps to run from the other starts: the needs and the next finer ones, then those that confirm.

        Those that confirm a need with kinks are run last, because other starts may refuse the need.
        """
        if not self.several:
            return set()
        varied = set(self.varied.steps_per_period) if len(self.varied) else set()
        wanted = {*needs, *(min((count for count in known if count > need), default=need) for need in needs)}
        if self.motion.problem.has_kinks and wanted <= varied:
            wanted = confirming
        return wanted - varied

    def _finer(self, need: float, finest: int) -> list[float]:
        """Numbers of steps that confirm a need, up to twice as many, on one geometric ladder.

        With one unknown they also lie next to whole numbers or, with kinks of the force, at numbers of two digits. With
        several unknowns they also are the next numbers of two digits.
        """
        if need == math.inf:
            return []
        fine = need >= FINE and not self.motion.problem.has_kinks
        per_octave = CONFIRMING_SEVERAL if self.motion.several or fine else CONFIRMING
        if need < COARSE and not self.motion.several:
            per_octave *= DENSER
        first = math.ceil(math.log2(need / COARSEST) * per_octave - 0.5)
        numbers = [COARSEST * 2 ** ((first + k + 0.5) / per_octave) for k in range(per_octave)]
        if self.motion.several:
            return numbers + [count for count in between(need, 2 * need) if count <= finest][:NEXT]
        if self.motion.problem.has_kinks:  # the starts have different periods, so that no step is a whole part of all
            return numbers + between(need, min(2 * need, finest))
        whole = range(math.ceil(need), int(min(2 * need, COARSE)) + 1)
        return numbers + [k * (1 + beside) for k in whole for beside in BESIDE]


def between(coarser: float, need: float) -> list[int]:
    """All whole numbers with two digits between two numbers.

    ``need`` may be infinite; ``coarser`` is zero if no smaller number was tried.
    """
    numbers, count = [], two_digits(max(coarser, COARSEST) * (1 + 1e-9))
    while coarser < count < need < math.inf:
        numbers.append(count)
        count = two_digits(count + 1)
    return numbers


@experiment("runs", model=_Runs, split=_jobs, reads=_reads, check=_check)
def runs(
    problem: ProblemName,
    schemes: Schemes,
    allowed_errors: FallingErrors,
    periods: Lengths,
    decided: float,
    finest: Count,
    starts: int,
) -> xr.Dataset:
    """Measure errors and costs of schemes at step sizes down to those that keep the allowed errors.

    The error of a quantity is its largest difference from the reference, over all unknowns and all steps, divided by
    its largest value. The error of the energy is that of the balance of energies. A step size is the time scale of the
    problem divided by a number of steps with two digits, or an integer fraction or multiple of the spacing of a record.

    Returns
    -------
    xarray.Dataset
        Over (scheme, size, quantity, periods): ``error`` from the problem's own start, and ``largest_error`` from all
        starts, NaN where only the own start was run. Over (scheme, size, periods): ``status``, and the costs of a run.
        Over (scheme, size): ``tried``. Over size: ``step_size``, ``steps_per_period``, ``omega_step``, ``divides``,
        whether the step size divides the spacing of a record, and ``proposed``, whether it may be an answer. Values of
        runs that were not made or failed are NaN. The attribute ``reference`` names the two solvers. Without a
        reference, it says why there is none, no scheme is run, and ``uncertainty`` is infinite.
    """
    scale, equation = time_scale(problem), problems[problem]
    parts: dict[str, xr.Dataset] = {}
    confirming: set[float] = set()
    try:
        motion = Motion.of(equation, max(periods) * scale, scale / COARSEST)
        all_starts = motion.starts(starts, scale)
    except NoReference as reason:
        progress(f"no scheme is run: {reason}")
        frequency, uncertainty, reference = np.nan, dict.fromkeys(quantities_of(equation), np.inf), str(reason)
    else:
        frequency, uncertainty, reference = motion.highest_frequency, motion.uncertainty, motion.solvers
        certain = {name: CERTAIN * uncertainty[name] for name in DECIDED if name in motion.names}
        limits = [(name, error) for name, least in certain.items() for error in allowed_errors if error >= least]
        for name in schemes:
            if schemes_by_name[name].refusal(motion.problem):
                continue
            progress(f"{name} on {problem}")
            ladder = _Ladder(schemes_by_name[name], motion, all_starts, scale, periods, decided)
            ladder.search(limits, finest)
            parts[name] = ladder.dataset()
            confirming |= ladder.confirming
    ds = _together(parts, schemes, [*uncertainty], periods)
    counts = ds.steps_per_period.values
    ds = ds.assign(
        status=ds.status.fillna(STATUSES_OR_NOT_RUN.index("not_run")).astype(np.int8),
        tried=ds.status.notnull().any("periods").astype(np.int8),
        uncertainty=("quantity", [uncertainty[name] for name in ds.quantity.values]),
    )
    return described(
        ds.rename(steps_per_period="size")
        .drop_vars("size")
        .assign_coords(
            step_size=("size", scale / counts),
            steps_per_period=("size", counts),
            proposed=("size", (~np.isin(counts, [*confirming])).astype(np.int8)),
        ),
        "largest error over all unknowns and steps, relative to the largest value",
        time_scale=scale,
        time_scale_name=time_scale_names[problem],
        highest_frequency=frequency,
        spacing=spacing(equation, max(periods) * scale) or np.nan,
        unknowns=np.size(equation.u0),
        decided=decided,
        starts=1 + starts,
        free_vibration=int(problem in approximate_periods),
        has_kinks=int(equation.has_kinks),
        problem=problem,
        problem_title=equation.title,
    ).assign_attrs(reference=reference)


def _together(
    parts: dict[str, xr.Dataset], schemes: Sequence[str], quantities: list[str], periods: Lengths
) -> xr.Dataset:
    """The runs of all schemes; if there is none, one number of steps without values."""
    if not parts:
        coords = {"steps_per_period": [float(COARSEST)], "quantity": quantities, "periods": periods}
        empty = xr.DataArray(np.nan, coords, ("steps_per_period", "quantity", "periods"))
        empty_cost = empty.isel(quantity=0, drop=True)
        values = dict.fromkeys(["error", "largest_error"], empty) | dict.fromkeys([*COSTS, "status"], empty_cost)
        parts = {schemes[0]: xr.Dataset(values)}
    ds = xr.concat(parts.values(), "scheme", join="outer").assign_coords(scheme=list(parts)).reindex(scheme=schemes)
    return ds.sortby("steps_per_period").transpose("scheme", "steps_per_period", "quantity", "periods")
