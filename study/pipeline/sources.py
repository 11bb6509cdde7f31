"""The files that a product depends on, so that a changed module makes again what used it and nothing else."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import grimp

#: Modules that declare options and do not touch results.
_DECLARATIONS = ("study.pipeline.experiment", "study.pipeline.options", "study.pipeline.checks")
#: Every module of ``study`` runs under the settings of the package.
_SETTINGS = "study.settings"
#: The registry of problems imports all modules of its package by itself, which the imports do not show.
_PROBLEMS = "study.problem.named"


class Sources:
    """The imports between the modules of packages.

    Parameters
    ----------
    root
        The folder of the packages.
    packages
        Their names.
    """

    def __init__(self, root: Path, *packages: str):
        self._root = root
        self._graph = grimp.build_graph(*packages, cache_dir=None)
        self._known: dict[str, set[str]] = {}
        for module in _DECLARATIONS:
            self._graph.remove_module(module)

    def _upstream(self, module: str) -> set[str]:
        if module not in self._known:
            self._known[module] = {module} | self._graph.find_upstream_modules(module)
        return self._known[module]

    def of(self, *modules: str) -> list[Path]:
        """Files of some modules and of all that they import, in order."""
        found = set().union(*map(self._upstream, modules))
        if _PROBLEMS in found:
            problems = (one for one in self._graph.modules if one.startswith("study.problem."))
            found = found.union(*map(self._upstream, problems))
        if any(name.startswith("study") for name in found):
            found.add(_SETTINGS)
        return [self._file(name) for name in sorted(found)]

    def _file(self, module: str) -> Path:
        path = self._root.joinpath(*module.split("."))
        return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def schemes_in(options: Any) -> set[str]:
    """Names of schemes that options ask for, however deep they stand."""
    if not isinstance(options, dict):
        return set()
    found: set[str] = set()
    for key, value in options.items():
        if key == "scheme":
            found.add(value)
        elif key == "schemes":
            found.update(value)
        else:
            found |= schemes_in(value)
    return found


def modules_of_schemes(names: Iterable[str]) -> list[str]:
    """The modules that define schemes."""
    from study.scheme.named import schemes

    return [type(schemes[name]).__module__ for name in sorted(names)]
