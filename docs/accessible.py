"""Names and levels for screen readers that the theme omits."""

from pathlib import Path

#: Texts of the theme, and their replacements in a page.
REPLACED = {
    'class="caption" role="heading"': 'class="caption" role="heading" aria-level="2"',
    '<aside class="sidebar-drawer"': '<aside class="sidebar-drawer" aria-label="pages of the site"',
    '<aside class="toc-drawer': '<aside aria-label="headings of the page" class="toc-drawer',
    # the search page has no heading before it shows results
    '<div id="search-results">': '<h1 class="hidden">Search</h1>\n<div id="search-results">',
}


def complete(folder: Path) -> None:
    """Add names and levels to all pages of a site."""
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        for old, new in REPLACED.items():
            text = text.replace(old, new)
        page.write_text(text, encoding="utf-8")
