"""Recommended explicit and implicit schemes, with their steps, for each kind of problem, quantity and error."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import ASSESSED
from paper.numbers.spectrum import largest_steps, share_at_the_spacing, share_between
from paper.picks import (
    AT_MOST,
    COARSEST,
    ERRORS,
    LEVEL,
    Pick,
    cell,
    first_of,
    needs_of_spring,
    picks_of,
    sentence,
    tied,
)
from paper.products import table
from paper.published import PROBLEMS
from paper.requirements import OF_THE_ASSESSMENTS, contained
from study.words import span

#: Quantities of a spring whose error is bounded.
QUANTITIES = ("displacement", "velocity", "acceleration", "phase", "energy")
#: Smooth spring in the dataset of kinks. Its rows come from the assessments instead.
SPRING = "hardening"
#: Classes of schemes, by their flag ``explicit``.
CLASSES = {"explicit": 1, "implicit": 0}

#: Keys of the configuration with the schemes of all rows.
SCHEMES_OF_THE_ROWS = (
    *(f"assess.{name}.schemes" for name in PROBLEMS),
    *(f"{name}.schemes" for name in ("kinks", "spectrum", "structures")),
)


def column(error: float) -> str:
    """The name of the column of an allowed error."""
    return f"{100 * error:g} %"


def _by_class(runs: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Name of each class of schemes, with the part of a dataset that has the schemes of the class."""
    for name, flag in CLASSES.items():
        yield name, runs.isel(scheme=np.flatnonzero(runs.explicit.values == flag))


def _fewest(needs: pd.DataFrame, kind: str) -> pd.DataFrame:
    """The rows of the schemes of a class that tie for the fewest force evaluations, the smallest error first."""
    needs = needs[needs.kind == kind]
    return needs.iloc[tied(needs.forces_per_time.to_numpy(), needs.made.to_numpy())]


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
    """A remark if the first chosen scheme needs more steps than chosen to keep the energy at all amplitudes."""
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
            needs = {error: needs_of_spring(spring, error, quantity) for error in ERRORS}
            for c, kind in enumerate(CLASSES):
                choices = {error: _fewest(needed, kind) for error, needed in needs.items()}
                yield {
                    "Problem": sentence(spring.attrs["problem"]) if k == c == 0 else "",
                    "Right in": quantity if c == 0 else "",
                    "Scheme": kind,
                    **{column(error): _of_spring(spring, one, limits) for error, one in choices.items()},
                    "Beware of": _of_amplitudes(robustness, problem, choices[ERRORS[0]]),
                }


def _lost_order(kinks: xr.Dataset) -> str:
    """A remark on schemes of second or higher order whose observed order rounds to at most one."""
    first = (kinks.order >= 2) & (kinks.observed_order < 1.5)
    titles = kinks.scheme_title.values[first.values].tolist()
    return f"only first order: {first_of(titles)}" if titles else ""


def _remembering(kinks: xr.Dataset, limits: Mapping[str, float]) -> Iterator[dict]:
    for problem in kinks.problem.values:
        if problem == SPRING:
            continue
        for c, (name, one) in enumerate(_by_class(kinks.sel(problem=problem))):
            yield {
                "Problem": sentence(one.problem_title.item()) if c == 0 else "",
                "Right in": "displacement" if c == 0 else "",
                "Scheme": name,
                **{column(error): picks_of(one, one.error, error, limits) for error in ERRORS},
                "Beware of": _lost_order(one),
            }


def _losing(one: xr.Dataset) -> str:
    """A remark on the schemes that fail or lose the balance of energies at any step; empty if there are none.

    If more than half of the schemes do so, but not all, the remark is on the schemes that keep the balance.
    """
    loses = ((one.status != 0) | ~(one.max_energy_imbalance <= LEVEL)).any("steps_per_period").values
    if not loses.any():
        return ""
    if loses.all():
        return "lost by all"
    if loses.sum() <= len(loses) / 2:
        return f"lost by {first_of(one.scheme_title.values[loses].tolist())}"
    keeping = one.isel(scheme=np.flatnonzero(~loses))
    best_first = keeping.sortby(keeping.max_energy_imbalance.max("steps_per_period"))
    return f"kept only by {first_of(best_first.scheme_title.values.tolist())}"


