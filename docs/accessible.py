"""Labels and heading levels for screen readers, which the theme of the site omits."""

from pathlib import Path

#: Pieces of the theme's HTML, and their replacements.
REPLACED = {
    'class="caption" role="heading"': 'class="caption" role="heading" aria-level="2"',
    '<aside class="sidebar-drawer"': '<aside class="sidebar-drawer" aria-label="pages of the site"',
    '<aside class="toc-drawer': '<aside aria-label="headings of the page" class="toc-drawer',
    # the search page has no heading before it shows results
    '<div id="search-results">': '<h1 class="hidden">Search</h1>\n<div id="search-results">',
}


def complete(folder: Path) -> None:
    """Add the labels and heading levels to all HTML pages of a folder."""
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        for old, new in REPLACED.items():
            text = text.replace(old, new)
        page.write_text(text, encoding="utf-8")
