"""Loading of problems, schemes and other objects from Python files of a user."""

import importlib.util
import sys
import traceback
from pathlib import Path
from typing import Any

from study.registry import did_you_mean


class Unloadable(ValueError):
    """A file or a name in it cannot be loaded; the message states why, in one sentence."""


def load(place: str, kinds: tuple[type, ...]) -> Any:
    """The object ``NAME`` of the file ``FILE.py``, given as ``FILE.py:NAME``.

    Parameters
    ----------
    kinds
        Allowed classes of the object. ``NAME`` may also be a function without arguments that returns such an object;
        the function is then called.

    Raises
    ------
    Unloadable
        If there is no such file or name, if running the file or the function fails, or if the object has another class.
    """
    file, separator, name = place.rpartition(":")
    types = " or ".join(kind.__name__ if kind.__module__ == "builtins" else f"study.{kind.__name__}" for kind in kinds)
    if not separator or not file.endswith(".py"):
        raise Unloadable(f"'{place}' must name a file and a {types} in it, such as model.py:frame.")
    path = Path(file)
    if not path.is_file():
        raise Unloadable(f"there is no file '{file}'.")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.parent.resolve()))  # so that the file can import modules next to it
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # a user's file may raise anything
        raise Unloadable(f"{_where(error, path)}: {type(error).__name__}: {error}") from error
    finally:
        sys.path.pop(0)
    if not hasattr(module, name):
        known = [key for key, value in vars(module).items() if isinstance(value, kinds)]
        raise Unloadable(f"'{file}' has no '{name}'; {did_you_mean(name, known) if known else f'it has no {types}.'}")
    value = getattr(module, name)
    if callable(value) and not isinstance(value, kinds):
        try:
            value = value()
        except Exception as error:
            raise Unloadable(f"{_where(error, path)}: {type(error).__name__}: {error}") from error
    if not isinstance(value, kinds):
        raise Unloadable(f"{place} must be a {types}, not {type(value).__name__}.")
    return value


def _where(error: BaseException, path: Path) -> str:
    """Path of a user's file, with ``:`` and the number of its innermost line in the traceback of an error, if any."""
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename).resolve() == path.resolve()
    ]
    if not lines and isinstance(error, SyntaxError):
        lines = [error.lineno]
    return f"{path}:{lines[-1]}" if lines else str(path)
