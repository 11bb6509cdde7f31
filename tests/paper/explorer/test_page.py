"""The page of the explorer, with its maps of outcomes, in a browser that reaches no network."""

import subprocess
import sys
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
import xarray as xr

import study
from paper.data import largest_safe
from paper.explorer.data import ERRORS, coarse
from paper.figures.style import OUTCOME_STYLES
from paper.products import PRODUCTS, discover
from study.io import SOURCE
from study.runs.needs import ATTRIBUTES, decisions, joined_needs, needs
from tests.browser import WIDTHS, check_page, set_width, wait
from tests.runs.made_up import runs as made_up
from tests.runs.made_up import with_kinds

discover(["explorer"])
PROBLEMS = ["hardening", "softening", "double_well"]
#: Schemes of the maps; the scripts of the page cannot compute runs of the last one.
SCHEMES = ["average_acceleration", "central_difference", "rk4", "bathe", "wilson_theta", "own"]
TITLES = ["Average acceleration", "Central difference", "Runge-Kutta", "Bathe", "Wilson-θ", "Own <&>"]
EXPLICIT = [0, 1, 1, 0, 0, 0]
AMPLITUDES, STEPS = np.logspace(-1.5, 1.5, 13), np.logspace(-2, 0, 8)
SIZES = {"scheme": 6, "problem": 3, "amplitude": 13, "step_size_over_period": 8}
UNITS = np.array([1.5, 4.0, 0.5])
READY = "return document.documentElement.dataset.ready !== undefined"
ROWS = """return [...document.querySelectorAll("#answer table")].map((table) =>
  [...table.querySelectorAll("tbody tr")].map((row) => [...row.children].map((cell) => cell.innerText)))"""


@pytest.fixture(scope="module")
def datasets():
    """Maps of random numbers, and datasets of the runs of the paper."""
    cell = ("scheme", "problem", "amplitude", "step_size_over_period")
    shape = [SIZES[name] for name in cell]
    random = np.random.default_rng(1)
    # random errors from 0.03 to 300 %, which on average grow with the step size
    errors = {
        name: STEPS * largest * random.uniform(0.01, 1, shape)
        for name, largest in (("max_energy_error", 3), ("period_error", 3))
    }
    errors["period_error"][..., -1] = np.nan
    errors["period_error"][4] = 0.5  # no step is safe
    stated = {
        "flag_meanings": " ".join(OUTCOME_STYLES),
        "flag_explanations": "; ".join("meant" for _ in OUTCOME_STYLES),
    }
    outcome = random.integers(0, len(OUTCOME_STYLES), shape).astype(np.int8)
    scheme_coordinates = {
        "scheme_title": TITLES,
        "explicit": EXPLICIT,
        "force_evaluations_per_step": [0, 1, 4, 0, 0, 0],
    }
    atlas = xr.Dataset(
        {"outcome": (cell, outcome, stated)} | {name: (cell, values) for name, values in errors.items()},
        {name: ("scheme", values) for name, values in scheme_coordinates.items()}
        | {
            "scheme": SCHEMES,
            "force_evaluations_per_iteration": ("scheme", [1, 0, 0, 1, 1, 1]),
            "problem": PROBLEMS,
            "problem_title": ("problem", ["hardening spring", "softening spring", "double well"]),
            "amplitude": AMPLITUDES,
            "step_size_over_period": STEPS,
            "u0": (("problem", "amplitude"), np.outer(UNITS, AMPLITUDES)),
            "periods": 20,
        },
    )
    runs = {
        "hardening": (1.5, 0.0075),
        "softening": (4.0, 0.057),
        "softening_large": (10.0, 0.225),
        "double_well": (0.5, 2.5),
    }
    cases = [
        xr.Dataset({"u": (("scheme", "t"), [[u0]]), "step_size": dt}, attrs={"problem": name})
        for name, (u0, dt) in runs.items()
    ]
    run_errors = [[0.2, 0.05, 0.005, 0.0005], [0.05, 0.05, 0.02, 0.02], [0.2] * 4]
    decided = decisions(with_kinds(joined_needs([needs(made_up(run_errors, "hardening"), [0.1, 0.01])])))
    decided.verdict.attrs = ATTRIBUTES["verdict"]
    return {"atlas": [atlas], "cases": cases, "decisions": [decided]}


