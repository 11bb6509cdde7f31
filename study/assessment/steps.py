"""The largest step that keeps an error: runs of one scheme at many random steps, octave by octave."""

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
import xarray as xr

from study.analysis.duration import round_down
from study.assessment.search import Case, Search
from study.marching.ensemble import FEW, TILE
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.scheme.base import Scheme
from study.settings import cores
from study.sizes import TWENTIETH, Limit

#: Number of steps in a period of the slowest small motion at the coarsest step, with which a search begins.
COARSEST = 4

#: Limits of the finest step of a search. ``FINEST`` is a number of steps in a period of the slowest small motion, and
#: ``FINEST_OF_RUN`` a number of steps × unknowns of a run; the limit that allows more steps holds. ``MOST_STEPS`` is
#: the largest number of steps of a run with the finest step.
FINEST, FINEST_OF_RUN, MOST_STEPS = 2048, 250_000, 4_000_000

#: ``FINEST_OF_HIGHEST`` is the finest Δt·ω of a search, with the highest frequency ω of the motion, since stiff modes
#: need finer steps than the slowest period suggests. ``STEPS_OF_HIGHEST`` and ``WORK_OF_HIGHEST`` are caps on the steps
#: and on the steps × unknowns of a run with this Δt·ω.
FINEST_OF_HIGHEST, STEPS_OF_HIGHEST, WORK_OF_HIGHEST = 0.03, 20_000, 4_000_000

#: Ratio of the finest step tried to the finest step wanted, up to which no finer step is tried. Without this margin,
#: a slight reduction of the largest step that keeps an error would need further runs.
ENOUGH = 1.1

#: Number of runs in an octave of step sizes. ``MOST_RUNS`` is the maximum. ``LEAST_IN_TILES`` is the minimum for short
#: runs of one unknown, which fill a tile of lanes. ``LEAST_RUNS`` is the minimum for long runs or several unknowns.
MOST_RUNS, LEAST_IN_TILES, LEAST_RUNS = 128, TILE, 4

#: Caps on the sum of steps × unknowns over the runs of an octave: True for one unknown, False for several. The minimum
#: number of runs is made in any case.
WORK = {True: 1_500_000, False: 4_000_000}

#: Runs in the octave below a recommended step, where errors are largest. ``CONFIRMED`` is their maximum number. The
#: dicts have a value for one unknown (True) and for several (False): the cap on the sum of steps × unknowns, and the
#: minimum number of runs. The minimum is zero if the recommended step is at most half of the finest step, because
#: otherwise a search might not end.
CONFIRMED, WORK_OF_CONFIRMED, LEAST_CONFIRMED = 500, {True: 3_000_000, False: 4_000_000}, {True: 0, False: 8}

#: Number of steps above which a run of one unknown is made alone. The second number holds if no run of a search has
#: more than ``FINEST_OF_RUN`` steps: compiling the program of a single run then takes as long as it saves.
LONG, LONG_OF_SHORT = 30_000, 120_000


def spacing(problem: Problem, duration: float) -> float | None:
    """Time in s between the samples of a record in the load; None without a record, or with unevenly spaced samples."""
    times = np.asarray(getattr(problem.load, "kinks", ()))
    gaps = np.diff(times[times < duration])
    return float(gaps.mean()) if len(gaps) and np.ptp(gaps) < 1e-6 * gaps.mean() else None


def finest_step(duration: float, slowest: float, highest: float, unknowns: int) -> float:
    """Finest step of a search, from the slowest period and the highest frequency of small motions."""
    highest_steps = min(highest * duration / FINEST_OF_HIGHEST, STEPS_OF_HIGHEST, WORK_OF_HIGHEST / unknowns)
    steps = max(duration * FINEST / slowest, FINEST_OF_RUN / unknowns, highest_steps)
    return duration / min(MOST_STEPS, steps)


def round_step(largest: float, spacing: float | None) -> float:
    """The largest round step up to ``largest``: with two digits, or an integer multiple or fraction of ``spacing``."""
    if spacing is None:
        return round_down(largest)
    largest *= 1 + 1e-9
    return math.floor(largest / spacing) * spacing if largest >= spacing else spacing / math.ceil(spacing / largest)


