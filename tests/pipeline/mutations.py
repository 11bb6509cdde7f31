"""Random changes of the small configuration."""

import copy
import random
from collections.abc import Iterator
from typing import Any

import yaml
from snakemake.utils import update_config

from paper import products
from pipeline import configuration
from study.declaration.experiment import discover
from tests.pipeline.pipeline import PROJECT, SMALL

#: Sections that stay unchanged; after a change in them, many or slow datasets would be made again.
DEEP = {"references", "agreement", "accuracy", "work_precision", "assess", "structures"}
#: Number of sections in which values are changed, and the factors by which a value may be multiplied.
NUMBERS, FACTORS = 5, (0.3, 0.5, 0.7, 1.4, 2.0)


def _numbers(section: Any, above: tuple = ()) -> Iterator[tuple]:
    """Yield the path of keys to each number of a section."""
    entries = section.items() if isinstance(section, dict) else enumerate(section) if isinstance(section, list) else ()
    for key, value in entries:
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield (*above, key)
        yield from _numbers(value, (*above, key))


def _accepted(settings: dict) -> bool:
    try:
        products.check(products.discover(), configuration.check(discover(), settings))
    except ValueError:
        return False
    return True


def mutated(seed: int) -> dict:
    """Sections of the small configuration in which random factors multiply some numbers; they pass all checks."""
    chance, settings = random.Random(seed), yaml.safe_load((PROJECT / "config" / "study.yaml").read_text())
    update_config(settings, yaml.safe_load((PROJECT / SMALL).read_text()))
    changed: set[str] = set()
    places = sorted((place for place in _numbers(settings) if place[0] not in DEEP), key=str)
    chance.shuffle(places)
    for *above, last in places:
        tried = copy.deepcopy(settings)
        section: Any = tried
        for key in above:
            section = section[key]
        section[last] = type(section[last])(section[last] * chance.choice(FACTORS))
        if _accepted(tried):
            settings = tried
            changed.add(above[0])
        if len(changed) == NUMBERS:
            break
    return {name: settings[name] for name in sorted(changed)}