def _page_file(datasets, folder):
    """Path of the page, made by the command of the pipeline."""
    product = PRODUCTS["page", "explorer"]
    for argument, names in product.reads.items():
        for name, dataset in zip([names] if isinstance(names, str) else names, datasets[argument], strict=True):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            dataset.assign_attrs(source=SOURCE).to_netcdf(folder / f"{name}.nc")
    page = folder / "explorer.html"
    command = [sys.executable, "-W", "error", "-m", "paper.products", product.module, product.name, folder, page]
    subprocess.run(command, check=True)
    return page


@pytest.fixture(scope="module")
def page(datasets, tmp_path_factory):
    return _page_file(datasets, tmp_path_factory.mktemp("page"))


def _open(browser, page, address="", width=800):
    browser.get("about:blank")  # otherwise an address with another fragment would not load the page again
    set_width(browser, width)
    browser.get(page.as_uri() + address)
    wait(browser, READY)


def _text(browser, selector):
    return browser.execute_script("return document.querySelector(arguments[0]).innerText", selector)


def _click(browser, along, up, kind="mouse"):
    """Click or tap at a place of the first map, given as fractions of its width and height."""
    from selenium.webdriver.common.actions.action_builder import ActionBuilder
    from selenium.webdriver.common.actions.pointer_input import PointerInput

    canvas = browser.find_element("css selector", "canvas")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", canvas)
    frame = "const {left, top, width, height} = arguments[0].getBoundingClientRect(); return [left, top, width, height]"
    left, top, width, height = browser.execute_script(frame, canvas)
    actions = ActionBuilder(browser, mouse=PointerInput(kind, kind), duration=0)
    place = int(left + along * width), int(top + (1 - up) * height)
    actions.pointer_action.move_to_location(*place).pointer_down().pointer_up()
    actions.perform()


def _address(browser):
    """The choices in the address, which the page updates with a delay."""
    browser.execute_async_script("setTimeout(arguments[0], 400)")
    return {key: value for key, (value,) in parse_qs(urlsplit(browser.current_url).fragment).items()}


def _cell(address):
    """Relative amplitude and relative step size of the run in an address."""
    unit = UNITS[PROBLEMS.index(address["problem"])]
    return [float(address["u0"]) / unit, 1 / float(address["steps"])]


@pytest.mark.parametrize("width", WIDTHS)
def test_it_opens_on_a_plain_run_at_every_width(browser, page, width):
    _open(browser, page, width=width)
    assert _text(browser, "#question") == (
        "Largest safe steps: hardening spring, u₀ = 1.5, energy and period within 1\u00a0%"
    )
    assert "Average acceleration, Central difference" in browser.title and "hardening spring" in browser.title
    sides = [browser.find_elements("css selector", f"[data-side='{side}']") for side in (0, 1)]
    assert [element.is_displayed() for side in sides for element in side] == [True, True, width > 640, width > 640]
    tops = {side[0].rect["y"] for side in sides}
    if width > 640:
        assert len(tops) == 1
    else:  # a narrow screen shows one side, which a switch chooses
        browser.find_element("css selector", "label[for='side1']").click()
        assert [element.is_displayed() for side in sides for element in side] == [False, False, True, True]
    for element in sides[1]:
        assert element.rect["width"] > 0.4 * min(width, 1500)
    assert _text(browser, ".run[data-side='1']").startswith("u₀ = 1.5, Δt = 0.00758 = T/20")
    check_page(browser)