class StepSearch(Search):
    """Runs with equal steps. A run ends with the last step that fits into the duration.

    Parameters
    ----------
    scheme, cases, duration, with_energy, end
        As for :class:`study.assessment.search.Search`.
    coarsest, finest
        Largest and smallest step in s.
    """

    size, confirming = "dt", TWENTIETH

    def __init__(
        self,
        scheme: Scheme,
        cases: dict[float, Case],
        duration: float,
        coarsest: float,
        finest: float,
        with_energy: bool,
        end: float = math.inf,
    ):
        super().__init__(scheme, cases, duration, with_energy, end)
        self.coarsest, self.finest = coarsest, finest
        self._long = LONG if duration / finest > 1.01 * FINEST_OF_RUN else LONG_OF_SHORT
        self._unknowns, self._spacing = np.size(cases[1.0].problem.u0), spacing(cases[1.0].problem, duration)

    def _sweep(self, case: Case, sizes: np.ndarray) -> tuple[xr.Dataset, np.ndarray, np.ndarray]:
        steps = np.maximum(np.floor(self.duration / sizes * (1 + 1e-9)), 1).astype(int)
        ds = sweep(case.problem, self.scheme, dt=sizes, steps=steps, observe=case.observe)
        return ds, steps, np.atleast_1d(np.minimum(steps * sizes, self.duration))

    def _round(self, largest: float) -> float:
        return round_step(largest, self._spacing)

    def run(self, dt: np.ndarray, start: float = 1.0) -> None:
        """Make runs with the step sizes ``dt``, with start and load multiplied by ``start``.

        The runs with the finest steps are left out if the time does not suffice, so that no gap is left above a step.
        """
        dt = np.sort(dt)[::-1]  # sorted, so that the lanes of a tile end together
        alone = (self.duration / dt > self._long) & (self._unknowns == 1)
        at_once, together = TILE * cores() if self._unknowns == 1 else FEW, dt[~alone]
        parts = [*(together[i : i + at_once] for i in range(0, len(together), at_once)), *dt[alone]]
        for part in parts:
            if self.late and len(self.runs):
                return
            self._add(start, part)

    def _stretch(self, bottom: float, top: float) -> None:
        """Make runs at random steps from ``bottom`` to ``top``.

        The number of runs follows from ``WORK``, within the minimum and the maximum for an octave.
        """
        steps, alone = self.duration / bottom, self._unknowns > 1 or self.duration / bottom > self._long
        least = LEAST_RUNS if alone else LEAST_IN_TILES
        count = int(np.clip(WORK[self._unknowns == 1] / steps / self._unknowns, least, MOST_RUNS)) // least * least
        self.run(self._drawn(bottom, top, count))

    def _unconfirmed(self, steps: Iterable[float]) -> np.ndarray:
        """Random steps that are still missing to confirm each given step; they lie in the octave below it."""
        tried = self._own().dt.to_numpy()
        drawn = tried
        for step in sorted(steps, reverse=True):
            work = 2 * self.duration / step * self._unknowns
            single = self._unknowns == 1
            least = LEAST_CONFIRMED[single] if step > self.finest / 2 else 0
            required = int(np.clip(WORK_OF_CONFIRMED[single] / work, least, CONFIRMED))
            missing = required - int(((drawn >= step / 2) & (drawn <= step)).sum())
            drawn = np.append(drawn, self._drawn(step / 2, step, max(missing, 0)))
        return drawn[len(tried) :]

    def search(self, limits: Sequence[Limit], report: Callable[[float], None] = lambda top: None) -> None:
        """Make runs down to a twentieth of the smallest step that a limit needs, then runs that confirm the steps.

        A limit is a quantity with an allowed error. It needs the largest step that keeps this error, which is rounded
        down. The rounded step is run with every multiple of start and load. Random steps in the octave below it are run
        too.
        """
        top = self.coarsest
        while not self.late:
            largest = [self.needed(*limit).largest for limit in limits] if len(self.runs) else [0.0]
            least = TWENTIETH * min(largest, default=np.inf)
            if top > ENOUGH * max(least, self.finest):
                report(top)
                bottom = max(top / 2, least, self.finest)
                self._stretch(bottom, top)
                top = bottom
                continue
            steps = {self._round(step) for step in largest if step}
            new, missing = np.array(sorted(steps - {*self._own().dt})), self._unconfirmed(steps)
            if not len(new) + len(missing):
                return
            report(max(steps))
            self.run(np.append(new, missing))
            for start in self._cases:
                if start != 1.0 and len(new):
                    self.run(new, start)

    def _known(self, size: float) -> bool:
        """Whether the runs with a step from all starts, and all runs that confirm it, have been made."""
        finer = self._own().dt.min() <= TWENTIETH * size and not len(self._unconfirmed([size]))
        return finer and super()._known(size)