def _set_by_sawtooth(runs: xr.Dataset, error: xr.DataArray, limits: Mapping[str, float]) -> str:
    """A remark if the cells of the row would differ without the bounds on velocity and acceleration."""
    without = runs.drop_vars(["velocity_error", "acceleration_error"], errors="ignore")
    differs = any(cell(picks_of(runs, error, e, limits)) != cell(picks_of(without, error, e, limits)) for e in ERRORS)
    return "velocity or acceleration sets the step" if differs else ""


def _off_in_acceleration(choices: Iterable[list[Pick]]) -> str:
    """A remark on the errors of acceleration that exceed ``LEVEL`` at the steps of the schemes named in the cells."""
    off = [picks[0].acceleration_error for picks in choices if picks and picks[0].acceleration_error > LEVEL]
    return f"acceleration wrong by {span(100 * np.array(off), '.0f')} %" if off else ""


def _structures(structures: xr.Dataset, limits: Mapping[str, float]) -> Iterator[dict]:
    for problem in structures.problem.values:
        for k, what in enumerate(("displacement", "energy")):
            for c, (name, one) in enumerate(_by_class(structures.sel(problem=problem))):
                size = one.displacement_error if what == "displacement" else one.max_energy_imbalance
                choices = {error: picks_of(one, size, error, limits) for error in ERRORS}
                warnings = [
                    _losing(one) if k == 0 else "",
                    _set_by_sawtooth(one, size, limits),
                    _off_in_acceleration(choices.values()),
                ]
                yield {
                    "Problem": sentence(one.problem_title.item()) if k == c == 0 else "",
                    "Right in": what if c == 0 else "",
                    "Scheme": name,
                    **{column(error): picks for error, picks in choices.items()},
                    "Beware of": "; ".join(filter(None, warnings)),
                }


def _under_records(spectrum: xr.Dataset, error: float, limits: Mapping[str, float]) -> list[Pick]:
    """The schemes, each with its step, that tie for the fewest evaluations per second at an error of the peak drift."""
    runs = ["record", "period", "reduction"]
    largest = largest_steps(spectrum, error)
    found = spectrum.isel(scheme=np.flatnonzero(largest.notnull()))
    largest = largest.sel(scheme=found.scheme)
    made = found.sel(step_size=largest)
    forces = made.force_evaluations_per_step.mean(runs) / largest
    omega = 2 * np.pi / spectrum.period.min().item()
    picks = []
    for k in tied(forces.values, made.error.max(runs).values):
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
            **{column(error): _under_records(dividing, error, limits) for error in ERRORS},
            "Beware of": "other steps" if off else "",
        }


def decided(
    springs: list[xr.Dataset],
    robustness: xr.Dataset,
    kinks: xr.Dataset,
    spectral: xr.Dataset,
    spectrum: xr.Dataset,
    structures: xr.Dataset,
) -> pd.DataFrame:
    """The table of decisions with a list of :class:`paper.picks.Pick` in place of each cell of a scheme."""
    limits = spectral.stability_limit.sel(damping_ratio=0.0).to_series().to_dict()
    return pd.DataFrame(
        [
            *_springs(springs, robustness, limits),
            *_structures(structures, limits),
            *_remembering(kinks, limits),
            *_record(spectrum, limits),
        ]
    )


@table(
    "Recommended schemes and steps",
    springs=ASSESSED,
    robustness="stability/robustness",
    kinks="kinks",
    spectral="spectral",
    spectrum="spectrum",
    structures="structures",
    requires={
        **OF_THE_ASSESSMENTS,
        "": contained(*SCHEMES_OF_THE_ROWS, within="spectral.schemes"),
        "spectral.damping_ratios": [0.0],
    },
)
def tabulate(**datasets) -> pd.DataFrame:
    """One row per kind of problem, quantity and class of schemes; a dash where no scheme keeps the error.

    The classes are explicit and implicit. A cell names the scheme of its class with the fewest evaluations of the
    force. Numbers of evaluations within a tenth tie, and the smallest error then decides. On structures and with kinks,
    however, tied schemes whose step is the finest that was tried come last. Energy and phase of a spring must also be
    within ``LEVEL``. A cell contains the steps per period and, in brackets, the forces per period and Δt·ω with the
    highest ω of the motion, followed by the stability limit of linear theory if there is one. Under records, the step
    in ms replaces the steps per period, and the forces per second replace the forces per period.
    """
    table = decided(**datasets)
    columns = [column(error) for error in ERRORS]
    return table.assign(**table[columns].map(cell))
