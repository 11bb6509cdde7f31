"""The configuration of the pipeline, checked before any work starts."""

from pathlib import Path
from typing import Any

import jsonschema
import yaml

from study.problems import problems
from study.registry import Registry, did_you_mean
from study.schemes import schemes

SCHEMA = Path(__file__).parent.parent / "config" / "schema.yaml"
_REGISTRIES: dict[str, Registry] = {
    "problem": problems,
    "problems": problems,
    "scheme": schemes,
    "schemes": schemes,
}


def _sentence(error: jsonschema.ValidationError) -> str:
    place = ".".join(map(str, error.absolute_path)) or "the configuration"
    if error.validator == "additionalProperties":
        known: dict = error.schema["properties"]  # type: ignore[index, assignment]
        unknown = next(key for key in error.instance if key not in known)  # type: ignore[union-attr]
        return f"{place} has no key '{unknown}'; {did_you_mean(unknown, known)}"
    return f"{place}: {error.message}."


def _check_names(section: dict[str, Any], place: str) -> None:
    """Look up every name of a problem or a scheme, however deep it stands."""
    for key, value in section.items():
        if isinstance(value, dict):
            _check_names(value, f"{place}{key}.")
        elif key in _REGISTRIES:
            for name in [value] if isinstance(value, str) else value:
                try:
                    _REGISTRIES[key][name]
                except KeyError as error:
                    raise ValueError(f"{place}{key}: {error}") from None


def check(config: dict) -> None:
    """Refuse a configuration that cannot be run, with one sentence that names the key.

    Raises
    ------
    ValueError
        If a key is unknown, missing or of the wrong type, or a problem or scheme is unknown.
    """
    schema = yaml.safe_load(SCHEMA.read_text())
    error = jsonschema.exceptions.best_match(jsonschema.Draft202012Validator(schema).iter_errors(config))
    if error is not None:
        raise ValueError(_sentence(error))
    _check_names(config, "")
    for name in config["phase_portrait"]:
        problems[name]
