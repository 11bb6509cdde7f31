"""Links of a finished site: each leads somewhere, and no page loads anything from elsewhere."""

import functools
import html
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote, urlsplit

_TAG = re.compile(r"<(\w+)\b([^>]*)>")
_ATTRIBUTE = re.compile(r'\b(href|src)="([^"]*)"')
_ID = re.compile(r'\bid="([^"]*)"')
#: What a style sheet loads.
_STYLE = re.compile(r"""@import|url\(\s*["']?(?:https?:)?//""")
#: Tags whose addresses a browser loads by itself.
_LOADED = {"script", "link", "img", "iframe", "source", "video", "audio", "object", "embed"}
#: The explorer is a page of its own, which holds all that it needs.
_WHOLE = {"explorer.html"}


def problems(site: Path) -> list[str]:
    """One sentence for every link that leads nowhere and for everything that is loaded from elsewhere."""
    pages = [page for page in sorted(site.rglob("*.html")) if page.name not in _WHOLE]
    found = [sentence for page in pages for sentence in _of_page(page, site)]
    for style in sorted(site.rglob("*.css")):
        if _STYLE.search(style.read_text(encoding="utf-8")):
            found.append(f"'{style.relative_to(site)}' loads something from elsewhere.")
    return found


@functools.cache
def _anchors(page: Path) -> frozenset[str]:
    return frozenset(_ID.findall(page.read_text(encoding="utf-8")))


def _of_page(page: Path, site: Path) -> Iterator[str]:
    name = page.relative_to(site)
    for tag, attributes in _TAG.findall(page.read_text(encoding="utf-8")):
        for _, written in _ATTRIBUTE.findall(attributes):
            address = urlsplit(html.unescape(written))
            if address.scheme == "data":
                continue
            if address.scheme or address.netloc:
                if tag in _LOADED:
                    yield f"'{name}' loads '{written}' from elsewhere."
                elif address.scheme not in ("http", "https") or "." not in address.netloc:
                    yield f"'{name}' has the link '{written}', which is no address."
                continue
            target = (page.parent / unquote(address.path)).resolve() if address.path else page.resolve()
            if not target.is_file():
                yield f"'{name}' links to '{written}', which is not there."
            elif address.fragment and target.suffix == ".html" and target.name not in _WHOLE:
                if unquote(address.fragment) not in _anchors(target):
                    yield f"'{name}' links to '{written}', and there is no such place on that page."
