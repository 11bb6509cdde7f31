"""The files that a job depends on. Only the jobs that import a changed module become out of date."""

from collections.abc import Iterable
from pathlib import Path

import grimp

#: Modules that declare options. They do not affect results, so jobs do not depend on them.
_DECLARATIONS = ("study.declaration.experiment", "study.declaration.options", "study.declaration.checks")
#: Modules of ``study`` that run before any other module, although the graph of imports does not show it.
_FIRST = ("study.settings",)
#: Suffixes of the data files that modules of ``paper`` read from their folders: printed numbers, styles, explorer.
_DATA = (".csv", ".js", ".css", ".html", ".mplstyle")
#: Folders with data files, and the suffixes of these files: printed numbers, ground motion, and verdicts on other
#: programs. A module depends on such a file if the name of the file is in the text of the module.
_NAMED, _SUFFIXES = ("study", "conformance/verdicts"), (".csv", ".at2", ".json")


class Sources:
    """The imports between the modules of packages below the folder ``root``."""

    def __init__(self, root: Path, *packages: str):
        self.root = root
        self._graph = grimp.build_graph(*packages, cache_dir=None)
        self._known: dict[str, set[str]] = {}
        for module in _DECLARATIONS:
            self._graph.remove_module(module)
        named = [path for name in _NAMED for path in sorted(root.joinpath(name).rglob("*")) if path.suffix in _SUFFIXES]
        readers = [path for name in ("study", "paper") for path in root.joinpath(name).rglob("*.py")]
        texts = {path: path.read_text(encoding="utf-8") for path in readers}
        self._named = {path: [file for file in named if file.name in text] for path, text in texts.items()}

    def of(self, modules: Iterable[str]) -> list[Path]:
        """Files of the given modules and of all modules that they import, and the data files that they read."""
        names: set[str] = set()
        for module in modules:
            if module not in self._known:
                self._known[module] = {module} | self._graph.find_upstream_modules(module)
            names |= self._known[module]
        if any(module.startswith(("study.", "reference.")) for module in names):
            names.update(_FIRST)
        paths = [self.root.joinpath(*name.split(".")) for name in sorted(names)]
        files = [path / "__init__.py" if path.is_dir() else path.with_suffix(".py") for path in paths]
        folders = dict.fromkeys(path.parent for path in files if path.relative_to(self.root).parts[0] == "paper")
        data = (path for folder in folders for path in sorted(folder.iterdir()) if path.suffix in _DATA)
        return [*files, *data, *(file for path in files for file in self._named.get(path, ()))]
