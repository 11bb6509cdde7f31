"""Which explicit and which implicit scheme, and which step, by kind of problem, what must be right, and error."""

from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd
import xarray as xr

from paper.asks import OF_THE_ASSESSMENTS
from paper.data import ASSESSED, steps_of_period
from paper.numbers.spectrum import share_at_the_spacing, share_between
from paper.products import table
from paper.published import PROBLEMS
from study.analysis.recommendation import recommend

#: Errors of the columns.
ERRORS = (0.1, 0.01, 0.001)
#: What must be right of a spring.
QUANTITIES = ("displacement", "velocity", "phase", "energy")
#: Spring that the dataset of kinks holds for comparison.
SPRING = "hardening"
#: Percent by which an energy may be off.
LEVEL = 10
#: How the search for a step ends at the coarsest one.
COARSEST = "already the coarsest step"
#: Percent of its largest size by which a velocity may be off: half of it is lost where an oscillation that the step
#: does not resolve is left out, and all of it where it turns into a sawtooth.
VELOCITY = 75
#: Most schemes that a cell names.
NAMED = 1
#: Classes of schemes, by their flag ``explicit``.
CLASSES = {"explicit": 1, "implicit": 0}

#: Before the coarsest step that was tried, with a no-break space.
AT_MOST = "≤\u00a0"

Choice = tuple[str, float]


def _listed(choices: Iterable[Choice], coarsest: float, finest: float) -> str:
    """Schemes with their steps; ``≤`` marks the coarsest step that was tried, and ``†`` the finest."""
    marks = {coarsest: (AT_MOST, ""), finest: ("", " †")}
    named = []
    for title, steps in choices:
        before, after = marks.get(steps, ("", ""))
        named.append(f"{title}: {before}{steps:,.0f}{after}")
    return _first(named)


def _first(named: list[str]) -> str:
    """The schemes that a cell names, of all that it could name; a dash of none."""
    return "; ".join(named[:NAMED]) + ("; …" if len(named) > NAMED else "") if named else "–"


def sentence(title: str) -> str:
    """A title as the beginning of a sentence."""
    return title[0].upper() + title[1:]


def _column(error: float) -> str:
    return f"{100 * error:g} %"


