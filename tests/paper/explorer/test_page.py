"""The page of the maps, in a browser that reaches no network."""

import shutil
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from paper.data import SOURCE
from paper.explorer.data import cases_source, coarse
from paper.products import PRODUCTS, discover

discover(["explorer"])
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
needs_browser = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="needs chromium and chromedriver (Debian: chromium, chromium-driver)"
)
PROBLEMS = ["hardening", "softening", "double_well"]
SCHEMES = ["average_acceleration", "hht_alpha"]
AMPLITUDES, PARTS = np.logspace(-1.5, 1.5, 12), np.logspace(-2, 0, 8)
SIZES = {"scheme": 2, "problem": 3, "amplitude": 12, "dt_over_period": 8, "sample": 20, "point": 17}
#: The canvas of the map within the page, and the sources that the page draws from, as the browser has them.
FRAME = """
const views = [...Bokeh.index.roots]
for (const view of views) views.push(...(view.child_views ?? []))
const map = views.find((view) => view.model.type === "Figure")
const {left, top} = map.el.getBoundingClientRect(), {bbox} = map.frame
return [left + bbox.left, top + bbox.top, bbox.width, bbox.height]
"""
RUN = "return Bokeh.documents[0].get_model_by_name('run').data"
PICK = """
const select = Bokeh.documents[0].roots()[0].select({type: "Select"}).find((one) => one.title === arguments[0])
select.value = arguments[1]
"""


def _values(*dims, seed=0):
    return (dims, np.random.default_rng(seed).uniform(-1, 1, [SIZES[d] for d in dims]))


@pytest.fixture(scope="module")
def datasets():
    """The maps, samples, orbits and one run of the paper, of random numbers."""
    of_amplitude = ("problem", "amplitude")
    coordinates = {
        "scheme": SCHEMES,
        "scheme_title": ("scheme", ["Average acceleration", "α-method"]),
        "problem": PROBLEMS,
        "problem_title": ("problem", ["hardening spring", "softening spring", "double well"]),
        "amplitude": AMPLITUDES,
        "dt_over_period": PARTS,
        "u0": (of_amplitude, np.outer([1.5, 4.0, 0.5], AMPLITUDES)),
        "period": (of_amplitude, np.ones((3, 12))),
    }
    cell = ("scheme", "problem", "amplitude", "dt_over_period")
    outcome = np.random.default_rng(1).integers(0, 8, [SIZES[d] for d in cell]).astype(np.int8)
    quantities = ("max_energy_error", "max_newton_iterations", "lyapunov_exponent")
    atlas = xr.Dataset(
        {"outcome": (cell, outcome), "at_step": (cell, outcome.astype(np.int32) - 1)}
        | {name: _values(*cell, seed=index) for index, name in enumerate(quantities)},
        coordinates,
        {"title": "What becomes of 100 periods"},
    )
    samples = {name: _values(*cell, "sample", seed=index) for index, name in enumerate(("u", "v"))}
    height = (samples["u"][0], 1 + 0.5 * samples["u"][1])
    portraits = xr.Dataset(samples | {"height": height}, coordinates | {"every": ("dt_over_period", np.full(8, 2))})
    orbits = {f"orbit_{name}": _values(*of_amplitude, "point") for name in ("u", "v")}
    amplitudes = xr.Dataset(orbits, {n: coordinates[n] for n in ("problem", "amplitude", "u0", "period")})
    case = xr.Dataset({"u": (("scheme", "t"), [[10.0, 9.0]]), "dt": 0.225}, attrs={"problem": "softening_large"})
    return atlas, portraits, amplitudes, case


def _made(datasets, folder):
    """The page as the pipeline makes it."""
    atlas, portraits, amplitudes, case = datasets
    read = {"atlas": [atlas], "portraits": [portraits], "amplitudes": [amplitudes], "cases": [case] * 4}
    product = PRODUCTS["page", "explorer"]
    for argument, names in product.reads.items():
        for name, dataset in zip([names] if isinstance(names, str) else names, read[argument], strict=True):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            dataset.assign_attrs(source=SOURCE).to_netcdf(folder / f"{name}.nc")
    page = folder / "explorer.html"
    command = [sys.executable, "-m", "paper.products", product.module, product.name, folder, page]
    subprocess.run(command, check=True)
    return page


@pytest.fixture(scope="module")
def page(datasets, tmp_path_factory):
    return _made(datasets, tmp_path_factory.mktemp("page"))


