"""The page of the maps, in a browser that reaches no network."""

import subprocess
import sys
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
import xarray as xr

from paper.explorer.data import coarse, largest_safe
from paper.figures.style import OUTCOME_STYLES
from paper.products import PRODUCTS, discover
from study.io import SOURCE
from tests.browser import WIDTHS, check_page, needs_browser, set_width, wait

discover(["explorer"])
PROBLEMS = ["hardening", "softening", "double_well"]
SCHEMES = ["average_acceleration", "hht_alpha_1996", "bathe"]
AMPLITUDES, PARTS = np.logspace(-1.5, 1.5, 12), np.logspace(-2, 0, 8)
SIZES = {"scheme": 3, "problem": 3, "amplitude": 12, "dt_over_period": 8, "sample": 20, "point": 17}
U0 = np.outer([1.5, 4.0, 0.5], AMPLITUDES)
LABELS = [label for label, _ in OUTCOME_STYLES.values()]
READY = "return document.documentElement.dataset.ready !== undefined"


def _values(*dims, seed=0):
    return (dims, np.random.default_rng(seed).uniform(-1, 1, [SIZES[d] for d in dims]))


def _case(name, u0, dt):
    """One of the paper's runs, by two of the three schemes."""
    of_run = ("scheme", "t")
    motion = np.random.default_rng(3).uniform(-1, 1, (2, 200))
    motion[:, 0] = u0
    quantities = {"u": motion, "v": motion, "height": 1 + 0.1 * motion / u0, "energy_error": 7 * motion / u0}
    return xr.Dataset(
        {n: (of_run, v) for n, v in quantities.items()} | {"dt": dt, "failed_at_step": ("scheme", [-1, -1])},
        {"scheme": SCHEMES[:2]},
        {"problem": name},
    )


@pytest.fixture(scope="module")
def datasets():
    """Maps, samples, orbits and the runs of the paper, of random numbers."""
    of_amplitude = ("problem", "amplitude")
    coordinates = {
        "scheme": SCHEMES,
        "scheme_title": ("scheme", ["Average acceleration", "α-method", "Bathe <&>"]),
        "problem": PROBLEMS,
        "problem_title": ("problem", ["hardening spring", "softening spring", "double well"]),
        "amplitude": AMPLITUDES,
        "dt_over_period": PARTS,
        "u0": (of_amplitude, U0),
        "period": (of_amplitude, np.full((3, 12), 2.0)),
        "periods": 100,
    }
    cell = ("scheme", "problem", "amplitude", "dt_over_period")
    outcome = np.random.default_rng(1).integers(0, 8, [SIZES[d] for d in cell]).astype(np.int8)
    outcome[..., :2] = 0  # so that there are safe steps
    told = {"flag_meanings": " ".join(OUTCOME_STYLES), "flag_explanations": "; ".join(f"meaning {k}" for k in range(8))}
    quantities = ("max_energy_error", "max_newton_iterations", "lyapunov_exponent")
    atlas = xr.Dataset(
        {"outcome": (cell, outcome, told), "at_step": (cell, outcome.astype(np.int32) - 1)}
        | {name: (cell, abs(_values(*cell, seed=index)[1])) for index, name in enumerate(quantities)},
        coordinates,
    )
    names = ("u", "v", "early_u", "early_v")
    samples = {name: _values(*cell, "sample", seed=index) for index, name in enumerate(names)}
    every = {"every": ("dt_over_period", np.full(8, 2)), "early_every": ("dt_over_period", np.full(8, 1))}
    height = (samples["u"][0], 1 + 0.5 * samples["u"][1])
    portraits = xr.Dataset(samples | {"height": height}, coordinates | every)
    orbits = {f"orbit_{name}": _values(*of_amplitude, "point") for name in ("u", "v")}
    amplitudes = xr.Dataset(orbits, {n: coordinates[n] for n in ("problem", "amplitude", "u0", "period")})
    runs = {
        "hardening": (1.5, 0.1),
        "softening": (4.0, 0.1),
        "softening_large": (10.0, 0.225),
        "double_well": (0.5, 0.7),
    }
    cases = [_case(name, *run) for name, run in runs.items()]
    angle = np.linspace(0, 2 * np.pi, 257)
    exact = [
        xr.Dataset({"u": ("t", u0 * np.cos(angle)), "v": ("t", u0 * np.sin(angle)), "period": 2.0})
        for u0, _ in runs.values()
    ]
    return {"atlas": [atlas], "portraits": [portraits], "amplitudes": [amplitudes], "cases": cases, "references": exact}


