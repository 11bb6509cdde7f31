"""Which explicit and which implicit scheme, and which step, by kind of problem, quantity and error."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import ASSESSED, steps_of_period
from paper.numbers.spectrum import largest_steps, share_at_the_spacing, share_between
from paper.products import table
from paper.published import PROBLEMS
from paper.requirements import OF_THE_ASSESSMENTS, contained
from study.analysis.recommendation import recommend
from study.words import number

#: Errors of the columns.
ERRORS = (0.1, 0.01, 0.001)
#: Quantities of a spring whose error is bounded.
QUANTITIES = ("displacement", "velocity", "phase", "energy")
#: Spring that the dataset of kinks holds for comparison.
SPRING = "hardening"
#: Largest relative error of an energy.
LEVEL = 0.1
#: Verdict of a search that ends at the coarsest step.
COARSEST = "already the coarsest step"
#: Largest error of a velocity over its largest size: an unresolved oscillation that is left out costs half of the size,
#: and a sawtooth all of it.
VELOCITY = 0.75
#: Numbers of evaluations of the force up to this multiple of the fewest tie.
TIED = 1.1
#: Classes of schemes, by their flag ``explicit``.
CLASSES = {"explicit": 1, "implicit": 0}

#: Schemes of all rows.
SCHEMES_OF_THE_ROWS = (
    *(f"assess.{name}.schemes" for name in PROBLEMS),
    *(f"{name}.schemes" for name in ("kinks", "spectrum", "structures")),
)

NO_BREAK = "\u00a0"
#: Mark of the coarsest step that was tried.
AT_MOST = f"≤{NO_BREAK}"


class Pick(NamedTuple):
    """A scheme with its step, in the form of a cell.

    ``step`` and ``forces`` are texts: the step or the number of steps, and the evaluations of the force in a time.
    ``omega_step`` is Δt·ω with the highest ω of the motion, and ``limit`` its limit in linear theory.
    """

    title: str
    step: str
    forces: str
    omega_step: float
    limit: float


def _cell(picks: list[Pick]) -> str:
    """The first of the schemes that tie, and ``…`` if there are others; a dash of none."""
    if not picks:
        return "–"
    one = picks[0]
    below = f" < {one.limit:.3g}" if np.isfinite(one.limit) else ""
    work, condition = (part.replace(" ", NO_BREAK) for part in (one.forces, f"ωΔt {number(one.omega_step, 2)}{below}"))
    return f"{one.title}: {one.step} ({work}, {condition})" + ("; …" if len(picks) > 1 else "")


def _first(titles: list[str]) -> str:
    """The first of some schemes, and ``…`` if there are others."""
    return titles[0] + ("; …" if len(titles) > 1 else "")


def _tied(forces: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Places of the fewest forces and of those that tie with them, ordered by their errors; NaN does not count."""
    tied = np.flatnonzero(forces <= TIED * np.fmin.reduce(forces, initial=np.inf))
    return tied[np.argsort(error[tied], kind="stable")]


def sentence(title: str) -> str:
    """A title as the beginning of a sentence."""
    return title[0].upper() + title[1:]


def _column(error: float) -> str:
    return f"{100 * error:g} %"


