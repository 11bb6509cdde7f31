"""The four doors of the first page, each a link with a small figure from the data."""

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

import study
from docs.drawing import ACCENT, INK, panel, svg
from paper.figures.outcome_map import outcome_map
from paper.products import reader

#: Schemes of the figures, with the colours of their curves.
SCHEMES = {"central_difference": ACCENT, "average_acceleration": INK}


def _frame(axes: Axes, spectrum: xr.Dataset) -> None:
    steps = 1e3 * spectrum.largest_step_size.sel(condition="practice").min(["record", "reduction"], skipna=False)
    for name, colour in SCHEMES.items():
        axes.plot(steps.period, steps.sel(scheme=name), "o-", color=colour, label=study.schemes[name].title)
    allowed = f"{100 * spectrum.allowed_error.item():g} %"
    axes.set(xlabel="period, s", ylabel=f"step for {allowed} of peak drift, ms", ylim=(0, None))
    axes.legend(frameon=False)


def _program(axes: Axes, runs: xr.Dataset) -> None:
    runs = runs.sel(quantity="displacement", periods=runs.decided)
    for name, colour in SCHEMES.items():
        run = runs.sel(scheme=name).sortby("steps_per_period")
        axes.plot(run.steps_per_period, run.error, ".", ms=3, color=colour, label=study.schemes[name].title)
    axes.axhline(0.01, color=INK, lw=1, ls="--")
    axes.set(xlabel="steps in a period", ylabel="error of displacement", ylim=(1e-5, 1))
    axes.legend(frameon=False)


def _order(axes: Axes, accuracy: xr.Dataset) -> None:
    errors = accuracy.displacement_error.sel(problem="hardening", periods=1)
    for name, colour in {"average_acceleration": INK, "rk4": ACCENT}.items():
        scheme = study.schemes[name]
        label = f"{scheme.title}: order {scheme.order}"
        axes.plot(errors.steps_per_period, errors.sel(scheme=name), "o-", ms=3, color=colour, label=label)
    axes.set(xlabel="steps in a period", ylabel="error of displacement")
    axes.legend(frameon=False)


def _map(axes: Axes, atlas: xr.Dataset) -> None:
    outcome_map(axes, atlas.sel(scheme="average_acceleration", problem="softening"), float("inf"))
    axes.grid(visible=False)
    axes.set(xlabel="step size over period", ylabel="initial displacement, relative")
    axes.set_xticks([0.01, 0.05, 0.2, 1], ["1/100", "1/20", "1/5", "1"])
    axes.minorticks_off()


#: Address, title, description of the figure, dataset, logarithmic axes, and function that draws each door.
DOORS = (
    (
        "answers.html",
        "A frame under records: scheme and step, by model, error and program",
        "Largest step for the peak drift under records against the period",
        "spectrum",
        "",
        _frame,
    ),
    (
        "how_to/program.html",
        "A model in OpenSees, Abaqus, C: assessed by its runs",
        "Errors of runs of a yielding oscillator against the number of steps",
        "runs/yielding",
        "xy",
        _program,
    ),
    (
        "how_to/conformance.html",
        "You write an integrator: the conformance kit",
        "Errors that fall with the orders two and four",
        "accuracy",
        "xy",
        _order,
    ),
    (
        "gallery/index.html",
        "The study: questions and figures",
        "How runs of average acceleration on a softening spring end, over step size and amplitude",
        "stability/atlas",
        "xy",
        _map,
    ),
)


def doors(results: Path) -> str:
    """The doors as an element of a page."""
    read, links = reader(results), []
    for address, title, description, dataset, logarithmic, draw in DOORS:
        figure, axes = panel(logarithmic)
        draw(axes, read(dataset))
        links.append(f'<a href="{address}"><div class="panel">{svg(figure, description)}</div>\n{title}</a>')
    return '<div class="doors">\n' + "\n".join(links) + "\n</div>\n"
