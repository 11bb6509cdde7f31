"""A page to look at every run of the maps: ``python -m paper.explorer OUTPUT ATLAS PORTRAITS AMPLITUDES CASE...``.

It is one file that a browser opens without a server, and holds all that it shows.
"""

import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.layouts import column, row
from bokeh.models import (
    Axis,
    CDSView,
    ColorBar,
    ColumnDataSource,
    CustomJS,
    CustomJSHover,
    Div,
    FixedTicker,
    GroupFilter,
    HoverTool,
    Legend,
    LegendItem,
    LinearColorMapper,
    LogColorMapper,
    Select,
    Span,
)
from bokeh.palettes import RdBu11, YlGnBu9, YlOrRd9, interp_palette
from bokeh.plotting import figure
from bokeh.resources import INLINE
from bokeh.settings import settings

from paper.data import load
from paper.figures.style import OUTCOMES

#: Amplitudes and step sizes of a map that the page shows, at most: a cell is then some ten pixels wide.
CELLS = 64
#: Binary digits of the numbers that the mouse shows, and of what is drawn, of the size of the exact orbit and of a
#: doubling of the energy: what a reader or a pixel resolves, so that the page packs well.
DIGITS, DIGITS_OF_ORBIT, DIGITS_OF_HEIGHT = 9, 6, 4
#: Heights of the energy that the page shows: from where a run is at rest to where it has grown.
LEAST, MOST = 0.01, 100.0
#: What to show first: the run of the paper that surprises most.
FIRST: dict[str, Any] = {"problem": "softening", "scheme": "hht_alpha", "amplitude": 2.5, "dt_over_period": 0.125}

TITLE = "Where can a time integration scheme be trusted?"
#: Light where little is lost, and about zero; and nothing at all.
REDS, BLUE_TO_RED = interp_palette(YlOrRd9[::-1], 256), interp_palette(RdBu11, 256)
CLEAR = "#0000"

_INTRODUCTION = f"""
<h1>{TITLE}</h1>
<p>Every cell of the map is one run, released from rest at the amplitude u₀ and marched with the step size Δt, which is
counted in the exact period T at that amplitude; its colour tells how the run ended. Move the mouse over the map to see
the orbit and the energy of the run beneath it; pick one outcome, or click on those in the legend to hide them.</p>
"""
_NOTE = """
<p>Shown are {cells}. Orbit and energy, and how it ended, are those of the nearest of {portraits} runs, marked by a
small square: samples about {spacing:.1f} periods apart, from light to dark along time, as long as the energy above rest
is less than a hundred times that of the start. A run is accurate while that energy stays within 1 %. The dashed line is
at T/20, and stars are the runs of the paper.</p>
"""
# shows the run that is nearest to the mouse, or to the one that was shown last
_SHOW = """
const nearest = (axis, place) => {
  const at = axis.length < 2 ? 0 : Math.round((place - axis[0]) / (axis[1] - axis[0]))
  return Math.min(Math.max(at, 0), axis.length - 1)
}
const at = cb_data.geometry ?? {x: place.data.x[0], y: place.data.y[0]}
const [i, j] = [nearest(y, at.y), nearest(x, at.x)]
const one = runs.data.name.indexOf(`${problem.value} ${scheme.value}`)
const of_run = (values, length, place) => Array.from({length}, (_, k) => values[place * length + k])
const [u, v, height] = ["u", "v", "height"].map((name) => of_run(runs.data[name][one], samples, i * x.length + j))
const p = orbits.data.problem.indexOf(problem.value)
const [orbit_u, orbit_v] = ["u", "v"].map((name) => of_run(orbits.data[name][p], points, i))
run.data = {u, v, height, t: u.map((_, sample) => sample * spacing[j]), sample: [...u.keys()]}
orbit.data = {u: orbit_u, v: orbit_v}
place.data = {x: [x[j]], y: [y[i]]}
const [u0, dt] = [orbits.data.u0[p][i], 10 ** x[j] * orbits.data.period[p][i]]
const ended = labels[runs.data.outcome[one][i * x.length + j]]
title.text = `u₀ = ${u0.toPrecision(3)}, Δt = ${dt.toPrecision(3)} = T/${(10 ** -x[j]).toPrecision(3)}: ${ended}`
"""

