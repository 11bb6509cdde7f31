"""Results of a scheme in the datasets: orders, energy errors, maps, work and precision."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from docs.drawing import ACCENT, OTHER, figure_of, lines_legend, map_legend, panel, svg
from docs.scheme_curves import COMPARED
from docs.text import table
from docs.theory import ROUND_OFF, Theory
from paper.figures.outcome_map import outcome_map
from paper.figures.style import OUTCOME_STYLES
from paper.measures.orders import PERIODS, order_at_finest
from paper.measures.outcomes import fewest_steps, most_steps
from paper.published import printed_cpu_times, printed_energy_errors
from study.words import listed, number, percent

if TYPE_CHECKING:
    from docs.scheme_page import Subject

#: Measures of error in the datasets, and their headings in a table.
_MEASURES = {
    "displacement_error": "displacement",
    "period_elongation": "period",
    "amplitude_decay": "amplitude",
    "max_energy_error": "energy",
}
#: Descriptions of failures.
_FAILURES = {"no_solution_found": "no balance of forces is found", "unbounded": "the motion grows without bound"}
#: Allowed errors of the energy at all amplitudes.
LEVELS = (0.01, 0.05, 0.1)
#: Length, in periods, of the runs whose error is shown against the number of forces.
_LONG = 100
_LIMIT = " Dashed: linear limit of stability at the stiffest place of the motion."
#: Smallest error drawn; below it round-off dominates.
_FLOOR = 1e-14


def _part_of(subject: "Subject", dataset: xr.Dataset) -> xr.Dataset | None:
    """The part of a dataset for one scheme; None if the dataset lacks the scheme."""
    return dataset.sel(scheme=subject.name) if subject.name in dataset.scheme.values else None


def _titles(runs: xr.Dataset) -> dict[str, str]:
    return dict(zip(runs.problem.values.tolist(), map(str, runs.problem_title.values), strict=True))


def orders(subject: "Subject", data: Mapping[str, Any]) -> str:
    """Tables of observed orders: on springs, with kinks, and in real circumstances; empty if no order was measured."""
    parts = []
    runs = _part_of(subject, data["accuracy"])
    if runs is not None:
        rows = []
        for problem, title in _titles(runs).items():
            observed = (
                order_at_finest(runs[measure].sel(problem=problem, periods=PERIODS[measure])) for measure in _MEASURES
            )
            rows.append([title, *(number(order, 2) for order in observed)])
        parts.append("Observed order in Δt of the errors, fitted to the finest steps above round-off:")
        parts.append(table(["problem", *_MEASURES.values()], rows))
        parts.append("A dash means that the slope is not steady or the errors are round-off.")
    kinked = _part_of(subject, data["kinks"])
    if kinked is not None:
        observed = kinked.observed_order
        rows = [
            [
                title,
                number(observed.sel(problem=name).item(), 2),
                number(kinked.dividing_order.sel(problem=name).item(), 2),
            ]
            for name, title in _titles(kinked).items()
        ]
        parts.append("Order of the displacement with yielding, memory or contact, and under a record:")
        parts.append(table(["problem", "order", "with steps that divide the spacing of a record"], rows))
    real = _part_of(subject, data["order_under_reality"])
    if real is not None:
        observed = real.observed_order.transpose("circumstance", "quantity")
        rows = [
            [title, *(number(order, 2) for order in row)]
            for title, row in zip(real.circumstance_title.values, observed.values, strict=True)
        ]
        parts.append("Order of the motion in the circumstances of real problems ({doc}`/gallery/order`):")
        parts.append(table(["circumstance", *real.quantity.values], rows))
        parts.append("A dash means that the circumstance does not apply, that runs fail, or that errors are round-off.")
    return "\n\n".join(parts)


def energy(subject: "Subject", data: Mapping[str, Any]) -> str:
    """Largest energy errors printed in 1996 and found here, and computing times of 1996; empty without runs."""
    runs = _part_of(subject, data["energy_error"])
    if runs is None:
        return ""
    runs = 100 * runs.max_energy_error.sel(period_used="printed")
    printed = printed_energy_errors()
    known = subject.name in printed.scheme.values
    titles = _titles(data["energy_error"])
    head = ["steps per period"]
    for title in titles.values():
        head += [f"{title}, 1996", "here"] if known else [title]
    rows = []
    for steps in runs.steps_per_period.values.tolist():
        row = [str(steps)]
        for problem in titles:
            if known:
                value = printed.sel(problem=problem, steps_per_period=steps, scheme=subject.name).item()
                row.append(f"{value:.1f}")  # one decimal, as in the paper
            row.append(number(runs.sel(problem=problem, steps_per_period=steps).item()))
        rows.append(row)
    words = "Largest energy error in percent over 100 periods, which are those that the paper prints, rounded:"
    errors = f"{words}\n\n{table(head, rows, numbers_from=0)}"
    return f"{errors}\n\n{_times_of_1996(subject.name, titles)}" if known else errors


def _times_of_1996(scheme: str, titles: dict[str, str]) -> str:
    """A sentence with the computing times printed in 1996, and their ratios to the times of average acceleration."""
    seconds = printed_cpu_times().sel(problem=list(titles))
    ratio = seconds / seconds.sel(scheme="average_acceleration")
    times = []
    for name, title in titles.items():
        ratio_of = f" ({number(ratio.sel(problem=name, scheme=scheme).item())} times average acceleration)"
        note = ratio_of if scheme != "average_acceleration" else ""
        times.append(f"{number(seconds.sel(problem=name, scheme=scheme).item())} s on the {title}{note}")
    return f"In 1996, 100,000 steps took {listed(times)} on a Pentium of 90 MHz."


def maps(subject: "Subject", data: Mapping[str, Any]) -> str:
    """Maps and shares of outcomes over step size and amplitude, and steps that keep the energy at all amplitudes.

    Empty if the dataset of the maps lacks the scheme.
    """
    atlas = data["stability/atlas"]
    runs = _part_of(subject, atlas)
    if runs is None:
        return ""
    names = atlas.outcome.flag_meanings.split()
    panels, rows = [], []
    for problem, title in _titles(runs).items():
        map_ = runs.sel(problem=problem)
        figure, axes = panel("xy")
        outcome_map(axes, map_, subject.theory.limit)
        axes.grid(visible=False)
        axes.set_title(title)
        axes.set(xlabel="step size over period", ylabel="initial displacement, relative")
        axes.set_xticks([0.01, 0.05, 0.2, 1], ["1/100", "1/20", "1/5", "1"])
        axes.minorticks_off()
        panels.append(svg(figure, f"How runs of {subject.scheme.title} on the {title} end, by step size and amplitude"))
        share = np.bincount(map_.outcome.values.ravel(), minlength=len(names)) / map_.outcome.size
        rows.append([title, *(_share(part) for part in share)])
    periods = int(atlas.periods)
    caption = f"How runs of {periods} periods end over the step size and the amplitude relative to 1996." + (
        _LIMIT if np.isfinite(subject.theory.limit) else ""
    )
    head = ["problem", *(OUTCOME_STYLES[name][0] for name in names)]
    parts = [figure_of([*panels, map_legend()], caption), "Share of these runs by outcome:", table(head, rows)]
    parts.append(_failures(subject, data))
    fewest = [fewest_steps(runs, level) for level in LEVELS]
    finer = most_steps(atlas)
    rows = [
        [title, *(f"{steps:.0f}" if (steps := counts.sel(problem=name).item()) > 0 else finer for counts in fewest)]
        for name, title in _titles(runs).items()
    ]
    parts.append(f"Steps per period that keep the energy within some percent over {periods} periods at all amplitudes:")
    parts.append(table(["problem", *(f"{100 * level:g} %" for level in LEVELS)], rows))
    return "\n\n".join(parts)


def _share(part: float) -> str:
    return "–" if part == 0 else "< 1 %" if part < 0.01 else f"{100 * part:.0f} %"


def _failures(subject: "Subject", data: Mapping[str, Any]) -> str:
    """A sentence on the smallest step size at which runs fail at the amplitudes of 1996; empty without runs."""
    runs = _part_of(subject, data["large_steps"])
    if runs is None:
        return ""
    names = runs.status.flag_meanings.split()
    failures = []
    for problem, title in _titles(runs).items():
        status = runs.status.sel(problem=problem).values
        if status.any():
            first = int(np.argmax(status != 0))
            steps, how = number(1 / runs.step_size_over_period.values[first]), _FAILURES[names[int(status[first])]]
            failures.append(f"on the {title} at {steps} steps per printed period ({how})")
    if not failures:
        return (
            "At the amplitudes of 1996 every run finds a solution at each step, down to one step a period. The motion "
            "may be wrong all the same."
        )
    return f"As the steps grow, runs at the amplitudes of 1996 first fail {listed(failures)}."


def work(subject: "Subject", data: Mapping[str, Any]) -> str:
    """Curves of error against number of forces for all schemes, and the cost of a step; empty without runs."""
    all_runs = data["work_precision"]
    runs = _part_of(subject, all_runs)
    if runs is None:
        return ""
    others = all_runs.scheme_title.drop_sel(scheme=subject.name).to_series().to_dict()
    compared = {name: line for name, line in COMPARED.items() if name in others}
    panels, rows = [], []
    for problem, title in _titles(runs).items():
        figure, axes = panel("xy")
        for name in [*others, subject.name]:
            run = all_runs.sel(problem=problem, scheme=name, periods=_LONG)
            error = abs(run.displacement_error)
            known = error.where((run.flagged.sel(measure="displacement_error") == 0) & (error > _FLOOR))
            if name == subject.name:
                axes.plot(run.force_evaluations, known, "-", color=ACCENT, lw=2.0, marker="o", ms=4)
            else:
                width = 1.4 if name in compared else 0.5
                axes.plot(run.force_evaluations, known, compared.get(name, "-"), color=OTHER, lw=width)
        axes.set(xlabel=f"forces in {_LONG} periods", ylabel="largest error, relative")
        axes.set_ylim(top=3)
        axes.set_title(title)
        panels.append(svg(figure, f"Error of {subject.scheme.title} on the {title} over the forces evaluated"))
        time = 1e9 * runs.median_seconds_per_step.sel(problem=problem)
        forces = runs.force_evaluations_per_step.sel(problem=problem)
        rows.append([title, _range(time), _range(forces)])
    caption = f"Largest error of the displacement over {_LONG} periods against the forces evaluated."
    lines = [("-", subject.scheme.title), *((line, others[name]) for name, line in compared.items())]
    panels.append(lines_legend([*lines, ("-", "the other schemes of the dataset")]))
    measured = table(["problem", "time per step, ns", "forces per step"], rows)
    return f"{figure_of(panels, caption)}\n\n{measured}\n\nTimes depend on the machine; the dataset holds every repeat."


def _range(values: xr.DataArray) -> str:
    low, high = (number(float(value), 2) for value in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def by_the_rule_of_thumb(theory: Theory) -> str:
    """Elongation of the period and loss of amplitude in linear theory at 20 steps per period, in a phrase."""
    elongation, decay = theory.elongation_of_rule, theory.decay_of_rule
    if np.isnan(elongation):
        return "nothing oscillates"
    longer = f"{percent(abs(elongation))} too {'long' if elongation > 0 else 'short'}"
    if abs(elongation) < ROUND_OFF:
        longer = "right"
    if abs(decay) < ROUND_OFF:
        return f"the period is {longer}, and the amplitude stays"
    changes = "falls" if decay > 0 else "grows"
    return f"the period is {longer}, and the amplitude {changes} by {percent(abs(decay))} per period"
