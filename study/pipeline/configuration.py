"""The configuration of the pipeline: its model, put together of the experiments' own, and its check before any work.

``python -m study.pipeline.configuration`` prints the JSON schema.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError, create_model

from study.pipeline.experiment import Experiment, Merged, arguments_of
from study.problem.named import printed_periods, problems, time_scales
from study.registry import Registry, did_you_mean
from study.scheme.base import OneStep
from study.scheme.named import schemes

#: Steps that the runs of a configuration may add up to: about a hundred times those of the full study, or a week.
MOST_STEPS = 1e14
#: Numbers that a job may hold at once: less than two gigabytes.
MOST_VALUES = 2e8
_STRICT = ConfigDict(extra="forbid", strict=True)

REGISTRIES: dict[str, Registry] = {
    "spring": Registry("spring", {name: problems.resolve(name) for name in printed_periods}),
    "structure": Registry("structure", {name: problems.resolve(name) for name in time_scales}),
    "scheme": schemes,
    "one-step scheme": Registry("one-step scheme", {n: s for n, s in schemes.items() if isinstance(s, OneStep)}),
}


def complete(configuration: Any) -> Any:
    """The configuration with ``schemes: all`` written out as every registered scheme."""
    if not isinstance(configuration, Mapping):
        return configuration
    return {
        key: list(schemes) if (key, value) == ("schemes", "all") else complete(value)
        for key, value in configuration.items()
    }


def model_of(experiments: Iterable[Experiment | Merged]) -> type[BaseModel]:
    """The model of the whole configuration, in which every section is that of an experiment."""
    tree: dict[str, Any] = {}
    for one in experiments:
        if isinstance(one, Experiment) and (one.options is None or one.model is not None):
            *above, last = one.section.split(".")
            place = tree
            for key in above:
                place = place.setdefault(key, {})
            place[last] = one.model or create_model(last, __config__=_STRICT, **arguments_of(one.function))
    return _nested("configuration", tree)


def _nested(name: str, tree: dict[str, Any]) -> type[BaseModel]:
    fields: dict[str, Any] = {
        key: (_nested(key, value) if isinstance(value, dict) else value, ...) for key, value in tree.items()
    }
    return create_model(name, __config__=_STRICT, **fields)


def _sentence(error: Any, configuration: Any) -> str:
    """The first mistake that pydantic found, with the key and what would be right."""
    place = ".".join(str(part) for part in error["loc"])
    if error["type"] == "extra_forbidden":
        *above, key = error["loc"]
        return f"{'.'.join(map(str, above)) or 'the configuration'} has no key {key!r}; {error['known']}"
    if error["type"] == "missing":
        return f"the configuration lacks '{place}'."
    if error["type"] == "value_error":
        return f"{place}: {error['ctx']['error']}."
    received = "" if isinstance(error["input"], dict | list) else f", not {error['input']!r}"
    message = error["msg"].removeprefix("Input should be ").removeprefix("a valid ")
    return f"{place} must be {message}{received}."


def _known_keys(model: Any, above: Iterable[Any]) -> list[str]:
    for key in above:
        fields = getattr(model, "model_fields", None)
        model = fields[key].annotation if fields and key in fields else None
    fields = getattr(model, "model_fields", None) or getattr(model, "__annotations__", {})
    return list(fields)


def check_form(model: type[BaseModel], configuration: Any) -> None:
    """Refuse unknown and missing keys, wrong types, names that are not listed, and numbers out of bounds.

    Raises
    ------
    ValueError
        With one sentence that names the key.
    """
    if not isinstance(configuration, Mapping):
        raise ValueError(f"the configuration must be a mapping from sections to options, not {configuration!r}.")
    strange = next(_strange_keys(configuration, ""), None)
    if strange is not None:
        raise ValueError(f"{strange} of the configuration is no text; put it into quotation marks.")
    try:
        model.model_validate(configuration, context=REGISTRIES)
    except ValidationError as mistakes:
        # an unknown key tells most: where one is misspelt, another is missing
        first = min(mistakes.errors(), key=lambda one: one["type"] != "extra_forbidden")
        if first["type"] == "extra_forbidden":
            *above, key = first["loc"]
            first = dict(first) | {"known": did_you_mean(str(key), _known_keys(model, above))}  # type: ignore[assignment]
        raise ValueError(_sentence(first, configuration)) from None


def _strange_keys(section: Any, place: str):
    """Keys that are no texts, as YAML makes of ``1:`` or ``yes:``."""
    if isinstance(section, Mapping):
        for key, value in section.items():
            if not isinstance(key, str):
                yield f"the key {place}{key!r}"
            yield from _strange_keys(value, f"{place}{key}.")
    elif isinstance(section, list):
        for index, value in enumerate(section):
            yield from _strange_keys(value, f"{place}{index}.")


def check(experiments: Iterable[Experiment | Merged], configuration: Any) -> dict[str, Any]:
    """The complete configuration, if every experiment can be run with it to its end.

    Raises
    ------
    ValueError
        With one sentence that names the key or the dataset, and says what would be right.
    """
    declared = list(experiments)
    whole = complete(configuration)
    check_form(model_of(declared), whole)
    steps, made = 0.0, set(datasets_of(declared, whole))
    for one in declared:
        if isinstance(one, Merged):
            continue
        for options in one.jobs(whole).values():
            reason = one.check(options, whole)
            if reason is not None:
                raise ValueError(f"{one.section}: {reason}")
            for name in one.reads(options):
                if name not in made:
                    raise ValueError(f"{one.section} reads '{name}', a dataset that this configuration does not make.")
            steps += one.steps(options, whole)
            if (values := one.values(options, whole)) > MOST_VALUES:
                raise ValueError(
                    f"{one.section} asks for {values:.1e} numbers at once, and the memory holds {MOST_VALUES:.0e}: ask "
                    "for fewer or shorter runs."
                )
    if steps > MOST_STEPS:
        raise ValueError(
            f"the configuration asks for {steps:.1e} steps in all, and more than {MOST_STEPS:.0e} would take weeks: "
            "ask for fewer or shorter runs."
        )
    return whole


def datasets_of(experiments: Iterable[Experiment | Merged], configuration: Mapping) -> list[str]:
    """The datasets that a configuration makes and keeps, by name."""
    names: list[str] = []
    for one in experiments:
        if isinstance(one, Merged):
            names.append(one.makes)
        elif one.split is None or one.along:
            names += [name for name in one.makes if not one.temporary]
        else:
            names += [f"{name}/{job}" for job in one.jobs(configuration) for name in one.makes]
    return names
