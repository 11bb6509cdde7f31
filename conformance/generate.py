"""Make all cases: ``python -m conformance.generate`` computes them with 50 digits and writes ``cases/*.json``.

A case is a problem and a scheme of the tables in ``contents.py``. It holds the values of the scheme. It also holds the
values of alternatives and mistakes, which ``variants.py`` defines, if they differ from the values of the scheme.
The derivatives of the values with respect to the parameters of the scheme identify a slightly wrong parameter.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mpmath import mp

from conformance.contents import ORDERS, PROBLEMS, SCHEMES, Entry
from conformance.problem import FLOAT, Problem
from conformance.schemes import run
from conformance.variants import UNEQUAL, VARIANTS, WITHOUT_ACCELERATION

CASES = Path(__file__).parent / "cases"

#: Numbers of decimal digits: DIGITS of the arithmetic, EXPECTED of the expected values, and STORED of the slopes and of
#: the values of variants.
DIGITS, EXPECTED, STORED = 50, 17, 12

#: SAME is the smallest tolerance and LOOSE the largest, relative to the largest value of a quantity. In between, the
#: tolerance is ROUND_OFFS times the observed round-off.
SAME, ROUND_OFFS, LOOSE = 1e-9, 100, 1e-6

#: A variant is stored only if it differs from the expected values and from every stored variant by more than DISTINCT
#: times the tolerance. It is omitted as unstable if it exceeds UNSTABLE times the scheme's largest value or energy.
DISTINCT, UNSTABLE = 100, 1e6


def _march(entry: Entry, scheme: Mapping[str, str], words=(), numbers=mp, dt=None, steps=None) -> dict[str, np.ndarray]:
    sizes = [numbers.mpf(text) for text in entry.sizes]
    size = sizes or numbers.mpf(dt or entry.dt)
    return run(Problem(entry.problem, numbers), scheme, size, steps or len(sizes) or entry.steps, words)


def _decimal(value: Any, digits: int) -> str:
    return mp.nstr(mp.mpf(value), digits, min_fixed=-4, max_fixed=8)


def _quantities(entry: Entry, scheme: Mapping[str, str]) -> list[tuple[str, int]]:
    """Quantity and unknown of every list of expected values; accelerations are last."""
    names = "uv" if scheme["family"] in WITHOUT_ACCELERATION else "uva"
    return [(name, unknown) for name in names for unknown in range(len(entry.problem["u0"]))]


def _identical(entry: Entry, scheme: Mapping[str, str]) -> list[dict]:
    """Expected values and tolerance of each quantity of each unknown."""
    exact, double = _march(entry, scheme), _march(entry, scheme, numbers=FLOAT)
    expected = []
    for name, unknown in _quantities(entry, scheme):
        exact_values = exact[name][:, unknown]
        scale = float(max(abs(exact_values)))
        # round-off of the same formulas in double precision
        round_off = float(max(abs(exact_values - double[name][:, unknown])))
        tolerance = max(SAME * scale, ROUND_OFFS * round_off)
        if tolerance > LOOSE * scale:
            raise ArithmeticError(f"{entry.name}, {scheme}: round-off grows too much; make fewer steps.")
        values = [_decimal(exact_values[step], EXPECTED) for step in entry.at]
        expected.append(
            {
                "kind": "identical",
                "quantity": name,
                "unknown": unknown,
                "at": list(entry.at),
                "values": values,
                "tolerance": f"{tolerance:.2e}",
                "scale": f"{scale:.6e}",
            }
        )
    return expected


def _values(entry: Entry, motion: Mapping[str, np.ndarray], expected: list[dict]) -> list[np.ndarray]:
    """Displacements and velocities of a run, in the order of the expected values."""
    return [motion[item["quantity"]][list(entry.at), item["unknown"]] for item in expected if item["quantity"] != "a"]


def _differ(first: list[np.ndarray], second: list[np.ndarray], expected: list[dict]) -> bool:
    return any(
        max(abs(a - b)) > DISTINCT * float(item["tolerance"])
        for a, b, item in zip(first, second, expected, strict=False)
    )


def _variants(entry: Entry, scheme: Mapping[str, str], expected: list[dict]) -> Iterator[dict]:
    """Alternatives and mistakes that this case distinguishes, each with its values."""
    seen = [_values(entry, _march(entry, scheme), expected)]
    for variant in UNEQUAL if entry.sizes else VARIANTS:
        if scheme["family"] not in variant.families:
            continue
        changed = {**scheme, **variant.change(scheme)}
        try:
            values = _values(entry, _march(entry, changed, variant.words), expected)
        except (ArithmeticError, OverflowError):  # an iteration that does not converge gives no values
            continue
        stable = all(max(abs(a)) <= UNSTABLE * float(item["scale"]) for a, item in zip(values, expected, strict=False))
        if stable and all(_differ(values, other, expected) for other in seen):
            seen.append(values)
            yield {"verdict": variant.verdict, "text": variant.text, "values": _stored(values)}


def _slopes(entry: Entry, scheme: Mapping[str, str], expected: list[dict]) -> Iterator[dict]:
    """Derivatives of the values with respect to the parameters of the scheme, and to factors of Δt and of the mass."""
    values = _values(entry, _march(entry, scheme), expected)
    little = mp.mpf(10) ** (-DIGITS // 2)
    for name in [*(name for name in scheme if name not in ("family", "start")), "factor of dt", "factor of the mass"]:
        if name == "factor of dt":
            motion = _march(entry, scheme, dt=mp.mpf(entry.dt) * (1 + little))
        elif name == "factor of the mass":
            mass = [[mp.mpf(number) * (1 + little) for number in row] for row in entry.problem["mass"]]
            motion = _march(entry._replace(problem={**entry.problem, "mass": mass}), scheme)
        else:
            motion = _march(entry, {**scheme, name: mp.mpf(scheme[name]) + little})
        slopes = [(a - b) / little for a, b in zip(_values(entry, motion, expected), values, strict=True)]
        if any(max(abs(slope)) > 0 for slope in slopes):
            yield {"number": name, "slopes": _stored(slopes)}


def _stored(values: list[np.ndarray]) -> list[list[str]]:
    return [[_decimal(value, STORED) for value in row] for row in values]


def _bound(entry: Entry, scheme: Mapping[str, str]) -> list[dict]:
    """Limit of E/E(0): 1.05 times the largest value in runs of the scheme and of its stable alternatives."""
    problem, largest = Problem(entry.problem), []
    alternatives = [
        variant for variant in VARIANTS if variant.verdict == "differs" and scheme["family"] in variant.families
    ]
    for changed, words in [
        (scheme, ()),
        *(({**scheme, **variant.change(scheme)}, variant.words) for variant in alternatives),
    ]:
        motion = _march(entry, changed, words, FLOAT)
        energies = [problem.energy(u, v) for u, v in zip(motion["u"], motion["v"], strict=True)]
        largest.append(max(energies) / energies[0])
    limit = 1.05 * max(ratio for ratio in largest if ratio <= UNSTABLE * largest[0])
    return [{"kind": "bound", "quantity": "energy", "limit": f"{limit:.4g}"}]


def exact(problem: Mapping[str, Any], end: str) -> Any:
    """Exact displacement of a problem with one unknown at the time ``end``, by Taylor series."""
    equation = Problem(problem, mp)

    def slope(t, y):
        u, v = (np.array([value], dtype=object) for value in y)
        return [v[0], ((equation.load(t) - equation.damping @ v - equation.force(u)) / equation.mass[0, 0])[0]]

    with mp.workdps(25):
        return mp.odefun(slope, 0, [equation.u0[0], equation.v0[0]])(mp.mpf(end))[0]


def _order(entry: Entry, scheme: Mapping[str, str], end: Any) -> list[dict]:
    """Exact displacement at the end, and the order of convergence that the formulas show over four step sizes."""
    errors = []
    for part in (1, 2, 4, 8):
        motion = _march(entry, scheme, dt=mp.mpf(entry.dt) / part, steps=entry.steps * part)
        errors.append(abs(motion["u"][-1, 0] - end))
    slope = float(np.polyfit([0, 1, 2, 3], [-float(mp.log(error, 2)) for error in errors], 1)[0])
    if abs(slope - round(slope)) > 0.08:
        raise ArithmeticError(
            f"{entry.name}, {scheme}: the slope {slope:.3f} is not yet an order; make the steps smaller."
        )
    value = _decimal(end, EXPECTED)
    return [
        {"kind": "order", "quantity": "u", "unknown": 0, "value": value, "order": str(round(slope)), "tolerance": "0.1"}
    ]


def all_cases() -> Iterator[dict]:
    """All cases, one after another."""
    ends = {entry.name: exact(entry.problem, str(mp.mpf(entry.dt) * entry.steps)) for entry in ORDERS}
    for entry in PROBLEMS:
        for code, (title, scheme) in SCHEMES.items():
            if entry.schemes is None or code in entry.schemes:
                yield case(entry, code, title, scheme, ends.get(entry.name))


def case(entry: Entry, code: str, title: str, scheme: Mapping[str, str], end: Any = None) -> dict:
    """The case of a problem and a scheme as a dictionary."""
    steps = {"sizes": list(entry.sizes)} if entry.sizes else {"dt": entry.dt, "steps": entry.steps}
    header = {
        "name": f"{entry.name}-{code}",
        "version": entry.version,
        "title": f"{title}: {entry.title}",
        "why": entry.why,
        "source": "exact",
        "tags": [entry.name[0], scheme["family"], entry.problem["form"], *entry.tags],
        "problem": entry.problem,
        "scheme": scheme,
        "run": {**steps, "newton_tolerance": "1e-12"},
    }
    if entry.kind == "order":
        return {**header, "expect": _order(entry, scheme, end)}
    if entry.kind == "bound":
        return {**header, "expect": _bound(entry, scheme)}
    expected = _identical(entry, scheme)
    variants = list(_variants(entry, scheme, expected))
    slopes = [] if entry.sizes else list(_slopes(entry, scheme, expected))
    return {**header, "expect": expected, "variants": variants, "slopes": slopes}


def written(content: Mapping[str, Any]) -> str:
    """A case as JSON text, with a line for each part and for each item of a list of dictionaries."""
    return "{\n" + ",\n".join(f" {json.dumps(key)}: {_lines(value)}" for key, value in content.items()) + "\n}\n"


def _lines(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(f"  {json.dumps(item, ensure_ascii=False)}" for item in value) + "\n ]"
    return json.dumps(value, ensure_ascii=False)


def main() -> None:
    """Write all cases, and remove the files of cases that are no longer made."""
    mp.dps = DIGITS
    texts = {f"{content['name']}.json": written(content) for content in all_cases()}
    CASES.mkdir(exist_ok=True)
    for old in CASES.glob("*.json"):
        if old.name not in texts:
            old.unlink()
    for name, text in texts.items():
        (CASES / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
