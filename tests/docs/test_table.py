"""The tables of schemes and of claims in a browser; the table of schemes is operated by the keyboard alone."""

import pandas as pd
import pytest
import xarray as xr

import study
from docs.figures_page import figures_page
from docs.plan import LEDGER, PAGES, TABLES
from docs.scheme_page import Library
from docs.scheme_table import table_of
from docs.tables_page import claims_page, tables_page
from paper.manuscript import TEXTS, TITLES, numbered
from tests.browser import set_width

#: Script that returns the titles of the schemes that the table shows.
SHOWN = """
const rows = [...document.querySelectorAll("tbody tr")]
return rows.filter((row) => !row.hidden).map((row) => row.cells[1].innerText)
"""


@pytest.fixture
def show(browser, tmp_path):
    """Function that opens a table in the browser."""

    def open_table(table):
        script = (PAGES.parent / "static" / "table.js").read_text()
        page = tmp_path / "page.html"
        page.write_text(f'<meta charset="utf-8"><link rel="icon" href="data:,">{table}<script>{script}</script>')
        set_width(browser, 1000)
        browser.get(page.as_uri())

    return open_table


@pytest.fixture
def schemes(show):
    """The table of three schemes, shown in the browser."""
    times = xr.Dataset({"median_seconds_per_step": (("problem", "scheme", "steps_per_period"), [[[7.0], [30.0]]])})
    times = times.assign_coords(problem=["softening"], scheme=["rk4", "houbolt"], steps_per_period=[64])
    library = Library({"work_precision": times}, study.schemes, {"central_difference": ["verlet"]})  # type: ignore[arg-type]
    table = table_of([library.subject(name) for name in ("houbolt", "rk4", "central_difference")], library)
    show(table)


@pytest.mark.usefixtures("schemes")
def test_the_keyboard_sorts_and_narrows_the_table(browser):
    from selenium.webdriver.common.keys import Keys

    def press(*keys):
        browser.switch_to.active_element.send_keys(*keys)

    def heading():
        return browser.execute_script("return document.activeElement.innerText")

    press(Keys.TAB, "explicit")
    assert browser.execute_script(SHOWN) == ["Runge-Kutta", "Central difference"]
    press(*[Keys.BACKSPACE] * len("explicit"), "Verlet")  # an alias
    assert browser.execute_script(SHOWN) == ["Central difference"]
    press(*[Keys.BACKSPACE] * len("Verlet"), "Houbolt OpenSees")  # its name in OpenSees
    assert browser.execute_script(SHOWN) == ["Houbolt"]
    press(*[Keys.BACKSPACE] * len("Houbolt OpenSees"))
    sorted_by = {}
    for _ in range(16):  # the search box, the scrolling region, and all headings
        press(Keys.TAB)
        if browser.execute_script("return document.activeElement.tagName") == "BUTTON":
            press(Keys.ENTER)
            sorted_by[heading()] = browser.execute_script(SHOWN)
    assert sorted_by["order"] == ["Central difference", "Houbolt", "Runge-Kutta"]
    assert sorted_by["largest stable ωΔt"] == ["Central difference", "Runge-Kutta", "Houbolt"]
    # period errors are sorted by absolute value; that of central difference is negative
    assert sorted_by["period, %"] == ["Runge-Kutta", "Central difference", "Houbolt"]
    assert sorted_by["time, ns"] == ["Runge-Kutta", "Houbolt", "Central difference"]  # missing values are last
    (last,) = browser.execute_script("return [...document.querySelectorAll('[aria-sort]')].map((one) => one.ariaSort)")
    assert last == "ascending"
    browser.execute_script("document.querySelectorAll('thead button')[10].focus()")
    press(Keys.ENTER)
    assert browser.execute_script(SHOWN) == ["Houbolt", "Runge-Kutta", "Central difference"]
    press(Keys.TAB, Keys.SPACE)
    browser.execute_script("document.querySelector('[name=chosen]').focus()")
    press(Keys.SPACE)
    assert browser.execute_script(SHOWN) == ["Houbolt"]


@pytest.fixture
def results(tmp_path):
    """Folder of results with tables of two rows, and a ledger of three claims."""
    ledger = pd.DataFrame({"No.": ["1", "2", "3"], "Claim": ["A < B.", "C.", "D of A."]}).assign(Whose="Xie, 2")
    ledger = ledger.assign(**{"Decided by": "runs", "Printed": "", "Ours": "1"})
    verdicts = ["reproduced", "not reproduced; by far", "reproduced"]
    (tmp_path / "tables").mkdir()
    for product in TABLES:
        table = pd.DataFrame({"Problem": ["spring", ""], "Scheme": ["explicit", "implicit <b>"]})
        frame = ledger.assign(Verdict=verdicts) if product.name == LEDGER else table
        frame.to_csv(tmp_path / "tables" / f"{product.name}.csv", index=False)
    return tmp_path


def test_words_and_a_verdict_narrow_the_ledger(browser, show, results):
    from selenium.webdriver.common.by import By

    page = claims_page(results)
    assert "3 claims: 2 reproduced, 1 not reproduced." in page
    show(page)
    verdict, words = (browser.find_element(By.NAME, name) for name in ("verdict", "words"))

    def numbers():
        rows = browser.find_elements(By.CSS_SELECTOR, "tbody tr")
        return [row.text.split()[0] for row in rows if row.is_displayed()]

    verdict.send_keys("rep")
    assert numbers() == ["1", "3"]
    words.send_keys("d of")
    assert numbers() == ["3"]
    verdict.send_keys("all")
    words.clear()
    words.send_keys("far")
    assert numbers() == ["2"]


def test_every_table_has_a_section(results):
    page = tables_page(results)
    assert page.count("\n## ") == page.count("<table") == len(TABLES) - 1
    assert '<tr data-words="spring"><td></td><td>implicit &lt;b&gt;</td></tr>' in page


def test_the_page_of_figures_has_the_file_of_each_number():
    """A page without the list by which an author finds the file of a figure."""
    page = figures_page()
    for text in TEXTS:
        for label, name in numbered(text):
            file = f"`{label.split()[0].lower()}s/{name}`" if name else "in the text only"
            assert f"| {label} of the {TITLES[text.stem].lower()} | {file} |" in page