def _made(datasets, folder):
    """The page as the pipeline makes it."""
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
    return _made(datasets, tmp_path_factory.mktemp("page"))


def _open(browser, page, address="", width=800):
    browser.get("about:blank")  # without it, another address of the page would not open it anew
    set_width(browser, width)
    browser.get(page.as_uri() + address)
    wait(browser, READY)


def _text(browser, selector):
    return browser.execute_script("return document.querySelector(arguments[0]).innerText", selector)


def _act(browser, along, up, click=False):
    """Move the mouse to a place of the first map, both from 0 to 1, and click there if asked."""
    from selenium.webdriver import ActionChains

    frame = "const {left, top, width, height} = document.querySelector('canvas').getBoundingClientRect()"
    left, top, width, height = browser.execute_script(f"{frame}; return [left, top, width, height]")
    actions = ActionChains(browser, duration=0)
    actions.w3c_actions.pointer_action.move_to_location(int(left + along * width), int(top + (1 - up) * height))
    if click:
        actions.w3c_actions.pointer_action.click()
    actions.perform()


def _address(browser):
    return {key: value for key, (value,) in parse_qs(urlsplit(browser.current_url).fragment).items()}


def _place(amplitude, part):
    """How the page names the run of a cell."""
    return f"u₀ = {float(f'{U0[1, amplitude]:.3g}'):g}"


@needs_browser
@pytest.mark.parametrize("width", WIDTHS)
def test_it_opens_on_the_marked_run_at_every_width(browser, page, width):
    _open(browser, page, width=width)
    assert _text(browser, "h2") == "Softening spring, 100 periods: α-method, Average acceleration"
    assert "α-method" in browser.title and "softening spring" in browser.title
    for side in (0, 1):
        told = _text(browser, f".run[data-side='{side}']")
        assert "u₀ = 10, Δt = 0.225" in told and "The run of 1996: 199 steps" in told
    assert "u₀ = 10" in _text(browser, "button[aria-pressed='true']")
    tops = browser.execute_script("return [...document.querySelectorAll('.map')].map((map) => map.offsetTop)")
    assert (tops[0] == tops[1]) == (width > 640)  # side by side where there is room
    check_page(browser)


@needs_browser
def test_the_run_under_the_mouse_is_shown_and_a_click_keeps_it(browser, page, datasets):
    (atlas,), (portraits,) = datasets["atlas"], datasets["portraits"]
    _open(browser, page, width=1600)
    first = _text(browser, ".run .place")
    # the middle of the second cell from the right, and of the third from below
    _act(browser, 6.5 / 8, 2.5 / 12)
    wait(browser, f"return document.querySelector('.run .place').innerText !== '{first}'")
    assert _text(browser, ".run .place").startswith(_place(2, 6))
    one = {"scheme": "hht_alpha_1996", "problem": "softening"}
    outcome = atlas.outcome.sel(one).isel(amplitude=2, dt_over_period=6).item()
    assert _text(browser, ".run [data-class]") == f"{LABELS[outcome]}: meaning {outcome}"
    run = portraits.sel(one).isel(amplitude=2, dt_over_period=6)
    script = """return [...document.querySelectorAll(".run figure:first-child")[0].querySelectorAll(".dot")]
      .map((dot) => [Number(dot.getAttribute("cx")), Number(dot.getAttribute("cy"))])"""
    drawn = np.array(browser.execute_script(script))
    for along, name, sign in ((0, "u", 1), (1, "v", -1)):  # velocities go up, pixels down
        assert np.corrcoef(drawn[:, along], sign * run[name])[0, 1] > 0.9999
    assert "run" not in _address(browser)

    _act(browser, 6.5 / 8, 2.5 / 12, click=True)
    address = _address(browser)
    assert [float(x) for x in address["run"].split(",")] == pytest.approx([AMPLITUDES[2], PARTS[6]], rel=1e-3)
    kept = _text(browser, ".run")
    _act(browser, 1.5 / 8, 9.5 / 12)
    wait(browser, f"return !document.querySelector('.run .place').innerText.startsWith('{_place(2, 6)}')")
    browser.execute_script("document.querySelector('.plane').dispatchEvent(new PointerEvent('pointerleave'))")
    wait(browser, f"return document.querySelector('.run .place').innerText.startsWith('{_place(2, 6)}')")
    assert _text(browser, ".run") == kept

    # the address leads back to it
    _open(browser, page, f"#{urlsplit(browser.current_url).fragment}", width=1600)
    assert _text(browser, ".run") == kept
    check_page(browser)