def test_the_largest_safe_step_of_every_scheme_is_listed_best_first(browser, page, datasets):
    (atlas,) = datasets["atlas"]
    _open(browser, page, f"#problem=softening&u0={4 * AMPLITUDES[5]}&error=10")
    tables = browser.execute_script(ROWS)
    for rows, explicit in zip(tables, (0, 1), strict=True):
        steps = {}
        for title, name, kind in zip(TITLES, SCHEMES, EXPLICIT, strict=True):
            scheme_map = atlas.sel(scheme=name, problem="softening").isel(amplitude=5)
            good = [max(e, p) <= 0.1 for e, p in zip(scheme_map.max_energy_error, scheme_map.period_error, strict=True)]
            if kind == explicit:
                steps[title] = STEPS[good.index(False) - 1] if good[0] else 0.0
        assert [row[0] for row in rows] == sorted(steps, key=steps.__getitem__, reverse=True)
        for title, *cells in rows:
            if steps[title]:
                assert float(cells[1]) == pytest.approx(1 / steps[title], rel=0.01)
            else:
                assert cells == ["none: even T/100 is not safe"]
    links = "return [...document.querySelectorAll('tbody a')].map((link) => link.getAttribute('href'))"
    assert sorted(browser.execute_script(links)) == sorted(f"site/schemes/{name}.html" for name in SCHEMES)
    # the button of a step shows its run
    (title, step, steps, _), *_ = tables[1]
    browser.find_element("css selector", "#answer table:nth-child(2) button").click()
    assert _text(browser, ".run .place").endswith(f"Δt = {step} = T/{steps}")
    assert browser.title.startswith(title)
    assert browser.execute_script("return document.activeElement.innerText") == step  # the focus stays
    check_page(browser)


def test_a_run_is_computed_at_the_chosen_amplitude_and_step(browser, page):
    _open(browser, page, "#problem=softening&u0=4.1&steps=19&schemes=own,rk4")
    assert "does not compute runs of this scheme" in _text(browser, ".run[data-side='0']")
    period = float(_text(browser, ".run .place").split(" = ")[2]) * 19
    rest = study.OutcomeObserver.of("softening")
    run = study.run("softening", "rk4", dt=period / 19, steps=380, u0=4.1, observe=[rest])
    stated = _text(browser, ".run[data-side='1'] dd")
    assert float(stated.split(" %")[0]) == pytest.approx(100 * run.max_height_error.item(), rel=0.02)
    assert browser.execute_script("return document.querySelectorAll('.run[data-side=\"1\"] figure').length") == 3
    # the displacement of this run grows without bound
    _open(browser, page, "#u0=40&steps=1&schemes=rk4,central_difference")
    assert "The run fails" in _text(browser, ".run")
    check_page(browser)


@pytest.mark.parametrize(("width", "kind"), [(1600, "mouse"), (390, "touch")])
def test_a_click_or_tap_chooses_a_run(browser, page, datasets, width, kind):
    (atlas,) = datasets["atlas"]
    _open(browser, page, width=width)
    # the middle of the second cell from the right, and of the third from below
    _click(browser, 6.5 / 8, 2.5 / 13, kind)
    assert _cell(_address(browser)) == pytest.approx([AMPLITUDES[2], STEPS[6]], rel=1e-3)
    cell = atlas.isel(amplitude=2, step_size_over_period=6).sel(scheme="average_acceleration", problem="hardening")
    label, _ = list(OUTCOME_STYLES.values())[cell.outcome.item()]
    assert _text(browser, ".run [data-class]") == f"{label}: meant"
    shown = _text(browser, ".run")
    # the address of the run opens the same run
    _open(browser, page, f"#{urlsplit(browser.current_url).fragment}", width=width)
    assert _text(browser, ".run") == shown
    check_page(browser)


