"""Things that people call by name, and what to say when the name is wrong."""

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
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

    def __getitem__(self, name: str) -> T:
        entry = self._aliases.get(name, name)
        if entry in self._made_by and entry not in self._entries:
            self._entries[entry] = self._made_by[entry]()
        if entry not in self._entries:
            raise UnknownName(f"there is no {self.kind} {name!r}; {did_you_mean(str(name), self)}")
        return self._entries[entry]

    def __iter__(self) -> Iterator[str]:
        return iter([*(name for name in self._entries if name not in self._made_by), *self._made_by])

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __repr__(self) -> str:
        return f"{self.kind}s: {', '.join(self)}"
