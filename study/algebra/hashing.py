"""Functions as parts of a compiled program, which JAX keeps by their hash."""

from typing import Any

import equinox as eqx
import jax


class ByIdentity:
    """A callable object with the hash of its identity, because Python gives it none: a dataclass, for example."""

    def __init__(self, function: Any):
        self.__wrapped__ = function

    def __call__(self, *arguments: Any, **keywords: Any) -> Any:
        """The value of the object."""
        return self.__wrapped__(*arguments, **keywords)

    def __getattr__(self, name: str) -> Any:
        if name == "__wrapped__":  # of a copy that has no attributes yet
            raise AttributeError(name)
        return getattr(self.__wrapped__, name)

    def __hash__(self) -> int:
        return id(self.__wrapped__)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ByIdentity) and self.__wrapped__ is other.__wrapped__


def hashable(function: Any) -> Any:
    """The function itself, or :class:`ByIdentity` if Python cannot hash it or what it holds besides arrays."""
    leaves, structure = jax.tree.flatten(function)
    try:
        hash((structure, *(leaf for leaf in leaves if not eqx.is_array(leaf))))
    except TypeError:
        return ByIdentity(function) if callable(function) else function
    return function