def test_keys_and_buttons_move_by_cells(browser, page):
    from selenium.webdriver import Keys

    _open(browser, page, f"#problem=softening&u0=4&steps={1 / STEPS[3]}")
    plane = browser.find_element("css selector", ".plane")
    plane.send_keys(Keys.ARROW_UP, Keys.ARROW_RIGHT, Keys.TAB)
    assert _cell(_address(browser)) == pytest.approx([AMPLITUDES[7], STEPS[4]], rel=1e-3)
    for label in ("smaller amplitude", "smaller amplitude", "more steps"):
        browser.find_element("css selector", f"button[aria-label='{label}']").click()
    plane.send_keys(Keys.SHIFT, Keys.ARROW_DOWN)
    assert _text(browser, ".run .place").startswith(f"u₀ = {4 * AMPLITUDES[0]:.3g}")
    steps = browser.find_element("css selector", "#steps")
    assert float(steps.get_property("value")) == pytest.approx(1 / STEPS[3], rel=1e-3)
    # a typed number beyond the map moves to its edge
    steps.send_keys(Keys.CONTROL, "a")
    steps.send_keys("1000", Keys.ENTER)
    assert _text(browser, ".run .place").endswith("= T/100")
    check_page(browser)


def test_an_address_holds_the_whole_choice(browser, page):
    address = "#problem=double_well&schemes=bathe,own&colour=period&error=0.1&u0=0.4&steps=25"
    _open(browser, page, address)
    chosen = "return [...document.querySelectorAll('select')].map((select) => select.selectedOptions[0].text)"
    everything = ["double well", "0.1 %", "error of the period", "Bathe", "Own <&>"]
    assert browser.execute_script(chosen) == everything
    assert _text(browser, ".run .place").startswith("u₀ = 0.4")
    # an address with unknown values restores the default choice
    nonsense = "&".join(f"{key}=constructor" for key in ("problem", "schemes", "colour", "error", "u0", "steps"))
    browser.execute_script("location.hash = arguments[0]", nonsense)
    wait(browser, "return document.querySelector('#question').innerText.includes('hardening')")
    assert browser.execute_script(chosen)[3:] == ["Average acceleration", "Central difference"]
    assert _text(browser, ".run .place").endswith("= T/20")
    # a run of 1996
    browser.find_element("css selector", "#cases button:nth-child(3)").click()
    assert _text(browser, ".run .place").startswith("u₀ = 10, Δt = 0.225 = T/7.9")
    check_page(browser)


def test_the_decisions_of_a_spring_are_listed(browser, page):
    _open(browser, page, "#problem=hardening&error=10")
    assert _text(browser, ".decisions").splitlines() == [
        "displacement, explicit: Cheap, 16 steps a period",
        "displacement, implicit: no step that was tried",
    ]
    _open(browser, page, "#problem=double_well&error=10")
    assert not browser.find_elements("css selector", ".decisions")


@pytest.mark.slow
def test_the_page_leads_to_the_site_in_one_place(page):
    # the site replaces this link when it includes the page
    assert page.read_text().count('href="site/') == 1


def test_the_same_data_gives_the_same_page(datasets, page, tmp_path):
    assert _page_file(datasets, tmp_path).read_bytes() == page.read_bytes()


def test_a_large_map_is_thinned(datasets):
    (atlas,) = datasets["atlas"]
    fine = atlas.isel(amplitude=np.repeat(np.arange(13), 11)).assign_coords(amplitude=np.logspace(-1.5, 1.5, 143))
    assert coarse(fine).sizes["amplitude"] == 48
    assert coarse(atlas).sizes == atlas.sizes


def test_a_step_is_safe_only_if_all_finer_ones_keep_energy_and_period():
    maps = xr.Dataset(
        {
            "max_energy_error": (
                ("amplitude", "step_size_over_period"),
                [[0, 0.01, 0.09, 0], [0.02, 0, 0, 0], [0, 0, 0, 0], [0] * 4],
            ),
            "period_error": (
                ("amplitude", "step_size_over_period"),
                [[0] * 4, [0] * 4, [0, 0.01, 0.02, 0], [0, 0, 0, np.nan]],
            ),
        },
        {"step_size_over_period": [0.01, 0.02, 0.05, 0.1]},
    )
    np.testing.assert_array_equal(largest_safe(maps, 0.01), [0.02, 0, 0.02, 0.05])
    np.testing.assert_array_equal(
        largest_safe(maps.isel(step_size_over_period=[3, 1, 0, 2]), 0.1), [0.1, 0.1, 0.1, 0.05]
    )
    assert 0.01 in ERRORS
