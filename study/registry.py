"""Things that people call by name, and what to say when the name is wrong."""

import difflib
import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import ModuleType
from typing import Generic, TypeVar

T = TypeVar("T")


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Name the nearest known word, or all of them when none is near."""
    known = list(known)
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"did you mean '{near[0]}'?" if near else f"known are {', '.join(known)}."


class UnknownName(KeyError):
    """A name that the registry does not hold; the message names the nearest one."""

    def __str__(self) -> str:
        return str(self.args[0])


class Registry(Mapping[str, T], Generic[T]):
    """An ordered, read-only mapping from names to problems, schemes or observers.

    An alias is another name of an entry: it can be looked up, and is not listed. Entries that take a while to make are
    given by functions that make them, called when they are first asked for.
    """

    def __init__(
        self,
        kind: str,
        entries: Mapping[str, T],
        aliases: Mapping[str, str] | None = None,
        made_by: Mapping[str, Callable[[], T]] | None = None,
    ):
        self.kind = kind
        self._entries, self._aliases = dict(entries), dict(aliases or {})
        self._made_by = dict(made_by or {})
        self._names = [*self._entries, *self._made_by]

    def resolve(self, name: str) -> str:
        """The name under which an entry is listed.

        Raises
        ------
        UnknownName
            If there is no such entry.
        """
        entry = self._aliases.get(name, name)
        if entry not in self._entries and entry not in self._made_by:
            raise UnknownName(f"there is no {self.kind} {name!r}; {did_you_mean(str(name), self)}")
        return entry

    def __getitem__(self, name: str) -> T:
        entry = self.resolve(name)
        if entry not in self._entries:
            self._entries[entry] = self._made_by[entry]()
        return self._entries[entry]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"{self.kind}s: {', '.join(self)}"


def variables_of_modules(package: ModuleType, kind: type[T], first: Iterable[str] = ()) -> dict[str, T]:
    """Variables of one kind in all modules of a package, by name: those of ``first``, then module by module.

    Raises
    ------
    ValueError
        If two modules give one name to different things.
    """
    found: dict[str, T] = {}
    for module in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
        if module.name.endswith(".named"):  # the registry itself
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, kind) and not name.startswith("_") and found.setdefault(name, value) is not value:
                raise ValueError(f"{module.name} gives the name '{name}' a second time; choose another name.")
    return {name: found[name] for name in first} | found
