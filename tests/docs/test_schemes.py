"""Pages of schemes, and the table of all schemes."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import study
from docs import confirmed
from docs.drawing import ACCENT, INK, panel, svg
from docs.scheme_page import Library, scheme_page
from docs.scheme_results import orders
from docs.scheme_table import COLUMNS, table_of
from docs.scheme_verdict import _stable_again, verdict
from docs.theory import PERIODS, TRIED, error_of_displacement, theory_of
from study.runs.needs import joined_needs, needs
from study.scheme.codes import names_in_codes, steps_in_decks
from study.user_files import load
from study.words import number, percent
from tests import bibliography
from tests.runs.made_up import COUNTS, runs

HEUN = Path(__file__).parents[2] / "examples" / "scheme.py"


class Empty(dict):
    """Datasets without any scheme."""

    def __missing__(self, name):
        return xr.Dataset(coords={"scheme": [], "problem": ["softening"]}).assign(
            median_seconds_per_step=(("problem", "scheme"), np.empty((1, 0)))
        )


@pytest.fixture(scope="module")
def library():
    schemes = {name: study.schemes[name] for name in ("houbolt", "central_difference")}
    return Library(Empty(), schemes | {"heun": load(f"{HEUN}:heun", (study.Scheme,))}, {"houbolt": ["hbt"]})


def test_pages_of_named_schemes_and_of_ones_own_have_one_form(library):
    """A page of a scheme that lacks a section, or prints one without data."""
    pages = {name: scheme_page(library.subject(name), library) for name in library.schemes}
    headings = {name: re.findall("^## .*", page, re.MULTILINE) for name, page in pages.items()}
    assert headings["houbolt"] == headings["central_difference"] == headings["heun"]
    # sections without data are omitted, and one sentence lists them
    assert all(
        page.count("on none of the other problems") == 1 and "## Map of stab" not in page for page in pages.values()
    )
    houbolt = pages["houbolt"]
    assert "<code>houbolt</code>, <code>hbt</code>" in houbolt and "10.2514/8.1722" in houbolt
    assert (
        r"\dot u_1 &= (11 u_1 - 18 u_0 + 9 u_{-1} - 2 u_{-2})/(6 \Delta t)" in houbolt
        and "integrator Houbolt" in houbolt
    )
    assert "unconditionally" in houbolt and "ρ∞ = 0 at" in houbolt
    assert "ωΔt ≤ 2," in pages["central_difference"] and "unstable" in pages["central_difference"]


@pytest.mark.slow
def test_linear_theory_of_a_page():
    theory = theory_of(study.schemes["average_acceleration"])
    assert theory.linear.linear_order == pytest.approx(2, abs=0.05)
    assert theory.order_with_damping == pytest.approx(2, abs=0.05)
    again = {name: _stable_again(theory_of(study.schemes[name])) for name in ("rk4", "blanes_moan4")}
    assert again == {"rk4": False, "blanes_moan4": True}
    assert np.isinf(theory.limit) and theory.at_infinity == pytest.approx(1) and theory.linear.memory == 3
    # the period is too long by (ωΔt)²/12
    delay = PERIODS * (2 * np.pi) ** 3 / (12 * TRIED**2)
    assert theory.error[TRIED > 300] == pytest.approx(delay[TRIED > 300], rel=1e-3, abs=1e-7)
    assert np.isnan(theory.least_radius)
    assert theory_of(study.schemes["rk4"]).least_radius == pytest.approx(0.5, abs=1e-3)
    # by the refined roots of the printed formulas
    assert theory_of(study.schemes["chung_lee"]).least_radius == pytest.approx(0.5, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["central_difference", "symplectic_euler", "fox_goodwin", "kr_alpha", "houbolt", "noh_bathe"]
)
def test_the_error_of_the_displacement_is_that_of_runs(name):
    """Roots alone hide errors of the motion's size and phase, such as those of symplectic Euler, of first order."""
    scheme, steps, periods = study.schemes[name], 200, 20
    largest = 0.0
    for u0, v0 in ((1.0, 0.0), (0.0, 1.0)):
        oscillator = study.Problem(lambda u: u, u0=u0, v0=v0)
        run = study.run(oscillator, scheme, dt=2 * np.pi / steps, steps=steps * periods)
        largest = max(largest, float(abs(run.u - u0 * np.cos(run.t) - v0 * np.sin(run.t)).max()))
    (error,) = error_of_displacement(scheme, np.array([steps]), periods)
    assert error == pytest.approx(largest, rel=0.01)


