"""Registries, which hold problems, schemes and observers by name, and the messages for unknown names."""

import difflib
import importlib
import pkgutil
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import ModuleType
from typing import Generic, TypeVar

T = TypeVar("T")

#: Largest number of names to suggest.
_SUGGESTIONS = 5


def _plain(word: str) -> str:
    """The letters and digits of a word, in lower case."""
    return re.sub(r"[\W_]", "", word.lower())


def nearest(word: str, known: Iterable[str]) -> list[str]:
    """Known names that a misspelt or shortened word may mean, the likeliest first; empty if no name is near.

    If one to five names contain the word, these are returned; otherwise the name with the most similar spelling. Case
    and separators do not matter.
    """
    names = {str(name): _plain(name) for name in known}
    plain_word = _plain(word)
    containing = [name for name, plain in names.items() if plain_word and plain_word in plain]
    if 0 < len(containing) <= _SUGGESTIONS:
        return containing
    spelt = difflib.get_close_matches(plain_word, names.values(), n=1, cutoff=0.5)
    return [name for name, plain in names.items() if plain in spelt]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """End of a sentence that suggests the nearest known names, or lists all known names if none is near."""
    known = list(known)
    near = nearest(word, known)
    return f"did you mean {' or '.join(map(repr, near))}?" if near else f"known are {', '.join(known)}."


class UnknownName(KeyError):
    """A name that is not known; the message suggests the nearest known names."""

    def __str__(self) -> str:
        # KeyError would show its message in quotation marks
        return str(self.args[0])


class Registry(Mapping[str, T], Generic[T]):
    """An ordered mapping from names to problems, schemes or observers.

    Parameters
    ----------
    kind
        Noun for the entries in messages, in one word.
    entries
        The entries by name.
    aliases
        Further names, each with the name of its entry. They can be looked up, and are not listed.
    makers
        Functions that make entries, by name, for entries that take a while to make. Each function is called at the
        first access of its entry.
    """

    def __init__(
        self,
        kind: str,
        entries: Mapping[str, T],
        aliases: Mapping[str, str] | None = None,
        makers: Mapping[str, Callable[[], T]] | None = None,
    ):
        self.kind = kind
        self._entries, self._aliases = dict(entries), dict(aliases or {})
        self._makers = dict(makers or {})
        self._names = [*self._entries, *self._makers]
        for alias in self._aliases:
            if alias in self._names:
                raise ValueError(
                    f"the {kind} '{alias}' has the name of an alias of '{self._aliases[alias]}'; choose another."
                )

    def resolve(self, name: str) -> str:
        """The name under which an entry is listed, from this name or an alias; case and separators do not matter.

        Raises
        ------
        UnknownName
            If there is no such entry.
        """
        entry = self._aliases.get(name, name)
        if entry in self._entries or entry in self._makers:
            return entry
        for known in (*self._names, *self._aliases):  # the name in another case or with other separators
            if _plain(known) == _plain(str(name)):
                return self._aliases.get(known, known)
        raise UnknownName(f"there is no {self.kind} {name!r}; {did_you_mean(str(name), self)}")

    def add(self, name: str, entry: T) -> None:
        """Enter your own object under a new name.

        Raises
        ------
        ValueError
            If the name is taken, does not begin with a small letter, or contains other characters than small letters,
            digits and underscores.
        """
        if not isinstance(name, str) or not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            raise ValueError(f"a {self.kind} has a name of small letters, digits and underscores, not {name!r}.")
        if name in self._names or name in self._aliases:
            raise ValueError(f"there is a {self.kind} '{name}' already; choose another name.")
        self._entries[name] = entry
        self._names.append(name)

    def __getitem__(self, name: str) -> T:
        entry = self.resolve(name)
        if entry not in self._entries:
            self._entries[entry] = self._makers[entry]()
        return self._entries[entry]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"{self.kind}s: {', '.join(self)}"


def variables_of_modules(package: ModuleType, kind: type[T], first: Iterable[str] = ()) -> dict[str, T]:
    """Variables of one kind in the modules of a package, by name: first the names ``first``, then module by module.

    Raises
    ------
    ValueError
        If two modules give the same name to different objects.
    """
    values: dict[str, T] = {}
    for module in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
        if module.name.endswith(".named"):  # skip the module that makes the registry
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            # isinstance would also check abstract classes, which takes a twentieth of a second in all
            if kind in type(value).__mro__ and not name.startswith("_") and values.setdefault(name, value) is not value:
                raise ValueError(f"{module.name} gives the name '{name}' a second time; choose another name.")
    return {name: values[name] for name in first} | values
