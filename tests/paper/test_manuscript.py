"""The text of the manuscript and what is made for it."""

import ast
import inspect
import re

import pytest

from paper.claims.ledger import OURS
from paper.manuscript import TEXT, check_uses, uses
from paper.products import discover

SOURCE = """
// n.commented picture("commented")
Of #n.cells cells #if int(n.shown) < 3 [#n.at("drift_20.5")], one of them. As in-between n. is.
#wide(picture("atlas", width: 9%), [Text.])
#let rows = table-of("orders").first()
"""


def test_what_a_text_uses():
    assert uses(SOURCE) == {
        "number": {"cells": 3, "shown": 3, "drift_20.5": 3},
        "figure": {"atlas": 4},
        "table": {"orders": 5},
    }


@pytest.mark.parametrize("kind, name, line", [("number", "shown", 3), ("figure", "atlas", 4), ("table", "orders", 5)])
def test_what_is_missing_is_named_with_its_line(kind, name, line):
    there = {kind: set(names) for kind, names in uses(SOURCE).items()}
    check_uses(SOURCE, there)
    there[kind].remove(name)
    with pytest.raises(ValueError, match=rf"manuscript\.typ, line {line}: there is no {kind} '{name}' in the results"):
        check_uses(SOURCE, there)


@pytest.mark.parametrize("kind", ["figure", "table"])
def test_the_text_uses_what_is_declared_and_nothing_else(kind):
    declared = {product.name for product in discover() if product.kind == kind}
    assert declared == set(uses(TEXT.read_text())[kind])


def _pattern(node):
    """A pattern of the keys that an expression gives, or nothing if it is no key."""
    if isinstance(node, ast.Constant):
        return re.escape(node.value) if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        return "".join(re.escape(str(part.value)) if isinstance(part, ast.Constant) else ".+" for part in node.values)
    return "|".join(["claims", *OURS.values()]) if isinstance(node, ast.Name) and node.id == "prefix" else None


def _keys(function):
    """Patterns of the keys in what a function returns, and in the mappings that it returns by name."""
    nodes = list(ast.walk(ast.parse(inspect.getsource(function))))
    # a mapping among the arguments of a call selects from a dataset
    arguments = {
        id(part) for call in nodes if isinstance(call, ast.Call) for one in call.args for part in ast.walk(one)
    }
    returned = [node.value for node in nodes if isinstance(node, ast.Return)]
    parts = [part for value in returned for part in ast.walk(value) if id(part) not in arguments]
    names = {part.id for part in parts if isinstance(part, ast.Name)}
    keys, built = [], list(returned)
    for node in nodes:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            if isinstance(target, ast.Name) and target.id in names and hasattr(node, "value"):
                built.append(node.value)
            if isinstance(target, ast.Subscript) and getattr(target.value, "id", None) in names:
                keys.append(target.slice)
    for display in (part for value in built for part in ast.walk(value) if id(part) not in arguments):
        keys += display.keys if isinstance(display, ast.Dict) else []
        keys += [display.key] if isinstance(display, ast.DictComp) else []
    return {pattern for key in keys if key is not None and (pattern := _pattern(key))}


@pytest.mark.parametrize("product", [p for p in discover(["numbers"]) if p.kind == "numbers"], ids=lambda p: p.name)
def test_every_number_is_used(product):
    used = uses(TEXT.read_text())["number"]
    keys = _keys(product.function)
    assert keys
    unused = {key for key in keys if not any(re.fullmatch(key, name) for name in used)}
    assert not unused