def test_orders_come_from_the_errors():
    steps = np.array([64, 128, 256, 512, 1024, 2048])
    error = (("scheme", "problem", "steps_per_period", "periods"), (1.0 / steps[None, None, :, None] ** 3).repeat(2, 3))
    measures = ("displacement_error", "period_elongation", "amplitude_decay", "max_energy_error")
    accuracy = xr.Dataset(
        {measure: (*error, {"units": "1"}) for measure in measures},
        {"scheme": ["rk4"], "problem": ["a"], "steps_per_period": steps, "periods": [1, 3]},
    ).assign_coords(problem_title=("problem", ["spring"]))
    data = Empty({"accuracy": accuracy})
    subject = Library(data, study.schemes, {}).subject("rk4")
    assert "| spring | 3 | 3 | 3 | 3 |" in orders(subject, data)


def _kinks(*needed, first_order=0):
    """Made-up runs of central difference and Runge-Kutta on a yielding oscillator.

    ``needed`` states, for each scheme, the steps a period from which on its error is below 1 %. The first
    ``first_order`` schemes have order one.
    """
    steps, names = np.array([16, 32, 64]), ["central_difference", "rk4"]
    dims = ("problem", "scheme", "steps_per_period")
    error = np.where(steps < np.array(needed)[:, None], 0.02, 0.005)[None]
    order = np.array([[2.0, 4.0]])
    order[0, :first_order] = 1.0
    coords = {"problem": ["yielding"], "scheme": names, "steps_per_period": steps}
    return xr.Dataset(
        {
            "sampled_error": (dims, error),
            "max_energy_imbalance": (dims, 0 * error),
            "force_evaluations_per_step": (dims, 0 * error + [[1.0], [4.0]]),
            "observed_order": (dims[:2], order),
            "dividing_order": (dims[:2], np.full((1, 2), np.nan)),
        },
        coords,
    ).assign_coords(
        problem_title=("problem", ["yielding oscillator"]),
        explicit=("scheme", [1, 1]),
    )


def test_the_verdict_follows_the_data():
    names = {name: study.schemes[name] for name in ("central_difference", "rk4")}

    def verdict_of(name, first_order=0, needed=(32, 16), **others):
        kinks = _kinks(*needed, first_order=first_order)
        errors = [np.where(COUNTS < least, 0.02, 0.005) for least in needed]
        made_up = (
            runs([*errors, errors[0]], problem="yield", **others).isel(scheme=[0, 1]).assign_coords(scheme=list(names))
        )
        data = joined_needs([needs(made_up, [0.1, 0.01, 0.001])]).assign_coords(explicit=("scheme", [1, 1]))
        library = Library(Empty({"kinks": kinks, "needs": data}), names, {})
        return verdict(library.subject(name), library)

    cheaper = verdict_of("central_difference")
    assert "within 1\u00a0% on the yielding thing" in cheaper and "first order only" not in cheaper
    assert "| yielding thing | ≤\u00a08 (8) | 32 (32) | – | this one |" in cheaper
    partly = verdict_of("central_difference", velocity=np.where(np.tile(COUNTS, 3) < 64, 0.8, 0.0))
    assert (
        "| ≤\u00a08\u00a0* (8) | 32\u00a0* (32) | – |" in partly
        and "exceeds its bound: 75\u00a0% (velocity), 125" in partly
        and "velocity, acceleration or energy on the yielding thing at the steps marked *" in partly
    )
    dearer = verdict_of("rk4", needed=(32, 64))
    assert "[Central difference](central_difference.md): 32 (32) |" in dearer
    dearer = verdict_of("central_difference", first_order=1, needed=(100, 16))
    assert "within 1\u00a0%" not in dearer and "small errors on the yielding oscillator" in dearer
    assert "| – | – | [Runge-Kutta](rk4.md): 16 (32) |" in dearer


def test_the_verdict_and_the_orders_have_the_circumstances_of_real_problems():
    names, titles = ["displacement", "velocity", "acceleration"], ["plain", "contact", "load"]
    observed = np.array([[2.0, 2.0, 2.0], [2.0, 1.1, 1.0], [2.0, 2.0, 1.0]])
    circumstances = xr.Dataset(
        {
            "observed_order": (("scheme", "circumstance", "quantity"), observed[None]),
            "status": (
                ("scheme", "circumstance", "quantity"),
                np.zeros((1, 3, 3)),
                {"flag_meanings": "measured failed"},
            ),
        },
        {"scheme": ["central_difference"], "circumstance": titles, "quantity": names},
    ).assign_coords(order=("scheme", [2]), circumstance_title=("circumstance", titles))
    data = Empty({"order_under_reality": circumstances})
    library = Library(data, {"central_difference": study.schemes["central_difference"]}, {})
    subject = library.subject("central_difference")
    assert "lose the order 2 or do not converge: contact<" in verdict(subject, library)
    assert "| contact | 2 | 1.1 | 1 |" in orders(subject, data)