@pytest.fixture
def browser(page, tmp_path):
    """A browser that shows the page and can load nothing else."""
    from selenium import webdriver

    assert CHROMIUM and DRIVER  # needs_browser skips the test otherwise
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in (
        "headless",
        "no-sandbox",
        "disable-gpu",
        "no-first-run",
        "disable-background-networking",
        "disable-component-update",
        "disable-sync",
        "proxy-server=127.0.0.1:9",
        "window-size=1180,1000",
        f"user-data-dir={tmp_path / 'profile'}",
    ):
        options.add_argument(f"--{argument}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))
    driver.set_script_timeout(60)
    driver.get(page.as_uri())
    yield driver
    driver.quit()


def _wait(browser, script):
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(browser, 60).until(lambda b: b.execute_script(script))


def _hover(browser, along, up):
    """Move the mouse to a place of the map, both from 0 to 1."""
    from selenium.webdriver import ActionChains

    left, top, width, height = browser.execute_script(FRAME)
    actions = ActionChains(browser)
    actions.w3c_actions.pointer_action.move_to_location(int(left + along * width), int(top + (1 - up) * height))
    actions.perform()


def _expected(portraits, problem, scheme, amplitude, dt_over_period):
    place = {"amplitude": AMPLITUDES[amplitude], "dt_over_period": PARTS[dt_over_period]}
    return portraits.sel(problem=problem, scheme=scheme, **place)


@needs_browser
def test_the_run_under_the_mouse_is_shown(browser, datasets, tmp_path):
    _, portraits, *_ = datasets
    _wait(browser, "return window.Bokeh?.documents[0]?.is_idle && document.fonts.status === 'loaded'")
    first = _wait(browser, f"{RUN}.u[0]")

    # the middle of the second cell from the right, and of the third from below
    _hover(browser, 6.5 / 8, 2.5 / 12)
    _wait(browser, f"{RUN}.u[0] !== {first}")
    shown = browser.execute_script(RUN)
    wanted = _expected(portraits, "softening", "hht_alpha", 2, 6)
    assert shown["u"] == pytest.approx(wanted.u.values, abs=0.02)
    assert shown["v"] == pytest.approx(wanted.v.values, abs=0.02)
    assert shown["height"] == pytest.approx(wanted.height.values, rel=0.05)
    assert shown["t"] == pytest.approx(np.arange(20) * 2 * PARTS[6])

    browser.execute_script(PICK, "problem", "double_well")
    browser.execute_script(PICK, "scheme", "average_acceleration")
    browser.execute_script(PICK, "outcome", "3")
    seen = "return Bokeh.documents[0].get_model_by_name('outcome 3').visible"
    others = "return Bokeh.documents[0].get_model_by_name('outcome 4').visible"
    assert browser.execute_script(seen) and not browser.execute_script(others)
    assert browser.save_screenshot(str(tmp_path / "one_outcome.png"))
    browser.execute_script(PICK, "colour", "energy_error")
    assert not browser.execute_script(seen)
    shown = browser.execute_script(RUN)
    assert shown["u"] == pytest.approx(_expected(portraits, "double_well", "average_acceleration", 2, 6).u, abs=0.02)

    assert browser.save_screenshot(str(tmp_path / "explorer.png"))
    assert browser.execute_script("return performance.getEntriesByType('resource')") == []
    assert [entry for entry in browser.get_log("browser") if entry["level"] != "INFO"] == []


def test_the_same_data_gives_the_same_page(datasets, page, tmp_path):
    assert _made(datasets, tmp_path).read_bytes() == page.read_bytes()


def test_a_map_is_thinned_to_what_a_page_can_hold(datasets):
    atlas, *_ = datasets
    fine = atlas.isel(amplitude=np.repeat(np.arange(12), 11)).assign_coords(amplitude=np.logspace(-1.5, 1.5, 132))
    assert coarse(fine).sizes["amplitude"] == 44
    assert coarse(atlas).sizes == atlas.sizes


def test_a_run_of_the_paper_lies_at_its_amplitude_and_step(datasets):
    atlas, _, _, case = datasets
    marks = cases_source(atlas, [case]).data
    assert marks["problem"] == ["softening"] and marks["label"] == ["u₀ = 10, Δt = 0.225"]
    assert 10 ** marks["x"][0] == pytest.approx(0.225) and 10 ** marks["y"][0] == pytest.approx(2.5)
