"""The configuration of the pipeline: its model, composed of the models of the experiments, and its check."""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

try:
    from pydantic import BaseModel, ConfigDict, PydanticSchemaGenerationError, ValidationError, create_model
except ImportError as error:
    raise ImportError(f"the configuration needs the extra 'pipeline' of this package: {error}.") from None

from study.control.named import controllers, estimators
from study.declaration.experiment import Experiment, Merged, arguments_of
from study.declaration.options import OwnSchemes
from study.problem.named import approximate_periods, known, problems, time_scales
from study.registry import Registry, did_you_mean
from study.scheme.base import OneStep, Scheme
from study.scheme.named import register_scheme, schemes
from study.user_files import load

_STRICT = ConfigDict(extra="forbid", strict=True)


def _registries() -> dict[str, Registry]:
    """Names that a configuration may use, by kind."""
    return {
        "spring": Registry("spring", {name: problems.resolve(name) for name in approximate_periods}),
        "structure": Registry("structure", {name: problems.resolve(name) for name in time_scales}),
        "problem with a known displacement": Registry(
            "problem with a known displacement", {name: problems.resolve(name) for name in known}
        ),
        "problem": problems,
        "scheme": schemes,
        "estimator": estimators,
        "controller": controllers,
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


@cache
def model_of(experiments: tuple[Experiment | Merged, ...]) -> type[BaseModel]:
    """The model of the whole configuration. Every section except ``own_schemes`` belongs to an experiment."""
    tree: dict[str, Any] = {}
    for experiment in experiments:
        if isinstance(experiment, Experiment) and (experiment.options is None or experiment.model is not None):
            *above, last = experiment.section.split(".")
            place = tree
            for key in above:
                place = place.setdefault(key, {})
                if not isinstance(place, dict):
                    raise ValueError(
                        f"{experiment.module} declares '{experiment.section}', below the section of another experiment."
                    )
            fields: dict[str, Any] = arguments_of(experiment.function)
            if last in place:
                raise ValueError(
                    f"{experiment.module} declares the section '{experiment.section}', which another experiment has."
                )
            try:
                place[last] = experiment.model or create_model(last, __config__=_STRICT, **fields)
            except PydanticSchemaGenerationError as error:
                raise ValueError(
                    f"{experiment.module}: the type of an argument of '{experiment.function.__name__}' is not one that "
                    f"a configuration can hold: {str(error).splitlines()[0]}"
                ) from None
    places: Any = (OwnSchemes, [])
    return create_model("configuration", __base__=_nested("sections", tree), own_schemes=places)


def _nested(name: str, tree: dict[str, Any]) -> type[BaseModel]:
    fields: dict[str, Any] = {}
    for key, value in tree.items():
        section = _nested(key, value) if isinstance(value, dict) else value
        known = getattr(section, "model_fields", None)
        whole_by_default = known is not None and not any(option.is_required() for option in known.values())
        fields[key] = (section, {} if whole_by_default else ...)
    return create_model(name, __config__=_STRICT, **fields)


#: Expected type in plain words, by the kind of pydantic's error.
_TYPES = {
    "int_type": "a whole number",
    "float_type": "a number",
    "string_type": "a string",
    "list_type": "a list",
    "dict_type": "a mapping of keys",
    "model_type": "a mapping of keys",
}


def _sentence(mistake: Any, model: type[BaseModel]) -> str:
    """A sentence on one mistake that pydantic found, with the key and the expected value."""
    location = [part for part in mistake["loc"] if part != "[key]"]
    place, received = _place(location), mistake["input"]
    match mistake["type"]:
        case "extra_forbidden":
            *above, key = location
            section = _place(above) or "the configuration"
            return f"{section} has no key {key!r}; {did_you_mean(str(key), _keys_of(model, above))}"
        case "missing":
            return f"the configuration lacks '{place}'."
        case "value_error":
            reason = str(mistake["ctx"]["error"])
            return f"{place}: {reason}{'' if reason.endswith(('.', '?')) else '.'}"
        case "list_type" if location[-1] == "schemes":
            expected = "a list, or the word all"
        case kind if kind in _TYPES:
            expected = _TYPES[kind]
        case "too_short" | "too_long":
            bound, many = ("at least", "min_length") if mistake["type"] == "too_short" else ("at most", "max_length")
            return f"{place} must have {bound} {mistake['ctx'][many]} items, not {mistake['ctx']['actual_length']}."
        case _:
            expected = mistake["msg"].removeprefix("Input should be ")
    return f"{place} must be {expected}{'' if isinstance(received, dict | list) else f', not {received!r}'}."


def _place(location: Iterable[Any]) -> str:
    """The dotted key of a place in the configuration; a part that is not a plain name is put in quotation marks."""
    return ".".join(str(part) if re.fullmatch(r"\w+", str(part)) else repr(part) for part in location)


def _keys_of(kind: Any, location: Iterable[Any]) -> list[str]:
    """The keys of the section at a place of the configuration."""
    for key in location:
        kind = _plain(kind)
        if get_origin(kind) in (list, dict):
            kind = get_args(kind)[-1]
        else:
            kind = kind.model_fields[key].annotation if hasattr(kind, "model_fields") else get_type_hints(kind)[key]
    kind = _plain(kind)
    return list(kind.model_fields if hasattr(kind, "model_fields") else get_type_hints(kind))


def _plain(kind: Any) -> Any:
    """A type without its annotations."""
    return get_args(kind)[0] if get_origin(kind) is Annotated else kind


def check_form(model: type[BaseModel], configuration: Any) -> None:
    """Refuse unknown and missing keys, wrong types, unknown names, and numbers out of bounds.

    Raises
    ------
    ValueError
        If the configuration is refused; the message is one sentence that names the key.
    """
    if not isinstance(configuration, Mapping):
        raise ValueError(f"the configuration must be a mapping from sections to options, not {configuration!r}.")
    strange = next(_strange_keys(configuration, ""), None)
    if strange is not None:
        raise ValueError(f"{strange} of the configuration must be a string; put it into quotation marks.")
    try:
        model.model_validate(configuration, context=_registries())
    except ValidationError as mistakes:
        # a misspelt key is reported in place of the missing key that results from it
        first = min(mistakes.errors(), key=lambda mistake: mistake["type"] != "extra_forbidden")
        raise ValueError(_sentence(first, model)) from None


def _strange_keys(section: Any, place: str):
    """Keys that are not strings: YAML reads ``1:`` as a number and ``yes:`` as a boolean."""
    if isinstance(section, Mapping):
        for key, value in section.items():
            if not isinstance(key, str):
                yield f"the key {place}{key!r}"
            yield from _strange_keys(value, f"{place}{key}.")
    elif isinstance(section, list):
        for index, value in enumerate(section):
            yield from _strange_keys(value, f"{place}{index}.")


def check(experiments: Iterable[Experiment | Merged], configuration: Any) -> dict[str, Any]:
    """Check that every experiment can run to its end with a configuration, and return the complete configuration.

    Raises
    ------
    ValueError
        If an experiment cannot run to its end; the message names the key or the dataset.
    """
    declared = tuple(experiments)
    _register_own_schemes(configuration)
    whole = complete(configuration)
    check_form(model_of(declared), whole)
    datasets = set(datasets_of(declared, whole))
    _check_makers(declared, whole)
    for experiment in declared:
        if isinstance(experiment, Merged):
            continue
        for job, options in experiment.jobs(whole).items():
            place = f"{experiment.section}.{job}" if experiment.named_jobs and job else experiment.section
            reason = experiment.check(options, whole)
            if reason is not None:
                raise ValueError(f"{place}.{reason}")
            reads = experiment.reads(options)
            if isinstance(reads, str):
                raise ValueError(f"{experiment.module}: reads must return a list of datasets, not {reads!r}.")
            for name in reads:
                if name not in datasets:
                    raise ValueError(
                        f"{place} reads '{name}', a dataset that this configuration does not make; "
                        f"{did_you_mean(name, sorted(datasets))}"
                    )
    return whole


def register_own(place: str) -> None:
    """Register a user's scheme, ``FILE.py:NAME``, under NAME in this process.

    Raises
    ------
    ValueError
        If there is no such scheme, its name is taken, or one of its attributes is invalid.
    """
    try:
        register_scheme(place.rpartition(":")[2], load(place, (Scheme,)))
    except (TypeError, ValueError) as error:
        raise ValueError(f"own_schemes: {error}") from error


def _register_own_schemes(configuration: Any) -> None:
    """Register the schemes that ``own_schemes`` lists, before the sections that name schemes are read."""
    listed = configuration.get("own_schemes", []) if isinstance(configuration, Mapping) else []
    if not isinstance(listed, list) or not all(isinstance(place, str) for place in listed):
        raise ValueError(f"own_schemes must be a list of FILE.py:NAME, not {listed!r}.")
    for place in listed:
        register_own(place)


def _check_makers(experiments: Iterable[Experiment | Merged], configuration: Mapping) -> None:
    """Refuse a dataset that two experiments make."""
    makers: dict[str, str] = {}
    for experiment in experiments:
        maker = experiment.module if isinstance(experiment, Experiment) else experiment.makes
        for name in datasets_of([experiment], configuration):
            if makers.setdefault(name, maker) is not maker:
                raise ValueError(f"the dataset '{name}' is made by {makers[name]} and by {maker}; rename one of them.")


def datasets_of(experiments: Iterable[Experiment | Merged], configuration: Mapping) -> list[str]:
    """Names of the datasets that a configuration makes and keeps."""
    names: list[str] = []
    for experiment in experiments:
        if isinstance(experiment, Merged):
            names.append(experiment.makes)
        elif experiment.split is None or experiment.along:
            names += [name for name in experiment.makes if not experiment.temporary]
        else:
            names += [f"{name}/{job}" for job in experiment.jobs(configuration) for name in experiment.makes]
    return names
