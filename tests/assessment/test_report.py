"""The page of an assessment, and the command that writes it."""

import contextlib
import io
import re
from html.parser import HTMLParser

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import study
from study.__main__ import main
from study.assessment.drawing import COLOURS, curves
from study.assessment.report import answer, emphasised, page, tables_of
from study.mechanics.definition import Problem
from study.user_files import Unloadable, load
from study.words import step_with_unit
from tests.browser import WIDTHS, check_page, set_width

MODEL = """
import jax.numpy as jnp
import study

swing = study.Problem(jnp.sin, potential=lambda u: 1 - jnp.cos(u), u0=1.0, title="a <swing> & more")
number = 3
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "model.py"
    path.write_text(MODEL)
    return path


class _Balanced(HTMLParser):
    """A parser that fails at an end tag that does not close the last open tag."""

    VOID = {"meta", "br", "img", "link", "path", "use", "rect"}

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def assessed(model, tmp_path_factory):
    """Common path without suffix of the dataset and the page that ``study assess`` wrote, and what it printed."""
    swing = tmp_path_factory.mktemp("assessed") / "swing"
    words = ["assess", f"{model}:swing", "--duration", "12", "--allowed-error", "0.05", "--schemes", "rk4", "newmark"]
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        main([*words, "--output", str(swing)])
    return swing, printed.getvalue()


def test_the_command_writes_a_dataset_and_a_page_of_its_own(assessed):
    """It alone reads the page of ``study assess``."""
    swing, printed = assessed
    assert "For 5\u00a0% of displacement: " in printed and "force_evaluations" in printed
    # the largest speed of a pendulum follows from its energy
    speed = f"{2 * np.sin(0.5):.7g}"
    assert f"Reference of velocity: {speed} s⁻¹ at t = " in printed
    ds = xr.load_dataset(swing.with_suffix(".nc"))
    assert ds.attrs["command"].startswith("study assess ") and ds.attrs["processor"]
    page = swing.with_suffix(".html").read_text()
    _Balanced().feed(page)
    text = re.sub("<svg.*?</svg>", "", page, flags=re.DOTALL)
    assert "a &lt;swing&gt; &amp; more" in text and "<swing>" not in text
    assert not re.search(r"(src|href)=(?!.data:,)|@import|url\(", text) and "http" not in text
    answer = text.index('<td>5\u00a0%</td><td class="text"><b>Runge-Kutta, ')
    model = text.index("period of small motion 6.28 s")
    assert answer < text.index("<h2>") < model < text.index("<h2>Error of displacement")
    assert "relative to the largest value along time. Dashed" in text and "n^(−0.4) with Runge-Kutta; n^(−0.5)" in text
    assert f"<td>velocity</td><td>{speed} ± " in text
    assert "heyoka" in text and study.__version__ in text
    assert "integrator Newmark 0.5 0.25" in text and "frequencies up to ω = " in text


@pytest.mark.slow
def test_your_own_scheme_stands_before_the_best_and_its_curve_is_emphasised(assessed, undrawn):
    ds = xr.load_dataset(assessed[0].with_suffix(".nc")).assign_attrs(asked_for="newmark")
    # measured times, by which schemes are ranked, may have another order on a busy machine
    ds = ds.assign(
        seconds=ds.seconds.where(ds.scheme != "rk4", ds.seconds.min() / 10), seconds_spread=0 * ds.seconds_spread
    )
    title = ds.scheme_title.sel(scheme="newmark").item()
    text = page(ds)
    assert f'<th>error of displacement</th><th class="text">{title}</th><th class="text">explicit</th>' in text
    assert "With markers: your own, and the best of each kind." in text
    tables = tables_of(ds, "displacement")
    assert emphasised(ds, tables) == ["newmark", "rk4"]
    assert emphasised(ds.assign_attrs(asked_for=""), tables)[0] == "rk4"


@pytest.mark.slow
def test_the_limit_of_stability_is_drawn_without_maps(model):
    swing = load(f"{model}:swing", (Problem,))
    ds = study.assess(swing, "central_difference", duration=12, allowed_errors=[0.05], maps=False)
    assert ds.stable_step_size.item() == pytest.approx(2, rel=1e-4)
    assert "limit of stability" in page(ds) and "How it fails" not in page(ds)


@pytest.mark.slow
def test_the_answer_has_no_column_for_a_kind_without_a_scheme(assessed, undrawn):
    ds = xr.load_dataset(assessed[0].with_suffix(".nc"))
    assert 'explicit</th><th class="text">implicit</th></tr>' in page(ds)
    assert '<th class="text">explicit</th></tr>' in page(ds.sel(scheme=["rk4"]))


@pytest.mark.slow
def test_the_limits_of_your_own_step_stand_below_the_answer(assessed, undrawn):
    """A page that states only for the best schemes that another quantity is wrong."""
    ds = xr.load_dataset(assessed[0].with_suffix(".nc")).assign_attrs(asked_for="newmark")
    ds = ds.assign_coords(kind=("scheme", ["explicit"] * 2)).assign(
        seconds=ds.seconds.where(ds.scheme != "rk4", ds.seconds.min() / 10), seconds_spread=0 * ds.seconds_spread
    )
    step = ds.recommended_step_size.sel(scheme="newmark", quantity="displacement").item()
    ds.error.loc[{"scheme": "newmark", "quantity": "velocity", "step_size": step}] = 0.5
    title = ds.scheme_title.sel(scheme="newmark").item()
    assert f"With {title} at {step_with_unit(step)}, velocity is wrong by 50\u00a0%." in page(ds)


@pytest.mark.parametrize("counted", [True, False])
def test_what_decides_between_equal_times_is_named(assessed, counted):
    """A program counts no forces, and its number of steps decides."""
    ds = xr.load_dataset(assessed[0].with_suffix(".nc"))
    forces = ds.force_evaluations if counted else np.nan * ds.force_evaluations
    ds = ds.assign(seconds=0 * ds.seconds + 1.0, force_evaluations=forces)
    assert f"the number of {'evaluations' if counted else 'steps'} decides." in answer(ds, "displacement", 0.05)


@pytest.mark.slow
def test_a_scheme_has_one_colour_in_all_figures_of_a_page(assessed):
    """A colour that depends on which schemes a figure shows."""
    ds = xr.load_dataset(assessed[0].with_suffix(".nc"))
    names = ds.scheme.values.tolist()
    for place, name in enumerate(names):
        drawn = curves(
            ds, ds.step_size, "step", ds.error.isel(quantity=0), "error", emphasised=[name], order=["?", *names]
        )
        assert [colour for colour in COLOURS[1:] if colour in drawn] == [COLOURS[place + 1]]


@pytest.mark.slow
def test_times_of_single_runs_are_points(assessed):
    """A line through measured times of single runs, which jumps to and fro."""
    ds = xr.load_dataset(assessed[0].with_suffix(".nc"))
    against = ds, ds.step_size, "time", ds.error.isel(quantity=0), "error"
    assert [curves(*against, joined=joined).count("stroke-width: 1.4") for joined in (True, False)] == [4, 0]


def test_measured_times_of_single_runs_are_named(assessed, undrawn):
    ds = xr.load_dataset(assessed[0].with_suffix(".nc"))
    assert "The same errors against the time of a run, measured once." in page(
        ds.assign(seconds_per_run=ds.seconds_per_step * ds.steps)
    )


def test_the_drawn_motion_is_the_motion(assessed):
    """The lowest and the highest value in each part of the duration are those of a solution by SciPy."""
    ds = xr.load_dataset(assessed[0].with_suffix(".nc")).sel(quantity="displacement")
    solved = solve_ivp(lambda t, y: [y[1], -np.sin(y[0])], (0, 12), [1.0, 0.0], "DOP853", dense_output=True, rtol=1e-10)
    half = np.diff(ds.reference_t).mean() / 2
    times = ds.reference_t.values[:, None] + half * np.linspace(-1, 1, 33)
    within = solved.sol(times.ravel())[0].reshape(times.shape)
    np.testing.assert_allclose(ds.reference_low, within.min(axis=1), atol=2e-4)
    np.testing.assert_allclose(ds.reference_high, within.max(axis=1), atol=2e-4)


def test_the_page_fits_screens_and_paper(assessed, browser):
    page = assessed[0].with_suffix(".html")
    for width in WIDTHS:
        set_width(browser, width)
        browser.get(page.as_uri())
        check_page(browser)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    set_width(browser, 700)  # width of A4 without margins: a printed page cannot be scrolled
    right = "[...document.querySelectorAll('.scroll > *, pre, dd, p')].map((one) => one.getBoundingClientRect().right)"
    assert max(browser.execute_script(f"return {right}")) <= 700
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


@pytest.mark.parametrize(
    "place, sentence",
    [
        ("model", "'model' must name a file and a study.Problem in it, such as model.py:frame."),
        ("nowhere.py:swing", "there is no file 'nowhere.py'."),
        ("{model}:swong", "'{model}' has no 'swong'; did you mean 'swing'?"),
        ("{model}:number", "{model}:number must be a study.Problem, not int."),
    ],
)
def test_what_cannot_be_loaded_gets_a_sentence(model, place, sentence):
    with pytest.raises(Unloadable) as caught:
        load(place.format(model=model), (Problem,))
    assert str(caught.value) == sentence.format(model=model)


@pytest.mark.parametrize("code, reason", [("x = 1\n1 / 0\n", ":2: ZeroDivisionError"), ("x =\n", ":1: SyntaxError")])
def test_a_file_that_raises_is_named_with_its_line(tmp_path, code, reason, capsys):
    path = tmp_path / "broken.py"
    path.write_text(code)
    with pytest.raises(SystemExit):
        main(["assess", f"{path}:x", "--output", str(tmp_path / "out")])
    error = capsys.readouterr().err
    assert error.startswith(f"study: {path}{reason}") and "Traceback" not in error


def test_other_datasets_have_no_page(tmp_path):
    with pytest.raises(ValueError, match="report takes a dataset of study.assess"):
        study.report(study.run("hardening", "rk4", dt=0.01, steps=2), tmp_path / "x.html")
