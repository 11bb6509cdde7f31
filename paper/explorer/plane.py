"""The map of step size and amplitude, and the orbit and energy of one run beside it."""

from typing import Any

import numpy as np
import xarray as xr
from bokeh.models import (
    Axis,
    CDSView,
    ColorBar,
    ColumnDataSource,
    CustomJSHover,
    FixedTicker,
    HoverTool,
    Legend,
    LegendItem,
    LinearColorMapper,
    LogColorMapper,
    Span,
)
from bokeh.palettes import RdBu11, YlGnBu9, YlOrRd9, interp_palette
from bokeh.plotting import figure

from paper.explorer.data import LEAST, MOST
from paper.figures.style import OUTCOME_STYLES

#: Palettes that are light at small errors and near zero, and a transparent colour.
REDS, BLUE_TO_RED = interp_palette(YlOrRd9[::-1], 256), interp_palette(RdBu11, 256)
CLEAR = "#0000"


#: Quantities of a cell that the mouse shows, and their labels.
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


def _edges(axis: xr.DataArray) -> tuple[float, float]:
    """Outer edges of the first and the last cell of an axis, as powers of ten."""
    places = np.log10(axis.values)
    half = (places[-1] - places[0]) / (len(places) - 1) / 2
    return places[0] - half, places[-1] + half


def _logarithmic(axis: Axis, labels: dict[float, str]) -> None:
    """Place and label the ticks of an axis whose numbers are exponents of ten, so that all cells have one width."""
    places = {float(np.log10(value)): label for value, label in labels.items()}
    axis.ticker = FixedTicker(ticks=list(places))
    axis.major_label_overrides = places


def map_plane(atlas: xr.Dataset) -> figure:
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
    # the step that the paper recommends
    plane.add_layout(Span(location=np.log10(1 / 20), dimension="height", line_color="black", line_dash="dashed"))
    return plane


def draw_maps(plane: figure, maps: ColumnDataSource, view: CDSView) -> tuple[dict[str, list], HoverTool]:
    """Draw the maps; return their parts by quantity, and the tool that describes the cell under the mouse."""
    (left, right), (bottom, top) = ((span.start, span.end) for span in (plane.x_range, plane.y_range))
    place: dict[str, Any] = {"x": left, "y": bottom, "dw": right - left, "dh": top - bottom, "level": "image"}

    def image(quantity, mapper, **options):
        return plane.image(quantity, color_mapper=mapper, source=maps, view=view, **place, **options)

    legend = Legend(ncols=4, click_policy="hide", label_text_font_size="11px", spacing=4)
    layers: dict[str, list] = {"outcome": [legend]}
    for index, (label, colour) in enumerate(OUTCOME_STYLES.values()):
        alone = LinearColorMapper([colour], low=index - 0.5, high=index + 0.5, low_color=CLEAR, high_color=CLEAR)
        cells = image("outcome", alone, name=f"outcome {index}")
        # an image has no sign in a legend, so a square far outside the plane stands for it
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
        # this image is never hidden, so the mouse always finds it
        renderers=[image("outcome", LinearColorMapper([CLEAR]))],
        tooltips=[(label, f"@{name}{{custom}}") for name, label in _TOLD.items()],
        formatters={f"@{name}": CustomJSHover(code=_NUMBER) for name in _TOLD}
        | {"@outcome": CustomJSHover(args={"labels": [label for label, _ in OUTCOME_STYLES.values()]}, code=_LABEL)},
    )


def mark_cases(plane: figure, cases: ColumnDataSource, view: CDSView) -> None:
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


def portrait_panels(run: ColumnDataSource, orbit: ColumnDataSource, spacing: np.ndarray, samples: int) -> list[figure]:
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