def test_a_scheme_without_runs_has_the_steps_of_linear_theory(library):
    page = verdict(library.subject("central_difference"), library)
    assert "| undamped linear oscillator | 102 (102) | 322 (322) | 1,019 (1,019) | this one |" in page


def test_the_better_scheme_is_as_good_in_all():
    """A scheme that is called better although it is worse in one property of linear theory."""
    names = ("houbolt", "park", "average_acceleration", "wbz_alpha", "generalized_alpha")
    library = Library(Empty(), {name: study.schemes[name] for name in names}, {})
    pages = {name: verdict(library.subject(name), library) for name in names}
    # average acceleration is not better than Houbolt's method, because it damps no high frequencies
    assert '<a href="park.html">Park</a>' in pages["houbolt"]
    # both have ρ∞ = 0.8, where roots meet that are known to a root of round-off only
    assert '<a href="generalized_alpha.html">' in pages["wbz_alpha"]
    assert "none in linear theory" in pages["park"] and "none in linear theory" in pages["average_acceleration"]


def test_a_figure_has_the_colours_of_its_page_and_the_same_bytes():
    def drawn():
        figure, axes = panel("x")
        axes.plot([1, 10], [1, 2], color=ACCENT)
        axes.axhline(1, color=INK)
        return svg(figure, 'a "curve"')

    text = drawn()
    assert text == drawn()
    assert "var(--curve)" in text and "currentColor" in text and 'aria-label="a &quot;curve&quot;"' in text
    assert ACCENT not in text and "#ffffff" not in text and "\n\n" not in text and "10¹" in text
    assert not re.search(r"<g id=", text)


def test_numbers_as_they_stand_on_pages():
    assert [number(x) for x in (0, -0.5, 1234, 1.234e-5, np.inf, np.nan)] == [
        "0",
        "−0.5",
        "1230",
        "1.23\u00a0×\u00a010⁻⁵",
        "∞",
        "–",
    ]
    assert (percent(0.0712), percent(-1e-12), percent(np.nan)) == ("7.1\u00a0%", "0\u00a0%", "–")


def test_the_table_has_every_scheme_and_column(library):
    table = table_of([library.subject(name) for name in library.schemes], library)
    assert table.count("<tr") == 1 + 3 and table.count("<button") == len(COLUMNS)
    assert all(row.count("<td") == len(COLUMNS) for row in table.split("<tr")[2:])


def test_names_in_other_codes_can_be_checked():
    rows = names_in_codes()
    assert all(row.scheme in study.schemes and re.match(r"https?://[\w.-]+\.\w+", row.source) for row in rows)
    assert len({(row.scheme, row.code) for row in rows}) == len(rows)
    assert {row.code.split("/")[0] for row in rows} == {
        "OpenSees",
        "Abaqus",
        "LS-DYNA",
        "Code_Aster",
        "SciML",
        "suanPan",
        "ANSYS Mechanical APDL",
        "MOOSE",
        "SAP2000",
    }
    assert "has been confirmed" in confirmed.names_in_codes("gauss4")


def test_the_step_in_the_input_of_a_code_has_a_source_or_is_not_confirmed():
    rows = steps_in_decks()
    assert {"Abaqus/Standard", "ANSYS Mechanical APDL", "LS-DYNA implicit", "SAP2000", "Code_Aster", "MOOSE"} <= {
        row.code for row in rows
    }
    for row in rows:
        assert row.source.startswith("https://") != ("not confirmed" in row.note), row
        assert "{dt}" in row.line or not row.line
    assert confirmed.decks().count("not confirmed") == sum(not row.source for row in rows)


@pytest.mark.parametrize("row", confirmed.limits(), ids=lambda row: row["scheme"])
def test_printed_limits_are_those_of_linear_theory(row):
    limit = study.LinearTheory(study.schemes[row["scheme"]], [0.1]).stability_limit()
    assert limit == pytest.approx(float(row["limit"]), abs=5e-4)
    assert row["work"] in {bibliography.label(work) for work in bibliography.works().values()}
    assert row["place"] in confirmed.printed_limit(row["scheme"])
