"""Build the site: ``python -m docs.build RESULTS OUTPUT [FILE.py:NAME ...]`` writes OUTPUT/index.html and its pages.

Each FILE.py:NAME is a user's scheme, which gets a page like the pages of the named schemes.
"""

import os
import secrets
import shutil
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from sphinx.cmd.build import build_main

import study
from docs import accessible, answers, confirmed, decisions, doors, gallery
from docs.conformance_page import REPORTS, codes_page, conformance_page
from docs.docstrings import parsed
from docs.figures_page import figures_page
from docs.plan import PAGES, PRODUCTS, SCHEME_DATASETS
from docs.scheme_page import Library, scheme_page
from docs.scheme_table import index_page
from docs.tables_page import claims_page, tables_page
from paper.products import reader
from study.problem.named import makers
from study.scheme.named import ALIASES
from study.user_files import load

PROJECT = Path(__file__).parent.parent
#: Files of the project that are included in pages.
INCLUDED = ("CONTRIBUTING.md", "CHANGELOG.md", "examples/scheme.py", "examples/parts.smk")


def library_of(results: Path, places: Iterable[str]) -> Library:
    """All named schemes and the user's schemes, with the datasets that their pages read."""
    for place in places:
        if place.rpartition(":")[2] in study.schemes:
            raise SystemExit(f"'{place}' has the name of a scheme of the study; choose another name.")
    read, aliases = reader(results), defaultdict(list)
    for alias, name in ALIASES.items():
        aliases[name].append(alias)
    schemes = dict(study.schemes) | {place.rpartition(":")[2]: load(place, (study.Scheme,)) for place in places}
    return Library({name: read(name) for name in SCHEME_DATASETS}, schemes, aliases)


def registry_page(title: str, documented: Mapping[str, Any]) -> str:
    """A page with the docstring of every entry of a registry."""
    entries = [(name, "-", str(parsed(function))) for name, function in documented.items()]
    first = f"``list(study.{title.lower()})`` gives these names."
    return "\n\n".join(f"{name}\n{line * len(name)}\n\n{text}" for name, line, text in [(title, "=", first), *entries])


def write_sources(results: Path, folder: Path, places: Iterable[str]) -> None:
    """Write the sources of all pages to a folder: pages written by hand, and pages made from data and docstrings."""
    shutil.copytree(PAGES, folder)
    (folder / "included").mkdir()
    for name in INCLUDED:
        shutil.copy(PROJECT / name, folder / "included")
    shutil.copy(PROJECT / "conformance" / "README.md", folder / "included" / "conformance.md")
    shutil.copytree(REPORTS, folder / "included" / "reports")
    gallery.write_scripts(folder / "gallery")
    (folder / "figures").symlink_to(results / "figures")
    library = library_of(results, places)
    pages = {f"schemes/{name}.md": scheme_page(library.subject(name), library) for name in library.schemes}
    pages["schemes/index.md"] = index_page(library)
    pages |= {"claims.md": claims_page(results), "tables.md": tables_page(results)}
    pages["figures.md"] = figures_page()
    pages |= {"how_to/conformance.md": conformance_page(), "how_to/codes.md": codes_page()}
    pages |= {f"included/{name}.md": text for name, text in decisions.tables(results).items()}
    pages["included/answers.md"] = answers.form(results)
    pages["included/doors.md"] = doors.doors(results)
    pages["included/gallery.md"] = gallery.grid()
    pages["included/decks.md"] = confirmed.decks()
    pages["interface/problems.rst"] = registry_page("Problems", makers)
    pages["interface/observers.rst"] = registry_page("Observers", study.observers)
    pages["interface/estimators.rst"] = registry_page("Estimators", study.estimators)
    pages["interface/controllers.rst"] = registry_page("Controllers", study.controllers)
    (folder / "schemes").mkdir()
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")


def build(results: Path, output: Path, places: Iterable[str] = ()) -> None:
    """Build the site from a folder of results, and replace the earlier site.

    Raises
    ------
    SystemExit
        If Sphinx warns, or a user's scheme has the name of a scheme of the study; the earlier site then stays.
    """
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")
    results, output = results.absolute(), output.absolute()
    output.parent.mkdir(parents=True, exist_ok=True)
    # if this process is killed, the next run of the pipeline removes folders whose names have this pattern
    unfinished = output.with_name(f".{output.name}.{os.getpid()}.{secrets.token_hex(8)}.unfinished")
    try:
        with tempfile.TemporaryDirectory() as folder:
            sources = Path(folder, "sources")
            Path(folder, "results").symlink_to(results)
            write_sources(results, sources, places)
            options = ["-q", "-W", "--keep-going", "-b", "html", "-c", str(Path(__file__).parent)]
            if build_main([*options, "-d", str(Path(folder, "trees")), str(sources), str(unfinished)]):
                raise SystemExit("the site is not built: the lines above are the warnings of Sphinx.")
        accessible.complete(unfinished)
        # a checksum of settings that include paths of this machine; only incremental builds need it
        (unfinished / ".buildinfo").unlink()
        for name in PRODUCTS:
            (unfinished / name).parent.mkdir(exist_ok=True)
            shutil.copy(results / name, unfinished / name)
        explorer = unfinished / "explorer.html"  # links of the original begin with the folder of the site
        explorer.write_text(explorer.read_text("utf-8").replace('href="site/', 'href="'), "utf-8")
        shutil.rmtree(output, ignore_errors=True)
        unfinished.rename(output)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


if __name__ == "__main__":
    build(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
