"""Changes of a scheme without a number, which may be the cause of wrong values."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from conformance.compared import Motion
from conformance.problem import Problem
from conformance.schemes import run
from conformance.variants import LATER, VARIANTS

#: Function of a number of steps that returns the motion of a changed scheme.
March = Callable[[int], Motion]


def first_sizes(dt: Any, steps: int) -> Any:
    """Sizes of the first steps: the common size, or the first ones of an array."""
    return dt if np.ndim(dt) == 0 else dt[:steps]


def _march(text: Mapping[str, Any], scheme: Mapping[str, Any], dt: Any, words: Sequence[str]) -> March:
    return lambda steps: run(Problem(text), scheme, first_sizes(dt, steps), steps, words)


def fixed(case: Mapping[str, Any], dt: Any) -> Iterator[tuple[str, str, March]]:
    """Verdict, text and motion of single changes whose values are not in the case."""
    text, scheme = case["problem"], case["scheme"]
    for variant in VARIANTS if "sizes" in case["run"] or "variants" not in case else ():
        if scheme["family"] in variant.families:
            yield variant.verdict, variant.text, _march(text, {**scheme, **variant.change(scheme)}, dt, variant.words)
    for later in LATER:
        if scheme["family"] in later.families:
            yield "fail", later.text, _march(later.problem(text), scheme, dt, later.words)
    for name, output in _OUTPUTS.items():
        yield "fail", name, partial(_output, text, scheme, dt, output)


def twice(case: Mapping[str, Any], dt: Any) -> Iterator[tuple[str, March]]:
    """A wrong start together with each variant, and each alternative together with each mistake."""
    text, scheme = case["problem"], case["scheme"]
    known = [variant for variant in VARIANTS if scheme["family"] in variant.families]
    firsts = [variant for variant in known if variant.verdict == "differs" or set(variant.words) & {"a0 = 0", "no v0"}]
    for first in firsts:
        for second in known:
            if second is not first:
                changed = {**scheme, **first.change(scheme)}
                changed |= second.change(changed)
                yield f"{first.text}, and {second.text}", _march(text, changed, dt, (*first.words, *second.words))


def _late(rows: np.ndarray) -> np.ndarray:
    return np.concatenate([rows[:1], rows[:-1]])


def _early(rows: np.ndarray) -> np.ndarray:
    return np.concatenate([rows[1:], rows[-1:]])


#: Mistakes of the output: functions of u, v and the step sizes (steps, 1) of a motion that has one step more.
_OUTPUTS: dict[str, Callable[..., tuple[np.ndarray, np.ndarray]]] = {
    "values are right but one step late": lambda u, v, dt: (_late(u), _late(v)),
    "values are right but one step early": lambda u, v, dt: (_early(u), _early(v)),
    "the velocity is one step late": lambda u, v, dt: (u, _late(v)),
    "the velocity is one step early": lambda u, v, dt: (u, _early(v)),
    "the velocity is that of half a step before, (u₁ − u₀)/Δt": lambda u, v, dt: (
        u,
        np.concatenate([v[:1], np.diff(u, axis=0) / dt]),
    ),
    "the velocity is that of half a step later, (u₂ − u₁)/Δt": lambda u, v, dt: (
        u,
        np.concatenate([np.diff(u, axis=0) / dt, v[-1:]]),
    ),
    "the displacement is one step late": lambda u, v, dt: (_late(u), v),
    "the displacement is one step early": lambda u, v, dt: (_early(u), v),
}


def _output(text: Mapping[str, Any], scheme: Mapping[str, Any], dt: Any, change: Callable, steps: int) -> Motion:
    """The right motion with a mistake of the output."""
    sizes = np.append(np.broadcast_to(first_sizes(dt, steps), steps), np.max(dt))
    right = run(Problem(text), scheme, sizes, steps + 1)
    return dict(zip("uv", change(right["u"], right["v"], sizes[:, None]), strict=True))
