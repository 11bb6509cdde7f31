"""The built site: links lead to something, nothing is loaded from elsewhere, and the table of schemes fits a screen."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from docs import accessible
from tests.browser import check_page, set_width

SITE = Path(__file__).parents[2] / "results" / "site"
needs_site = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="`make site` makes results/site")


class Page(HTMLParser):
    """Anchors, links and resources of a page."""

    def __init__(self, path: Path):
        super().__init__()
        self.anchors: set[str] = set()
        self.links: set[str] = set()
        self.resources: set[str] = set()
        self.headings = 0
        self.unnamed: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.anchors |= {values[name] for name in ("id", "name") if values.get(name)}
        self.headings += tag == "h1"
        if tag == "a" and values.get("href"):
            self.links.add(values["href"])
        if values.get("src") or (tag == "link" and "stylesheet" in values.get("rel", "")):
            self.resources.add(values.get("src") or values["href"])
        if tag == "img" and not values.get("alt"):
            self.unnamed.append(str(attrs))


@pytest.fixture(scope="module")
def pages():
    return {path.resolve(): Page(path) for path in SITE.rglob("*.html")}


def broken(pages: dict[Path, Page]) -> list[tuple[str, str]]:
    """Page and address of every link within a site that leads to no file or no anchor."""
    links = []
    for path, page in pages.items():
        for address in page.links | page.resources:
            parts = urlsplit(address)
            if parts.scheme:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            if not target.is_file() or (anchor and target in pages and anchor not in pages[target].anchors):
                links.append((path.name, address))
    return links


def test_a_link_to_no_file_or_no_anchor_is_found(tmp_path):
    text = '<h1 id="a"></h1><a href="#a"></a><a href="#b"></a><a href="https://x.org"></a><img src="y.png">'
    (tmp_path / "index.html").write_text(text)
    path = (tmp_path / "index.html").resolve()
    assert sorted(broken({path: Page(path)})) == [("index.html", "#b"), ("index.html", "y.png")]


@needs_site
def test_links_of_the_site_lead_to_files_and_anchors(pages):
    assert len(pages) > 100 and broken(pages) == []


@needs_site
def test_pages_load_nothing_from_elsewhere(pages):
    assert {
        address
        for page in pages.values()
        for address in page.resources
        if urlsplit(address).scheme in ("http", "https")
    } == set()


@needs_site
def test_pages_have_one_heading_and_names_for_pictures(pages):
    assert {path.name: page.headings for path, page in pages.items() if page.headings != 1} == {}
    assert [image for page in pages.values() for image in page.unnamed] == []


def test_the_theme_is_completed_for_screen_readers(tmp_path):
    (tmp_path / "a.html").write_text(
        '<aside class="sidebar-drawer"><p class="caption" role="heading">How to</p></aside>'
    )
    accessible.complete(tmp_path)
    text = (tmp_path / "a.html").read_text()
    assert 'aria-level="2"' in text and 'aria-label="pages of the site"' in text


@needs_site
def test_the_theme_still_writes_what_is_completed():
    text = (SITE / "index.html").read_text() + (SITE / "search.html").read_text()
    assert all(new in text for new in accessible.REPLACED.values())


@needs_site
def test_the_table_of_schemes_fits_a_screen(browser):
    for width in (1280, 1400):
        set_width(browser, width)
        browser.get((SITE / "schemes" / "index.html").as_uri())
        box, table = browser.execute_script(
            "const box = document.querySelector('.wide'); return [box.clientWidth, box.scrollWidth]"
        )
        assert table <= box, width
        check_page(browser)