def _by_class(runs: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """The explicit and the implicit schemes of a dataset."""
    for name, flag in CLASSES.items():
        yield name, runs.isel(scheme=np.flatnonzero(runs.explicit.values == flag))


def _fastest(spring: xr.Dataset, kind: str, error: float, quantity: str) -> pd.DataFrame:
    """The fastest schemes of a class that tie, each with the finer one of its steps for a quantity and the energy."""
    wanted = (error, quantity), (LEVEL / 100, "energy")
    needs = pd.concat([recommend(spring, error=limit, quantity=what) for limit, what in wanted])
    needs = needs[needs.kind == kind].sort_values("step_size")
    kept = needs[needs.step_size.groupby(level="scheme").transform("count") == len(wanted)]
    finer = kept[~kept.index.duplicated()].sort_values("time")
    tied = finer.time - finer.time.min() <= (finer.time_spread + finer.time_spread.head(1).sum()) / 2
    steps = [steps_of_period(spring, step) for step in finer.step_size]
    titles = spring.scheme_title.sel(scheme=finer.index.tolist()).values
    marks = np.where(finer.verdict == COARSEST, AT_MOST, "")
    cells = [f"{title}: {mark}{number:,}" for title, mark, number in zip(titles, marks, steps, strict=True)]
    return finer.assign(steps=steps, cell=cells)[tied]


def _of_amplitudes(robustness: xr.Dataset, problem: str, chosen: pd.DataFrame) -> str:
    """The steps that the first scheme of a choice needs at all amplitudes of the maps, if they are more."""
    known = problem in robustness.problem.values and not chosen.empty
    if not known or chosen.index[0] not in robustness.scheme.values:
        return ""
    needed = robustness.steps_needed.sel(problem=problem, level=LEVEL, scheme=chosen.index[0])
    at_all, most = needed.isel(periods=-1).item(), robustness.most_steps.item()
    if (at_all if np.isfinite(at_all) else most) <= chosen.steps.iloc[0]:
        return ""
    return f"at all amplitudes: {f'{at_all:.0f}' if np.isfinite(at_all) else f'more than {most}'}"


def _springs(springs: list[xr.Dataset], robustness: xr.Dataset) -> Iterator[dict]:
    for problem, spring in zip(PROBLEMS, springs, strict=True):
        for k, quantity in enumerate(QUANTITIES):
            for c, kind in enumerate(CLASSES):
                choices = [_fastest(spring, kind, error, quantity) for error in ERRORS]
                yield {
                    "Problem": sentence(spring.attrs["problem"]) if k == c == 0 else "",
                    "Right in": quantity if c == 0 else "",
                    "Scheme": kind,
                    **{_column(error): _first(one.cell.tolist()) for error, one in zip(ERRORS, choices, strict=True)},
                    "Beware of": _of_amplitudes(robustness, problem, choices[0]),
                }


def _fewest_forces(runs: xr.Dataset, error: xr.DataArray, allowed: float) -> list[Choice]:
    """The schemes that keep an error with the fewest forces in a period, as all their finer steps do.

    A run does not count if its balance of energies is off by more than ``LEVEL`` percent, or, where the dataset has
    that error, its velocity by more than ``VELOCITY``. Forces that differ by less than a tenth tie; the smaller error
    is named first.
    """
    if not runs.sizes["scheme"]:
        return []
    sound = runs.max_energy_imbalance <= LEVEL
    if "velocity_error" in runs:
        sound &= 100 * runs.velocity_error <= VELOCITY
    kept = ((error <= allowed) & sound).transpose("scheme", "steps_per_period").values
    keeps = np.logical_and.accumulate(kept[:, ::-1], axis=1)[:, ::-1]
    per_step = runs.forces_per_step + runs.forces_per_iteration * runs.iterations_per_step
    forces = (per_step * runs.steps_per_period).transpose("scheme", "steps_per_period").where(keeps)
    fewest = forces.min("steps_per_period")
    tied = np.flatnonzero(fewest <= 1.1 * fewest.min())
    steps = {k: forces.isel(scheme=k).idxmin("steps_per_period").item() for k in tied}
    by_error = sorted(tied, key=lambda k: error.isel(scheme=k).sel(steps_per_period=steps[k]).item())
    return [(runs.scheme_title.values[k], steps[k]) for k in by_error]


def _lost_order(kinks: xr.Dataset) -> str:
    """The schemes of second order and more that show the first, to a whole number."""
    first = (kinks.order >= 2) & (kinks.observed_order < 1.5)
    titles = kinks.scheme_title.values[first.values].tolist()
    return f"only first order: {_first(titles)}" if titles else ""


def _remembering(kinks: xr.Dataset) -> Iterator[dict]:
    tried = kinks.steps_per_period.values[[0, -1]]
    for problem in kinks.problem.values:
        if problem == SPRING:
            continue
        for c, (name, one) in enumerate(_by_class(kinks.sel(problem=problem))):
            yield {
                "Problem": sentence(one.problem_title.item()) if c == 0 else "",
                "Right in": "displacement" if c == 0 else "",
                "Scheme": name,
                **{_column(error): _listed(_fewest_forces(one, one.error, error), *tried) for error in ERRORS},
                "Beware of": _lost_order(one),
            }


def _losing(one: xr.Dataset) -> str:
    """The schemes that lose the balance of a structure at some step, or those that keep it if they are fewer."""
    loses = ((one.status != 0) | ~(one.max_energy_imbalance <= LEVEL)).any("steps_per_period").values
    if not loses.any():
        return ""
    if loses.all():
        return "lost by all"
    if loses.sum() <= len(loses) / 2:
        return f"lost by {_first(one.scheme_title.values[loses].tolist())}"
    keeping = one.isel(scheme=np.flatnonzero(~loses))
    best_first = keeping.sortby(keeping.max_energy_imbalance.max("steps_per_period"))
    return f"kept only by {_first(best_first.scheme_title.values.tolist())}"


def _structures(structures: xr.Dataset) -> Iterator[dict]:
    tried = structures.steps_per_period.values[[0, -1]]
    for problem in structures.problem.values:
        for k, what in enumerate(("displacement", "energy")):
            for c, (name, one) in enumerate(_by_class(structures.sel(problem=problem))):
                size = one.displacement_error if what == "displacement" else one.max_energy_imbalance / 100
                yield {
                    "Problem": sentence(one.problem_title.item()) if k == c == 0 else "",
                    "Right in": what if c == 0 else "",
                    "Scheme": name,
                    **{_column(error): _listed(_fewest_forces(one, size, error), *tried) for error in ERRORS},
                    "Beware of": _losing(one) if k == 0 else "",
                }


def _largest_steps(spectrum: xr.Dataset, error: float) -> xr.DataArray:
    """Largest step of every scheme from which on every finer one keeps an error of the peak drift, NaN if none does."""
    kept = (spectrum.error <= error).all(["record", "period", "reduction"])
    kept = kept.sortby("step_size").transpose("scheme", "step_size")
    holds = kept.copy(data=np.logical_and.accumulate(kept.values, axis=1))
    return holds.step_size.where(holds).max("step_size")


def _least_forces(spectrum: xr.Dataset, error: float) -> list[Choice]:
    """The schemes of a class with the fewest forces a second for the peak drift, with their steps in ms.

    Implicit schemes count as if they took one iteration a step, which they share. Forces that differ by less than a
    tenth tie; the smaller error is named first.
    """
    largest = _largest_steps(spectrum, error)
    forces = (spectrum.forces_per_step + spectrum.forces_per_iteration) / largest
    tied = largest.scheme[(forces <= 1.1 * forces.min()).values]
    made = spectrum.error.sel(scheme=tied).max(["record", "period", "reduction"])
    by_error = sorted(tied.values, key=lambda name: made.sel(scheme=name, step_size=largest.sel(scheme=name)).item())
    return [(largest.scheme_title.sel(scheme=name).item(), 1e3 * largest.sel(scheme=name).item()) for name in by_error]


def _record(spectrum: xr.Dataset) -> Iterator[dict]:
    title = f"Oscillators of {spectrum.period.min():g} to {spectrum.period.max():g} s under records"
    for c, (name, one) in enumerate(_by_class(spectrum)):
        dividing = one.isel(step_size=np.flatnonzero(one.commensurate))
        choices = {error: _least_forces(dividing, error) for error in ERRORS}
        off = bool((share_between(one) > share_at_the_spacing(one)).any())
        yield {
            "Problem": title if c == 0 else "",
            "Right in": "peak drift" if c == 0 else "",
            "Scheme": name,
            **{_column(error): _first([f"{of}: {step:.2g} ms" for of, step in choices[error]]) for error in ERRORS},
            "Beware of": "other steps" if off else "",
        }


@table(springs=ASSESSED, robustness="stability/robustness", asks=OF_THE_ASSESSMENTS)
def tabulate(
    springs: list[xr.Dataset],
    robustness: xr.Dataset,
    kinks: xr.Dataset,
    spectrum: xr.Dataset,
    structures: xr.Dataset,
) -> pd.DataFrame:
    """One row per kind of problem and what must be right; a dash where no scheme keeps the error.

    Explicit and implicit schemes have a row each. Of the springs a cell names the fastest scheme and those that tie
    with it, among those whose energy is right to ``LEVEL`` percent too; of the others the scheme with the fewest forces
    in a period. Numbers are steps in a period.
    """
    rows = [*_springs(springs, robustness), *_structures(structures), *_remembering(kinks), *_record(spectrum)]
    return pd.DataFrame(rows)
