"""All keys of the configuration as a page: ``python -m pipeline.keys > config/README.md``."""

from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.configuration import model_of
from study.declaration.experiment import Experiment, discover

_TYPES = {"integer": "whole number", "number": "number", "string": "string", "boolean": "true or false"}
_BOUNDS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
_HEAD = """# Configuration

`study.yaml` is the short study. `small.yaml` and `full.yaml` override some of its keys and give the small and the full
study. `environment.yaml` lists the packages for `snakemake --sdm conda`. A file of your own, `--configfile FILE`,
overrides keys of `study.yaml` and holds only the differences. A list replaces a whole list. Other keys and values are
refused before any work.

`NAME` stands for a name of your choice and `[]` for each item of a list. The word `all` in place of a list of schemes
stands for all schemes. `own_schemes` lists schemes in your own files as `FILE.py:NAME`.
`python -m pipeline.keys` prints this page from the declarations of the experiments."""


def _value(kind: Mapping[str, Any]) -> str:
    """Type and bounds of a key, in a phrase."""
    if "enum" in kind or "const" in kind:
        return " or ".join(f"`{value}`" for value in kind.get("enum", [kind.get("const")]))
    if "anyOf" in kind:
        return " or ".join(map(_value, kind["anyOf"]))
    if kind.get("type") == "array":
        return "list" if "$ref" in kind["items"] else f"list: {_value(kind['items'])}"
    bounds = ", ".join(f"{sign} {kind[name]:.12g}" for name, sign in _BOUNDS.items() if name in kind)
    return f"{_TYPES[kind['type']]} {bounds}".rstrip()


def _rows(key: str, kind: Mapping[str, Any], needed: bool, schema: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Rows of the table for a key and the keys below it: name, type, and whether the key may be left out."""
    kind = schema["$defs"][kind["$ref"].rpartition("/")[2]] if "$ref" in kind else kind
    if "properties" in kind:
        for name, kind_below in kind["properties"].items():
            yield from _rows(f"{key}.{name}", kind_below, needed and name in kind.get("required", []), schema)
    elif isinstance(below := kind.get("additionalProperties"), Mapping):
        yield from _rows(f"{key}.NAME", below, needed, schema)
    else:
        yield key, _value(kind), "" if needed and "default" not in kind else "may be left out"
        if "$ref" in (items := kind.get("items", {})):
            yield from _rows(f"{key}[]", items, needed, schema)


def page() -> str:
    """The page."""
    declared = tuple(discover())
    schema = model_of(declared).model_json_schema()
    parts = [_HEAD]
    for section, kind in sorted(schema["properties"].items()):
        makers = [
            maker for maker in declared if isinstance(maker, Experiment) and maker.section.split(".")[0] == section
        ]
        said = dict.fromkeys(str(maker.function.__doc__).splitlines()[0] for maker in makers)
        rows = [f"| `{key}` | {value} | {left} |" for key, value, left in _rows(section, kind, True, schema)]
        head = ["| key | value | optional |", "|---|---|---|"]
        parts.append("\n".join([f"## {section}", "", *said, *([""] if said else []), *head, *rows]))
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    print(page(), end="")