# what the map may be coloured by, and what of a cell is told beside the mouse
_COLOURS = {
    "outcome": "how the run ended",
    "energy_error": "largest energy error",
    "exponent": "Lyapunov exponent",
}
_TOLD = {
    "outcome": "outcome",
    "at_step": "began at step",
    "u0": "amplitude u₀",
    "dt_over_period": "step size Δt/T",
    "energy_error": "largest energy error, %",
    "iterations": "most Newton iterations",
    "exponent": "Lyapunov exponent × T",
}
_NUMBER = "return Number.isFinite(value) ? String(+value.toPrecision(Number.isInteger(value) ? 9 : 3)) : '–'"
_LABEL = "return labels[value]"
# shows what the map is coloured by, of the outcomes all or one
_PICK = """
for (const [name, parts] of Object.entries(layers)) {
  for (const part of parts) part.visible = name === colour.value
}
for (const [index, part] of outcomes.entries()) part.visible &&= ["all", String(index)].includes(outcome.value)
"""


def _rounded(values: np.ndarray) -> np.ndarray:
    """To ``DIGITS`` binary digits, in single precision."""
    mantissa, exponent = np.frexp(values)
    with np.errstate(over="ignore"):
        return np.ldexp(np.round(mantissa * 2.0**DIGITS), exponent - DIGITS).astype(np.float32)


def _on_grid(values: np.ndarray, size: np.ndarray) -> np.ndarray:
    """To whole numbers of a power of two that is small beside the size, in single precision."""
    step = 2.0 ** (np.floor(np.log2(size)) - DIGITS_OF_ORBIT)
    return (np.round(values / step) * step).astype(np.float32)


