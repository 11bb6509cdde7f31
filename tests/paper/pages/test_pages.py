"""Tables and ledger as pages."""

import pandas as pd
import pytest

from paper.pages.claims import claims
from paper.pages.tables import tables
from paper.products import PRODUCTS
from tests.browser import WIDTHS, check_page, set_width

LEDGER = pd.DataFrame(
    [
        {"No.": "1", "Section": "2", "Claim": "A < B & C.", "Printed": "", "Verdict": "reproduced"},
        {"No.": "2", "Section": "", "Claim": "D.", "Printed": "x" * 300, "Verdict": "not reproduced; by far"},
        {"No.": "3", "Section": "2", "Claim": "E.", "Printed": "1", "Verdict": "reproduced"},
    ]
)
WIDE = pd.DataFrame([[f"cell {k}" for k in range(30)]], columns=[f"column {k} <&>" for k in range(30)])


def test_the_ledger_counts_verdicts_and_leaves_out_what_is_empty():
    page = claims(LEDGER)
    assert "<p>3 claims: 2 reproduced, 1 not reproduced.</p>" in page
    assert "<h2>1. A &lt; B &amp; C.</h2>" in page
    first, second, _ = page.split("<article>")[1:]
    assert "<dt>printed</dt>" not in first and "<dt>section</dt>" not in second


def test_every_table_but_the_ledger_is_on_the_page():
    declared = {name for kind, name in PRODUCTS if kind == "table"} - {"claims"}
    assert set(PRODUCTS["page", "tables"].reads) == declared
    page = tables(orders=WIDE, models=LEDGER)
    assert (
        '<a href="#orders">' in page
        and '<h2 id="models">Schemes and steps by kind of model</h2>' in page
        and "column 3 &lt;&amp;&gt;" in page
    )


@pytest.mark.parametrize("make", [lambda: claims(LEDGER), lambda: tables(orders=WIDE, models=LEDGER)])
def test_the_pages_fit_every_screen(browser, tmp_path, make):
    path = tmp_path / "page.html"
    path.write_text(make())
    for width in WIDTHS:
        set_width(browser, width)
        browser.get(path.as_uri())
        check_page(browser)
