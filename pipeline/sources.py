"""The files that a job depends on. A changed module puts only the jobs out of date that import it."""

from collections.abc import Iterable
from pathlib import Path

import grimp

#: Modules that declare options and do not affect results.
_DECLARATIONS = ("study.declaration.experiment", "study.declaration.options", "study.declaration.checks")
#: Modules of ``study`` that run before any other; the graph of imports does not show them.
_FIRST = ("study.settings",)
#: Suffixes of files that a module reads from its folder: printed numbers, styles, and parts of the explorer.
_DATA = (".csv", ".js", ".css", ".html", ".mplstyle")
#: Files that modules read, by module: the benchmark's printed numbers, the record of El Centro, verdicts of the kit.
_READ = {
    "study.problem.linkages": "study/problem/elastic_beam.csv",
    "study.mechanics.ground": "study/mechanics/records/el_centro_1940_ns.at2",
    "paper.tables.other_programs": "conformance/verdicts/*.json",
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
        """Files of modules and of all that they import, and the data that they read."""
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
        read = (path for module in sorted(found & _READ.keys()) for path in sorted(self.root.glob(_READ[module])))
        return [*files, *data, *read]
