"""Checks of pages in a browser that reaches no network."""

import shutil
from pathlib import Path
from typing import Any

import pytest

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
#: Widths in pixels of a phone, a tablet and a large screen.
WIDTHS = (390, 800, 1600)


def start(profile: Path) -> Any:
    """Start a headless browser, whose data are in the folder ``profile``; skip the test if none is installed."""
    if not (CHROMIUM and DRIVER):
        pytest.skip("needs chromium and chromedriver (Debian: chromium, chromium-driver)")
    from selenium import webdriver

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
        f"user-data-dir={profile}",
    ):
        options.add_argument(f"--{argument}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))
    driver.set_script_timeout(60)
    return driver


def wait(browser: Any, script: str) -> Any:
    """Repeat a script until its value is true, and return the value; raise TimeoutException after 60 seconds."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(browser, 60, poll_frequency=0.05).until(lambda b: b.execute_script(script))


def set_width(browser: Any, width: int, height: int = 1000) -> None:
    """Set the size of the browser's screen in pixels; a screen narrower than 500 pixels is that of a phone."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def check_page(browser: Any) -> None:
    """Check that a page is no wider than the screen, logs no error or warning, and loaded nothing from elsewhere."""
    width, screen = browser.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
    assert width <= screen
    logged = [entry for entry in browser.get_log("browser") if entry["level"] != "INFO"]
    assert logged == [], logged
    loaded = browser.execute_script("return performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert [name for name in loaded if not name.startswith("data:")] == []