def _coarse(dataset: xr.Dataset) -> xr.Dataset:
    """A map without the cells that are too many for the page."""
    strides = {name: -(-dataset.sizes[name] // CELLS) for name in ("amplitude", "dt_over_period")}
    return dataset.isel({name: slice(None, None, stride) for name, stride in strides.items()})


def _maps(atlas: xr.Dataset) -> ColumnDataSource:
    """A row for each problem and scheme, with an image (amplitudes, step sizes) of each quantity."""
    names = [(p, s) for p in atlas.problem.values.tolist() for s in atlas.scheme.values.tolist()]
    columns: dict[str, list] = {"problem": [p for p, _ in names], "scheme": [s for _, s in names]}
    for p, s in names:
        one = atlas.sel(problem=p, scheme=s)
        images = {
            "at_step": one.at_step.where(one.at_step >= 0),
            "energy_error": one.max_energy_error,
            "iterations": one.max_newton_iterations,
            "exponent": one.lyapunov_exponent * one.period,
            "u0": one.u0.broadcast_like(one.outcome),
            "dt_over_period": one.dt_over_period.broadcast_like(one.outcome),
        }
        columns.setdefault("outcome", []).append(one.outcome.values)
        for name, image in images.items():
            # NaN is written by Bokeh's tooltips themselves, as NaN; infinity is left to a formatter
            columns.setdefault(name, []).append(_rounded(image.fillna(np.inf).transpose(*one.outcome.dims).values))
    return ColumnDataSource(columns)


def _runs(portraits: xr.Dataset, exact: xr.Dataset, outcome: xr.DataArray) -> ColumnDataSource:
    """A row for each problem and scheme, with outcomes, and samples (amplitudes, step sizes, samples) of quantities."""
    outcome = outcome.sel(amplitude=portraits.amplitude, dt_over_period=portraits.dt_over_period, method="nearest")
    columns: dict[str, list] = {"name": [], "outcome": [], "u": [], "v": [], "height": []}
    for p in portraits.problem.values.tolist():
        size = {name: abs(exact[f"orbit_{name}"].sel(problem=p)).max("point").values for name in ("u", "v")}
        for s in portraits.scheme.values.tolist():
            one = portraits.sel(problem=p, scheme=s)
            one = one.where(one.height <= MOST)
            columns["name"].append(f"{p} {s}")
            ends = outcome.sel(problem=p, scheme=s).transpose("amplitude", "dt_over_period")
            columns["outcome"].append(ends.values.astype(np.uint8))
            for name in ("u", "v"):
                columns[name].append(_on_grid(one[name].values, size[name][:, None, None]))
            doublings = np.log2(np.maximum(one.height.values, LEAST / 2)) * 2**DIGITS_OF_HEIGHT
            columns["height"].append(np.exp2(np.round(doublings) / 2**DIGITS_OF_HEIGHT).astype(np.float32))
    return ColumnDataSource(columns)


def _orbits(exact: xr.Dataset) -> ColumnDataSource:
    """A row for each problem, with the amplitudes and the exact orbits (amplitudes, points) of the samples."""
    return ColumnDataSource(
        {
            "problem": exact.problem.values.tolist(),
            "u0": list(exact.u0.values),
            "period": list(exact.period.values),
            "u": list(exact.orbit_u.values),
            "v": list(exact.orbit_v.values),
        }
    )


def _cases(atlas: xr.Dataset, cases: Sequence[xr.Dataset]) -> ColumnDataSource:
    """Where the paper's own runs lie in the maps."""
    columns: dict[str, list] = {"problem": [], "x": [], "y": [], "label": []}
    for case in cases:
        # the softening spring has a second name for its large amplitude
        problem = next(name for name in atlas.problem.values.tolist() if case.problem.startswith(name))
        of_problem, u0, dt = atlas.sel(problem=problem), case.u.isel(scheme=0, t=0).item(), case.dt.item()
        x, y = np.log10([of_problem.u0, of_problem.period]), np.log10(of_problem.amplitude)
        period = 10 ** np.interp(np.log10(u0), *x)
        columns["problem"].append(problem)
        columns["x"].append(np.log10(dt / period))
        columns["y"].append(np.interp(np.log10(u0), x[0], y))
        columns["label"].append(f"u₀ = {u0:g}, Δt = {dt:g}")
    return ColumnDataSource(columns)


def _edges(axis: xr.DataArray) -> tuple[float, float]:
    """Outer edges of the first and the last cell of an axis, as powers of ten."""
    places = np.log10(axis.values)
    half = (places[-1] - places[0]) / (len(places) - 1) / 2
    return places[0] - half, places[-1] + half


def _logarithmic(axis: Axis, labels: dict[float, str]) -> None:
    """Ticks of an axis of powers of ten, where the mouse finds cells of one width, labelled as what they are powers."""
    places = {float(np.log10(value)): label for value, label in labels.items()}
    axis.ticker = FixedTicker(ticks=list(places))
    axis.major_label_overrides = places


def _plane(atlas: xr.Dataset) -> figure:
    """The plane of step size and amplitude."""
    plane = figure(
        width=640,
        height=640,
        x_range=_edges(atlas.dt_over_period),
        y_range=_edges(atlas.amplitude),
        x_axis_label="step size Δt, of the exact period T",
        y_axis_label="amplitude u₀, of the problem's own",
        tools="box_zoom,wheel_zoom,pan,reset,save",
        active_scroll="wheel_zoom",
        title=atlas.title,
    )
    plane.grid.visible = False
    _logarithmic(plane.xaxis, {1 / n: f"T/{n}" for n in (100, 50, 20, 10, 5, 2)} | {1.0: "T"})
    _logarithmic(plane.yaxis, {y: f"{y:g}" for y in (0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100)})
    # the step that the paper takes for fine enough
    plane.add_layout(Span(location=np.log10(1 / 20), dimension="height", line_color="black", line_dash="dashed"))
    return plane


def _draw_maps(plane: figure, maps: ColumnDataSource, view: CDSView) -> tuple[dict[str, list], HoverTool]:
    """The parts of the plane that show each quantity, and what tells of the cell under the mouse."""
    (left, right), (bottom, top) = ((span.start, span.end) for span in (plane.x_range, plane.y_range))
    place: dict[str, Any] = {"x": left, "y": bottom, "dw": right - left, "dh": top - bottom, "level": "image"}

    def image(quantity, mapper, **options):
        return plane.image(quantity, color_mapper=mapper, source=maps, view=view, **place, **options)

    legend = Legend(ncols=4, click_policy="hide", label_text_font_size="11px", spacing=4)
    layers: dict[str, list] = {"outcome": [legend]}
    for index, (label, colour) in enumerate(OUTCOMES.values()):
        alone = LinearColorMapper([colour], low=index - 0.5, high=index + 0.5, low_color=CLEAR, high_color=CLEAR)
        cells = image("outcome", alone, name=f"outcome {index}")
        # an image has no sign in a legend; a square far outside has
        sign = plane.scatter([right + 10], [top], marker="square", size=12, color=colour, line_color="grey")
        legend.items.append(LegendItem(label=label, renderers=[sign, cells]))
        layers["outcome"].append(cells)
    plane.add_layout(legend, "below")
    for quantity, title, mapper in (
        ("energy_error", "largest energy error in percent", LogColorMapper(REDS, low=1e-4, high=1e2)),
        ("exponent", "Lyapunov exponent × period", LinearColorMapper(BLUE_TO_RED, low=-0.5, high=0.5)),
    ):
        mapper.high_color = "black"
        title = f"{title}; black where it is larger or the run failed"
        bar = ColorBar(color_mapper=mapper, title=title, height=12, width=540, visible=False)
        plane.add_layout(bar, "below")
        layers[quantity] = [image(quantity, mapper, visible=False), bar]

    return layers, HoverTool(
        # whatever is hidden, the mouse finds this one
        renderers=[image("outcome", LinearColorMapper([CLEAR]))],
        tooltips=[(label, f"@{name}{{custom}}") for name, label in _TOLD.items()],
        formatters={f"@{name}": CustomJSHover(code=_NUMBER) for name in _TOLD}
        | {"@outcome": CustomJSHover(args={"labels": [label for label, _ in OUTCOMES.values()]}, code=_LABEL)},
    )


def _mark_cases(plane: figure, cases: ColumnDataSource, view: CDSView) -> None:
    """A star for each of the paper's own runs."""
    plane.scatter("x", "y", source=cases, view=view, marker="star", size=16, color="white", line_color="black")
    plane.text(
        "x",
        "y",
        "label",
        source=cases,
        view=view,
        x_offset=11,
        y_offset=4,
        text_font_size="11px",
        background_fill_color="white",
        background_fill_alpha=0.7,
        padding=2,
    )


def _portrait(run: ColumnDataSource, orbit: ColumnDataSource, spacing: np.ndarray, samples: int) -> list[figure]:
    """Orbit and energy of one run, the samples of both from light to dark."""
    along_time = LinearColorMapper(YlGnBu9[-2::-1], low=0, high=samples)
    dots: dict[str, Any] = {"size": 6, "color": {"field": "sample", "transform": along_time}, "line_color": "#666666"}
    sizes: dict[str, Any] = {"width": 440, "tools": "", "toolbar_location": None}
    phase = figure(height=400, x_axis_label="displacement u", y_axis_label="velocity u̇", **sizes)
    phase.line("u", "v", source=orbit, color="grey", line_width=1.5, legend_label="exact")
    phase.scatter("u", "v", source=run, legend_label="scheme", line_width=0.4, **dots)
    phase.legend.update(orientation="horizontal", label_text_font_size="11px", padding=0, border_line_color=None)
    phase.add_layout(phase.legend[0], "above")  # inside it would hide samples
    energy = figure(
        height=250,
        x_range=(0, samples * float(spacing.max())),
        y_range=(0.7 * LEAST, 1.5 * MOST),
        y_axis_type="log",
        x_axis_label="time over period",
        y_axis_label="energy over the start's",
        **sizes,
    )
    energy.line("t", "height", source=run, color="grey", line_width=0.7)
    energy.scatter("t", "height", source=run, line_width=0.4, **dots)
    for level in (LEAST, MOST):
        energy.add_layout(Span(location=level, dimension="width", line_color="black", line_dash="dotted"))
    return [phase, energy]


def _select(dataset: xr.Dataset, name: str) -> Select:
    """A choice of what lies along a coordinate, by its titles."""
    options = list(zip(dataset[name].values.tolist(), dataset[f"{name}_title"].values.tolist(), strict=True))
    return Select(title=name, options=options, value=FIRST[name])


def explorer(atlas: xr.Dataset, portraits: xr.Dataset, amplitudes: xr.Dataset, *cases: xr.Dataset) -> Document:
    """The page.

    Parameters
    ----------
    atlas, portraits
        Maps of stability, and samples of some of their runs.
    amplitudes
        Exact orbits at the amplitudes of the maps.
    cases
        Phase portraits of the paper's own runs, which the map marks.
    """
    coarse, exact = _coarse(atlas), amplitudes.sel(amplitude=portraits.amplitude)
    problem, scheme = (_select(atlas, name) for name in ("problem", "scheme"))
    of_problem, of_scheme = (GroupFilter(column_name=one.title, group=one.value) for one in (problem, scheme))
    problem.js_link("value", of_problem, "group")
    scheme.js_link("value", of_scheme, "group")

    plane = _plane(coarse)
    layers, hover = _draw_maps(plane, _maps(coarse), CDSView(filter=of_problem & of_scheme))
    _mark_cases(plane, _cases(atlas, cases), CDSView(filter=of_problem))
    colour = Select(title="colour", options=list(_COLOURS.items()), value="outcome")
    labels = [label for label, _ in OUTCOMES.values()]
    outcome = Select(
        title="outcome", options=[("all", "all"), *((str(k), v) for k, v in enumerate(labels))], value="all"
    )
    outcomes = layers["outcome"][1:]  # behind their legend
    pick = CustomJS(args={"layers": layers, "outcomes": outcomes, "colour": colour, "outcome": outcome}, code=_PICK)
    for one in (colour, outcome):
        one.js_on_change("value", pick)

    x, y = np.log10(portraits.dt_over_period.values), np.log10(portraits.amplitude.values)
    spacing, samples = (portraits.every * portraits.dt_over_period).values, portraits.sizes["sample"]
    first = exact.sel(problem=FIRST["problem"]).sel(amplitude=FIRST["amplitude"], method="nearest")
    orbit = ColumnDataSource({"u": first.orbit_u.values, "v": first.orbit_v.values})
    run = ColumnDataSource({name: [] for name in ("u", "v", "height", "t", "sample")}, name="run")
    place = ColumnDataSource({"x": [np.log10(FIRST["dt_over_period"])], "y": [np.log10(FIRST["amplitude"])]})
    plane.scatter("x", "y", source=place, marker="square", size=9, fill_color=None, line_color="#0a7d32", line_width=2)
    phase, energy = _portrait(run, orbit, spacing, samples)
    show = CustomJS(
        args={
            **{"x": x, "y": y, "spacing": spacing, "samples": samples, "points": exact.sizes["point"]},
            **{
                "problem": problem,
                "scheme": scheme,
                "runs": _runs(portraits, exact, atlas.outcome),
                "orbits": _orbits(exact),
            },
            **{"run": run, "orbit": orbit, "place": place, "title": phase.title},
            "labels": labels,
        },
        code=_SHOW,
    )
    hover.callback = show
    plane.add_tools(hover)
    problem.js_on_change("value", show)
    scheme.js_on_change("value", show)

    note = _NOTE.format(
        cells=f"{coarse.sizes['amplitude']} of {atlas.sizes['amplitude']} amplitudes and "
        f"{coarse.sizes['dt_over_period']} of {atlas.sizes['dt_over_period']} step sizes",
        portraits=len(x) * len(y),
        spacing=spacing[0],
    )
    page = Document(title=TITLE)
    page.add_root(
        column(
            Div(text=_INTRODUCTION, width=1100),
            row(problem, scheme, outcome, colour),
            row(plane, column(phase, energy)),
            Div(text=note, width=1100),
        )
    )
    page.js_on_event("document_ready", show)
    return page


def write(page: Document, path: Path) -> None:
    """Write the page with all that it needs, the same bytes for the same data."""
    settings.compression_level = 6
    html = file_html(page, INLINE)
    # Bokeh gives the parts of a page new names every time
    names = dict.fromkeys(re.findall(r"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}", html))
    for index, name in enumerate(names):
        html = html.replace(name, f"part-{index}")
    path.write_text(html, encoding="utf-8")


if __name__ == "__main__":
    output, *paths = map(Path, sys.argv[1:])
    write(explorer(*map(load, paths)), output)
