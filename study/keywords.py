"""Functions and classes whose parameters are given by name, because programs and books list them in other orders."""

import functools
import inspect
from collections.abc import Callable
from dataclasses import KW_ONLY
from typing import TypeVar, dataclass_transform

import equinox as eqx

Function = TypeVar("Function", bound=Callable)

#: Labels of a scheme, which the message leaves out unless there is nothing else to give.
_LABELS = ("title", "source", "doi")


def _refuse(name: str, of: Callable) -> None:
    """Refuse arguments without a name, with the names of all parameters."""
    parameters = inspect.signature(of).parameters.items()
    names = [known for known, parameter in parameters if known != "cls" and parameter.kind is not parameter.VAR_KEYWORD]
    shown = ", ".join(f"{known}=…" for known in [key for key in names if key not in _LABELS] or names)
    raise TypeError(f"{name} takes keywords only: {name}({shown}).")


def keywords_only(function: Function) -> Function:
    """A function, or the function of a class method, that refuses arguments without a name.

    The parameters of the function after ``*`` are given by name.

    Raises
    ------
    TypeError
        If the function is called with an argument that has no name.
    """
    owned = next(iter(inspect.signature(function).parameters), "") == "cls"

    @functools.wraps(function)
    def called(*positional, **named):
        if len(positional) > owned:
            _refuse(f"{positional[0].__name__}.{function.__name__}" if owned else function.__name__, function)
        return function(*positional, **named)

    return called  # type: ignore[return-value]


@dataclass_transform(kw_only_default=True, field_specifiers=(eqx.field,))
class KeywordsOnly:
    """Base class of modules of equinox whose fields are given by name, also in classes that users derive.

    Raises
    ------
    TypeError
        If an object is made with an argument that has no name.
    """

    def __init_subclass__(cls, **options):
        super().__init_subclass__(**options)
        cls.__annotations__ = {"_": KW_ONLY} | inspect.get_annotations(cls)

    def __new__(cls, *positional, **named):
        """A new object."""
        if positional:
            _refuse(cls.__name__, cls)
        return super().__new__(cls)
