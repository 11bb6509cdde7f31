"""The page: choices above, map, orbit and energy below."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.layouts import column, row
from bokeh.models import CDSView, ColumnDataSource, CustomJS, Div, GroupFilter, Select
from bokeh.resources import INLINE
from bokeh.settings import settings

from paper.explorer.data import cases_source, coarse, maps_source, orbits_source, runs_source
from paper.explorer.plane import draw_maps, map_plane, mark_cases, portrait_panels
from paper.figures.style import OUTCOME_STYLES
from paper.products import page

#: The run that is shown first: the most surprising run of the paper.
FIRST: dict[str, Any] = {"problem": "softening", "scheme": "hht_alpha", "amplitude": 2.5, "dt_over_period": 0.125}


TITLE = "Where can a time integration scheme be trusted?"
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
#: Quantities that may colour the map, and their titles.
_COLOURS = {
    "outcome": "how the run ended",
    "energy_error": "largest energy error",
    "exponent": "Lyapunov exponent",
}


def _script(name: str) -> str:
    """The text of a script of the page."""
    return Path(__file__).with_name(f"{name}.js").read_text(encoding="utf-8")


def _select(dataset: xr.Dataset, name: str) -> Select:
    """A choice of what lies along a coordinate, by its titles."""
    options = list(zip(dataset[name].values.tolist(), dataset[f"{name}_title"].values.tolist(), strict=True))
    return Select(title=name, options=options, value=FIRST[name])


def _document(atlas: xr.Dataset, portraits: xr.Dataset, amplitudes: xr.Dataset, cases: list[xr.Dataset]) -> Document:
    """The parts of the page and what connects them.

    Parameters
    ----------
    atlas, portraits
        Maps of stability, and samples of some of their runs.
    amplitudes
        Exact orbits at the amplitudes of the maps.
    cases
        Phase portraits of the paper's own runs, which the map marks.
    """
    thinned, exact = coarse(atlas), amplitudes.sel(amplitude=portraits.amplitude)
    problem, scheme = (_select(atlas, name) for name in ("problem", "scheme"))
    of_problem, of_scheme = (GroupFilter(column_name=one.title, group=one.value) for one in (problem, scheme))
    problem.js_link("value", of_problem, "group")
    scheme.js_link("value", of_scheme, "group")

    plane = map_plane(thinned)
    layers, hover = draw_maps(plane, maps_source(thinned), CDSView(filter=of_problem & of_scheme))
    mark_cases(plane, cases_source(atlas, cases), CDSView(filter=of_problem))
    colour = Select(title="colour", options=list(_COLOURS.items()), value="outcome")
    labels = [label for label, _ in OUTCOME_STYLES.values()]
    outcome = Select(
        title="outcome", options=[("all", "all"), *((str(k), v) for k, v in enumerate(labels))], value="all"
    )
    outcomes = layers["outcome"][1:]  # behind their legend
    pick = CustomJS(
        args={"layers": layers, "outcomes": outcomes, "colour": colour, "outcome": outcome}, code=_script("pick_colour")
    )
    for one in (colour, outcome):
        one.js_on_change("value", pick)

    x, y = np.log10(portraits.dt_over_period.values), np.log10(portraits.amplitude.values)
    spacing, samples = (portraits.every * portraits.dt_over_period).values, portraits.sizes["sample"]
    first = exact.sel(problem=FIRST["problem"]).sel(amplitude=FIRST["amplitude"], method="nearest")
    orbit = ColumnDataSource({"u": first.orbit_u.values, "v": first.orbit_v.values})
    run = ColumnDataSource({name: [] for name in ("u", "v", "height", "t", "sample")}, name="run")
    place = ColumnDataSource({"x": [np.log10(FIRST["dt_over_period"])], "y": [np.log10(FIRST["amplitude"])]})
    plane.scatter("x", "y", source=place, marker="square", size=9, fill_color=None, line_color="#0a7d32", line_width=2)
    phase, energy = portrait_panels(run, orbit, spacing, samples)
    show = CustomJS(
        args={
            **{"x": x, "y": y, "spacing": spacing, "samples": samples, "points": exact.sizes["point"]},
            **{
                "problem": problem,
                "scheme": scheme,
                "runs": runs_source(portraits, exact, atlas.outcome),
                "orbits": orbits_source(exact),
            },
            **{"run": run, "orbit": orbit, "place": place, "title": phase.title},
            "labels": labels,
        },
        code=_script("show_run"),
    )
    hover.callback = show
    plane.add_tools(hover)
    problem.js_on_change("value", show)
    scheme.js_on_change("value", show)

    note = _NOTE.format(
        cells=f"{thinned.sizes['amplitude']} of {atlas.sizes['amplitude']} amplitudes and "
        f"{thinned.sizes['dt_over_period']} of {atlas.sizes['dt_over_period']} step sizes",
        portraits=len(x) * len(y),
        spacing=spacing[0],
    )
    document = Document(title=TITLE)
    document.add_root(
        column(
            Div(text=_INTRODUCTION, width=1100),
            row(problem, scheme, outcome, colour),
            row(plane, column(phase, energy)),
            Div(text=note, width=1100),
        )
    )
    document.js_on_event("document_ready", show)
    return document


@page(
    "Explorer of the maps of stability: outcome, orbit and energy of each run.",
    name="explorer",
    atlas="stability/atlas",
    portraits="stability/portraits",
    amplitudes="reference/amplitudes",
    cases=[
        "phase_portrait/hardening",
        "phase_portrait/softening",
        "phase_portrait/softening_large",
        "phase_portrait/double_well",
    ],
    asks={"atlas.problems": ["hardening", "softening", "double_well"], "atlas.schemes": [FIRST["scheme"]]},
)
def explorer(atlas: xr.Dataset, portraits: xr.Dataset, amplitudes: xr.Dataset, cases: list[xr.Dataset]) -> str:
    """The page with all that it needs, the same text for the same data."""
    settings.compression_level = 6
    html = file_html(_document(atlas, portraits, amplitudes, cases), INLINE)
    # Bokeh gives the parts of a page new names every time
    names = dict.fromkeys(re.findall(r"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}", html))
    for index, name in enumerate(names):
        html = html.replace(name, f"part-{index}")
    return html
