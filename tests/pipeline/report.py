"""Checks of Snakemake's report."""

import json
import re
from pathlib import Path
from typing import Any

from tests.browser import set_width, wait


def check_contents(report: Path, results: Path) -> None:
    """Check that the page of a report opens with a description and lists the products."""
    text = report.read_text()
    stated = {
        name: json.loads(re.findall(rf"<script id=.*>\s*var {name} = (.*);\s*</script>", text)[0])
        for name in ("categories", "results", "workflow_desc", "metadata")
    }
    assert stated["metadata"]  # without a description, the page opens with the graph of rules
    headings = set(stated["categories"])
    assert headings == {"Article", "Assessments", "Explorer", "Figures", "Ledger of claims", "Tables"}
    assert all(heading in stated["workflow_desc"] for heading in headings)
    listed = {Path(path).relative_to("results").as_posix() for path in stated["results"]}
    assert {f"{name}.pdf" for name in ("manuscript", "supplement", "replication")} <= listed
    assert {"explorer.html", "tables.html", "claims.html", "claims.csv"} <= listed
    products = {*results.glob("figures/*.svg"), *results.glob("tables/*.csv")}
    assert {path.relative_to(results).as_posix() for path in products} <= listed
    labels = [result["labels"]["content"] for result in stated["results"].values()]
    assert all(labels) and len(set(labels)) == len(labels)


def check_explorer(report: Path, browser: Any) -> None:
    """Check that the explorer opens from the menu of a report."""
    set_width(browser, 1400)
    browser.get(report.as_uri())
    wait(browser, "return document.querySelector('#app').innerText.includes('What to read first')")
    browser.execute_script("app.showCategory('Explorer')")
    wait(browser, "return document.querySelector('td a')").click()
    browser.switch_to.frame(wait(browser, "return document.querySelector('iframe')"))
    wait(browser, "return document.documentElement.dataset.ready !== undefined")
    browser.switch_to.default_content()
    # warnings are allowed, because the page of the report warns of its own style sheets
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []
