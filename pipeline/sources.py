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
#: Files that modules of ``study`` read, by module: printed numbers of the elastic beam, and the record of El Centro.
_READ = {
    "study.problem.linkages": "study/problem/elastic_beam.csv",
    "study.mechanics.ground": "study/mechanics/records/el_centro_1940_ns.at2",
}


class Sources:
    """The imports between the modules of packages below the folder ``root``."""

    def __init__(self, root: Path, *packages: str):
        self.root = root
        self._graph = grimp.build_graph(*packages, cache_dir=None)
        self._known: dict[str, set[str]] = {}
        for module in _DECLARATIONS:
            self._graph.remove_module(module)

    def of(self, modules: Iterable[str]) -> list[Path]:
        """Files of the given modules and of all modules that they import, and the data files that they read."""
        found: set[str] = set()
        for module in modules:
            if module not in self._known:
                self._known[module] = {module} | self._graph.find_upstream_modules(module)
            found |= self._known[module]
        if any(module.startswith(("study.", "reference.")) for module in found):
            found.update(_FIRST)
        paths = [self.root.joinpath(*name.split(".")) for name in sorted(found)]
        files = [path / "__init__.py" if path.is_dir() else path.with_suffix(".py") for path in paths]
        folders = dict.fromkeys(path.parent for path in files if path.relative_to(self.root).parts[0] == "paper")
        data = (path for folder in folders for path in sorted(folder.iterdir()) if path.suffix in _DATA)
        return [*files, *data, *(self.root / _READ[module] for module in sorted(found & _READ.keys()))]