def _by_class(runs: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """The explicit and the implicit schemes of a dataset."""
    for name, flag in CLASSES.items():
        yield name, runs.isel(scheme=np.flatnonzero(runs.explicit.values == flag))


def needs_of_spring(spring: xr.Dataset, error: float, quantity: str) -> pd.DataFrame:
    """Rows of ``study.recommend``, each for the finest step that a scheme needs for a quantity, energy and phase.

    Schemes that exceed one of the errors at every step have no row. ``steps`` and ``forces`` are numbers of steps and
    evaluations in a period, and ``made`` is the error of the quantity.
    """
    wanted = {(error, quantity), (LEVEL, "energy"), (LEVEL, "phase")}
    needs = pd.concat([recommend(spring, error=limit, quantity=what) for limit, what in wanted])
    needs = needs.sort_values("step_size")
    kept = needs[needs.step_size.groupby(level="scheme").transform("count") == len(wanted)]
    finer = kept[~kept.index.duplicated()]
    made = [spring.error.sel(scheme=name, dt=dt, quantity=quantity).item() for name, dt in finer.step_size.items()]
    steps = [steps_of_period(spring, dt) for dt in finer.step_size]
    forces = [row.force_evaluations / row.number_of_steps * n for row, n in zip(finer.itertuples(), steps, strict=True)]
    return finer.assign(steps=steps, forces=forces, made=made)


def _steps_of_spring(spring: xr.Dataset, kind: str, error: float, quantity: str) -> pd.DataFrame:
    """The schemes of a class with the fewest forces."""
    needs = needs_of_spring(spring, error, quantity)
    needs = needs[needs.kind == kind]
    return needs.iloc[_tied(needs.forces_per_time.to_numpy(), needs.made.to_numpy())]


def _of_spring(spring: xr.Dataset, chosen: pd.DataFrame, limits: Mapping[str, float]) -> list[Pick]:
    titles = spring.scheme_title.to_series()
    return [
        Pick(
            titles[row.Index],
            f"{AT_MOST if row.verdict == COARSEST else ''}{row.steps:,}",
            f"{row.forces:,.0f} forces",
            row.omega_step,
            limits[row.Index],
        )
        for row in chosen.itertuples()
    ]


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


def _springs(springs: list[xr.Dataset], robustness: xr.Dataset, limits: Mapping[str, float]) -> Iterator[dict]:
    for problem, spring in zip(PROBLEMS, springs, strict=True):
        for k, quantity in enumerate(QUANTITIES):
            for c, kind in enumerate(CLASSES):
                choices = {error: _steps_of_spring(spring, kind, error, quantity) for error in ERRORS}
                yield {
                    "Problem": sentence(spring.attrs["problem"]) if k == c == 0 else "",
                    "Right in": quantity if c == 0 else "",
                    "Scheme": kind,
                    **{_column(error): _cell(_of_spring(spring, one, limits)) for error, one in choices.items()},
                    "Beware of": _of_amplitudes(robustness, problem, choices[ERRORS[0]]),
                }


def fewest_forces(runs: xr.Dataset, error: xr.DataArray, allowed: float) -> tuple[np.ndarray, np.ndarray]:
    """Fewest forces in a period with which each scheme and all its finer steps keep an error, and the step's place.

    A run does not count if its balance of energies is wrong by more than ``LEVEL``, or, if the dataset has
    these errors, its displacement by more than that, or its velocity by more than ``VELOCITY``. The number is NaN
    if no step keeps the error.
    """
    sound = runs.max_energy_imbalance <= LEVEL
    for name, level in (("displacement_error", LEVEL), ("velocity_error", VELOCITY)):
        if name in runs:
            sound &= runs[name] <= level
    dims, steps = ("scheme", "steps_per_period"), runs.steps_per_period.values
    kept = ((error <= allowed) & sound).transpose(*dims).values
    keeps = np.logical_and.accumulate(kept[:, ::-1], axis=1)[:, ::-1]
    per_step = (runs.forces_per_step + runs.forces_per_iteration * runs.iterations_per_step).transpose(*dims).values
    forces = np.where(keeps, per_step * steps, np.inf)
    best = forces.argmin(axis=1)
    return np.where(keeps.any(axis=1), forces[np.arange(len(best)), best], np.nan), best


def marked(steps: np.ndarray, place: int) -> str:
    """A number of steps; ``≤`` marks the coarsest step that was tried, and ``†`` the finest."""
    return f"{AT_MOST if place == 0 else ''}{steps[place]:,}{' †' if place == len(steps) - 1 else ''}"


def _fewest_forces(runs: xr.Dataset, error: xr.DataArray, allowed: float, limits: Mapping[str, float]) -> list[Pick]:
    """The schemes that keep an error with the fewest forces in a period, with their steps."""
    fewest, best = fewest_forces(runs, error, allowed)
    steps = runs.steps_per_period.values
    picks = []
    for k in _tied(fewest, error.transpose("scheme", "steps_per_period").values[np.arange(len(best)), best]):
        per_period = steps[best[k]]
        step, work = marked(steps, best[k]), f"{fewest[k]:,.0f} forces"
        omega_step = runs.highest_frequency.item() * runs.period.item() / per_period
        picks.append(Pick(runs.scheme_title.values[k], step, work, omega_step, limits[runs.scheme.values[k]]))
    return picks


def _lost_order(kinks: xr.Dataset) -> str:
    """The schemes of second order and more that show the first, to a whole number."""
    first = (kinks.order >= 2) & (kinks.observed_order < 1.5)
    titles = kinks.scheme_title.values[first.values].tolist()
    return f"only first order: {_first(titles)}" if titles else ""


def _remembering(kinks: xr.Dataset, limits: Mapping[str, float]) -> Iterator[dict]:
    for problem in kinks.problem.values:
        if problem == SPRING:
            continue
        for c, (name, one) in enumerate(_by_class(kinks.sel(problem=problem))):
            yield {
                "Problem": sentence(one.problem_title.item()) if c == 0 else "",
                "Right in": "displacement" if c == 0 else "",
                "Scheme": name,
                **{_column(error): _cell(_fewest_forces(one, one.error, error, limits)) for error in ERRORS},
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


def _set_by_velocity(runs: xr.Dataset, error: xr.DataArray, limits: Mapping[str, float]) -> str:
    """A remark if a coarser step would suffice without the condition on the velocity."""
    without = runs.drop_vars("velocity_error")
    differs = any(_fewest_forces(runs, error, e, limits) != _fewest_forces(without, error, e, limits) for e in ERRORS)
    return "the velocity sets the step" if differs else ""


def _structures(structures: xr.Dataset, limits: Mapping[str, float]) -> Iterator[dict]:
    for problem in structures.problem.values:
        for k, what in enumerate(("displacement", "energy")):
            for c, (name, one) in enumerate(_by_class(structures.sel(problem=problem))):
                size = one.displacement_error if what == "displacement" else one.max_energy_imbalance
                warnings = [_losing(one) if k == 0 else "", _set_by_velocity(one, size, limits)]
                yield {
                    "Problem": sentence(one.problem_title.item()) if k == c == 0 else "",
                    "Right in": what if c == 0 else "",
                    "Scheme": name,
                    **{_column(error): _cell(_fewest_forces(one, size, error, limits)) for error in ERRORS},
                    "Beware of": "; ".join(filter(None, warnings)),
                }


def _under_records(spectrum: xr.Dataset, error: float, limits: Mapping[str, float]) -> list[Pick]:
    """The schemes of a class with the fewest forces a second for the peak drift."""
    runs = ["record", "period", "reduction"]
    largest = largest_steps(spectrum, error)
    found = spectrum.isel(scheme=np.flatnonzero(largest.notnull()))
    largest = largest.sel(scheme=found.scheme)
    made = found.sel(step_size=largest)
    forces = (found.forces_per_step + found.forces_per_iteration * made.iterations_per_step.mean(runs)) / largest
    omega = 2 * np.pi / spectrum.period.min().item()
    picks = []
    for k in _tied(forces.values, made.error.max(runs).values):
        step, name = largest.values[k], found.scheme.values[k]
        per_second = f"{forces.values[k]:,.0f} forces/s"
        picks.append(Pick(found.scheme_title.values[k], f"{1e3 * step:.2g} ms", per_second, omega * step, limits[name]))
    return picks


def _record(spectrum: xr.Dataset, limits: Mapping[str, float]) -> Iterator[dict]:
    title = f"Oscillators of {spectrum.period.min():g} to {spectrum.period.max():g} s under records"
    for c, (name, one) in enumerate(_by_class(spectrum)):
        dividing = one.isel(step_size=np.flatnonzero(one.commensurate))
        off = bool((share_between(one) > share_at_the_spacing(one)).any())
        yield {
            "Problem": title if c == 0 else "",
            "Right in": "peak drift" if c == 0 else "",
            "Scheme": name,
            **{_column(error): _cell(_under_records(dividing, error, limits)) for error in ERRORS},
            "Beware of": "other steps" if off else "",
        }


@table(
    "Recommended schemes and steps",
    springs=ASSESSED,
    robustness="stability/robustness",
    requires={
        **OF_THE_ASSESSMENTS,
        "": contained(*SCHEMES_OF_THE_ROWS, within="spectral.schemes"),
        "spectral.damping_ratios": [0.0],
    },
)
def tabulate(
    springs: list[xr.Dataset],
    robustness: xr.Dataset,
    kinks: xr.Dataset,
    spectral: xr.Dataset,
    spectrum: xr.Dataset,
    structures: xr.Dataset,
) -> pd.DataFrame:
    """One row per kind of problem and quantity; a dash where no scheme keeps the error.

    Explicit and implicit schemes have a row each. A cell names the scheme of its class with the fewest evaluations of
    the force; numbers within a tenth tie, and then the smallest error decides. Energy and phase of a spring
    must be right to ``LEVEL`` too. Numbers are steps in a period, in brackets the forces in it and Δt·ω with the
    highest ω of the motion, below the stability limit of the linear theory if there is one.
    """
    limits = spectral.stability_limit.sel(damping_ratio=0.0).to_series().to_dict()
    return pd.DataFrame(
        [
            *_springs(springs, robustness, limits),
            *_structures(structures, limits),
            *_remembering(kinks, limits),
            *_record(spectrum, limits),
        ]
    )
