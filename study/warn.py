"""Warnings that name the user's line. This module imports the standard library only."""

import sys
import warnings

#: Packages in which no line is the user's.
_INSIDE = {"study", "importlib", "jax", "equinox"}


def warn(message: str, category: type[Warning] = RuntimeWarning) -> None:
    """Warn at the user's line, through however many functions of this package, of JAX and of equinox."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in _INSIDE:
        frame = frame.f_back
    place = frame.f_code.co_filename, frame.f_lineno, frame.f_globals.get("__name__")
    warnings.warn_explicit(message, category, *place, registry=frame.f_globals.setdefault("__warningregistry__", {}))
