"""Warnings that name the user's line. This module imports the standard library only."""

import os
import sys
import warnings

#: Beginnings of the names of files in which no line is the user's: those of this package, and of Python's imports.
_INSIDE = (os.path.join(os.path.dirname(__file__), ""), "<frozen importlib")


def warn(message: str, category: type[Warning] = RuntimeWarning) -> None:
    """Warn at the line outside this package that called it, through however many functions."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_INSIDE):
        frame = frame.f_back
    place = frame.f_code.co_filename, frame.f_lineno, frame.f_globals.get("__name__")
    warnings.warn_explicit(message, category, *place, registry=frame.f_globals.setdefault("__warningregistry__", {}))
