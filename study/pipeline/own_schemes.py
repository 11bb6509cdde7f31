"""Schemes of a user's own: the configuration names their files, and every section then knows their names.

``python -m study.pipeline.own_schemes 'FILE.py:NAME ...' MODULE DATASET OUTPUT... 'JSON OPTIONS'`` runs an experiment
with such schemes.
"""

import shlex
import sys
from collections.abc import Mapping
from functools import cache
from typing import Any

from study.pipeline import command
from study.pipeline.sources import schemes_in
from study.scheme.base import Scheme
from study.scheme.named import register
from study.user_files import load


def name_of(place: str) -> str:
    """The name that a scheme, ``FILE.py:NAME``, has in the pipeline."""
    return place.rpartition(":")[2]


def file_of(place: str) -> str:
    """The file of a scheme, ``FILE.py:NAME``."""
    return place.rpartition(":")[0]


@cache
def register_own(place: str) -> None:
    """Give a scheme, ``FILE.py:NAME``, its name in this process.

    Raises
    ------
    ValueError
        If there is no such scheme, it cannot have that name, or what it tells of itself is unfit.
    """
    try:
        register(name_of(place), load(place, (Scheme,)))
    except TypeError as error:
        raise ValueError(str(error)) from error


def own_schemes_in(options: Any, configuration: Mapping) -> dict[str, str]:
    """The schemes of a user's own that the options of a job ask for, by name, each as ``FILE.py:NAME``."""
    asked, own = schemes_in(options), configuration.get("own_schemes", ())
    return {name_of(place): place for place in own if name_of(place) in asked}


def main(places: str, *arguments: str) -> None:
    """Make the datasets of one job with schemes of a user's own.

    Raises
    ------
    SystemExit
        If a scheme cannot be had, or as :func:`study.pipeline.command.main` does.
    """
    try:
        for place in shlex.split(places):
            register_own(place)
    except ValueError as error:
        raise SystemExit(str(error)) from None
    command.main([*arguments])


if __name__ == "__main__":
    main(*sys.argv[1:])
