"""Build the site: ``python -m docs.build RESULTS OUTPUT [FILE.py:NAME ...]`` writes OUTPUT/index.html and its pages.

Each FILE.py:NAME is a scheme of a user's own, which gets a page as the named ones have.
"""

import os
import secrets
import shutil
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

from sphinx.cmd.build import build_main

import study
from docs import filled, interface
from docs.data import OF_SCHEMES, Data
from docs.links import problems
from docs.plan import PRODUCTS
from docs.scheme_page import Library, scheme_page
from docs.scheme_table import index_page
from study.scheme.named import ALIASES
from study.user_files import load

PROJECT = Path(__file__).parent.parent
#: Files of the project that pages include.
INCLUDED = ("CONTRIBUTING.md", "CHANGELOG.md", "examples/scheme.py")


def library_of(results: Path, own: Iterable[str]) -> Library:
    """All named schemes and a user's own, with the datasets."""
    for place in own:
        if place.rpartition(":")[2] in study.schemes:
            raise SystemExit(f"'{place}' has the name of a scheme of the study; give it another one.")
    aliases = defaultdict(list)
    for alias, name in ALIASES.items():
        aliases[name].append(alias)
    schemes = dict(study.schemes) | {place.rpartition(":")[2]: load(place, (study.Scheme,)) for place in own}
    return Library(Data(results, OF_SCHEMES), schemes, aliases)


def write_sources(results: Path, folder: Path, own: Iterable[str] = ()) -> None:
    """Write the sources of all pages to a folder: those written by hand, and those made."""
    shutil.copytree(filled.FOLDER, folder, dirs_exist_ok=True)
    (folder / "included").mkdir()
    for name in INCLUDED:
        shutil.copy(PROJECT / name, folder / "included")
    shutil.copytree(results / "figures", folder / "figures", ignore=shutil.ignore_patterns("*.png", "*.pdf"))
    made = {f"interface/{name}.rst": text for name, text in interface.pages().items()}
    for page in filled.pages():
        name = page.relative_to(filled.FOLDER).as_posix()
        try:
            made[name] = filled.filled(page.read_text(encoding="utf-8"), results)
        except (KeyError, IndexError, ValueError) as error:
            raise SystemExit(
                f"docs/pages/{name} asks for what the datasets lack, {error}; make the study of config/study.yaml or a "
                "larger one."
            ) from None
    library = library_of(results, own)
    made |= {f"schemes/{name}.md": scheme_page(library.subject(name), library) for name in library.schemes}
    made["schemes/index.md"] = index_page(library)
    for name, text in made.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


def build(results: Path, output: Path, own: Iterable[str] = ()) -> None:
    """Build the site of some results; what was there before stays if a page is not right.

    Raises
    ------
    SystemExit
        If Sphinx warns of anything, a link leads nowhere, or a page loads something from elsewhere.
    """
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")
    results, output = results.absolute(), output.absolute()
    output.parent.mkdir(parents=True, exist_ok=True)
    # of these names the pipeline removes what a process that was killed has left
    unfinished, before = (
        output.with_name(f".{output.name}.{os.getpid()}.{secrets.token_hex(8)}.unfinished") for _ in range(2)
    )
    try:
        with tempfile.TemporaryDirectory() as folder:
            sources = Path(folder, "sources")
            write_sources(results, sources, own)
            options = ["-q", "-n", "-W", "--keep-going", "-b", "html", "-c", str(Path(__file__).parent)]
            if build_main([*options, "-d", str(Path(folder, "trees")), str(sources), str(unfinished)]):
                raise SystemExit("the site is not built: the lines above say what Sphinx warns of.")
        (unfinished / ".buildinfo").unlink()  # a sum over paths of this machine, for builds that go on
        for name in PRODUCTS:
            shutil.copy(results / name, unfinished)
        if found := problems(unfinished):
            raise SystemExit("\n".join(found))
        if output.exists():
            output.rename(before)
        unfinished.rename(output)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
        shutil.rmtree(before, ignore_errors=True)


def main(results: str, output: str, *own: str) -> None:
    """Build the site as the pipeline does."""
    build(Path(results), Path(output), own)


if __name__ == "__main__":
    main(*sys.argv[1:])