@needs_browser
def test_a_tap_keeps_a_run_on_a_phone(browser, page):
    from selenium.webdriver.common.actions.action_builder import ActionBuilder
    from selenium.webdriver.common.actions.pointer_input import PointerInput

    _open(browser, page, width=390)
    corner = "const {left, top, width, height} = document.querySelector('canvas').getBoundingClientRect()"
    x, y = browser.execute_script(f"{corner}; return [left + width / 16, top + height / 24]")
    finger = ActionBuilder(browser, mouse=PointerInput("touch", "finger"))
    finger.pointer_action.move_to_location(int(x), int(y)).pointer_down().pointer_up()
    finger.perform()
    wait(browser, "return location.hash !== ''")
    run = [float(x) for x in _address(browser)["run"].split(",")]
    assert run == pytest.approx([AMPLITUDES[-1], PARTS[0]], rel=1e-3)
    check_page(browser)


@needs_browser
def test_a_map_obeys_the_keyboard(browser, page):
    from selenium.webdriver import Keys

    _open(browser, page, "#problem=softening&run=1,0.1")
    start = _text(browser, ".run .place")
    plane = browser.find_element("css selector", ".plane")
    plane.send_keys(Keys.ARROW_UP)
    wait(browser, f"return document.querySelector('.run .place').innerText !== '{start}'")
    plane.send_keys(Keys.ESCAPE)
    wait(browser, f"return document.querySelector('.run .place').innerText === '{start}'")
    plane.send_keys(Keys.ARROW_UP, Keys.ARROW_RIGHT, Keys.ENTER)
    amplitude, part = map(float, _address(browser)["run"].split(","))
    i, j = abs(np.log(AMPLITUDES)).argmin(), abs(np.log(PARTS / 0.1)).argmin()
    assert amplitude == pytest.approx(AMPLITUDES[i + 1], rel=1e-3) and part == pytest.approx(PARTS[j + 1], rel=1e-3)
    check_page(browser)


@needs_browser
def test_an_address_holds_the_whole_choice(browser, page, datasets):
    (atlas,) = datasets["atlas"]
    place = f"{AMPLITUDES[4]:.4g},{PARTS[3]:.4g}"
    _open(browser, page, f"#problem=double_well&schemes=bathe,hht_alpha_1996&colour=error&run={place}")
    chosen = "return [...document.querySelectorAll('select')].map((select) => select.selectedOptions[0].text)"
    assert browser.execute_script(chosen) == ["double well", "largest energy error", "Bathe <&>", "α-method"]
    assert "to 0.1 %" in _text(browser, ".legend")
    for side, scheme in enumerate(("bathe", "hht_alpha_1996")):
        one = atlas.sel(scheme=scheme, problem="double_well").isel(amplitude=4)
        accurate = one.outcome.values == 0
        largest = PARTS[: accurate.argmin()][-1]
        told = _text(browser, f".run[data-side='{side}'] .safe")
        assert told.startswith(
            f"Largest safe step at u₀ = {U0[2, 4]:.3g}: Δt = {2 * largest:.3g} = T/{1 / largest:.3g}."
        )
    # another address, as after a step back; what it does not name is as at first
    browser.execute_script(
        "location.hash = '#problem=hardening&run=hardening&schemes=bathe,nonsense&colour=constructor'"
    )
    wait(browser, "return document.querySelector('h2').innerText.startsWith('Hardening')")
    assert "no run of this scheme" in _text(browser, ".run[data-side='0']")
    assert "The run of 1996" in _text(browser, ".run[data-side='1']")
    check_page(browser)


def test_the_same_data_gives_the_same_page(datasets, page, tmp_path):
    assert _made(datasets, tmp_path).read_bytes() == page.read_bytes()


def test_a_map_is_thinned_to_what_a_page_can_hold(datasets):
    (atlas,) = datasets["atlas"]
    fine = atlas.isel(amplitude=np.repeat(np.arange(12), 11)).assign_coords(amplitude=np.logspace(-1.5, 1.5, 132))
    assert coarse(fine).sizes["amplitude"] == 44
    assert coarse(atlas).sizes == atlas.sizes


def test_a_step_is_safe_only_if_all_finer_ones_are():
    outcome = xr.DataArray(
        np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 0]]),
        {"dt_over_period": [0.01, 0.02, 0.05, 0.1]},
        ("amplitude", "dt_over_period"),
        attrs={"flag_meanings": "accurate bounded growing"},
    )
    maps = xr.Dataset({"outcome": outcome})
    np.testing.assert_array_equal(largest_safe(maps, ["accurate"]), [0.02, np.nan, 0.1])
    np.testing.assert_array_equal(largest_safe(maps, ["accurate", "bounded"]), [0.1, 0.1, 0.1])
