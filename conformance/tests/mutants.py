"""Mutants of the three example codes, made by rule, and how many of them the kit names.

``python -m conformance.tests.mutants 60`` draws 60 mutants that fail a case, and prints each with its most frequent
cause. A mutant has one mistake in the formulas of an example: a wrong sign, a missing factor or term, a wrong number,
another parameter, or an old value instead of a new one. A mutant is named if one cause explains at least half of its
failures. A cause is a change of the scheme that reproduces all values of the mutant in a case. Mutants that only raise
errors, or that no case finds, are not drawn.
"""

import random
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from conformance import runners
from conformance.command import cases
from conformance.judge import judged

EXAMPLES = Path(__file__).parents[1] / "examples"

#: Start and end of the formulas of each example.
FORMULAS = {
    "newmark.py": ("numbers =", "problem.commit"),
    "newmark.c": ("static double force", 'fprintf(out, "%.17g,%.17g,%.17g,%.17g\\n", t'),
    "reader.js": ("const load", "rows.u.push"),
}

#: Mistakes that are made of a formula: a regular expression and its replacement.
RULES = (
    (r" \+ ", " - "),  # a wrong sign
    (r" - ", " + "),
    (r"(?<=[(=] )-(?=\w)", ""),
    (r"\b(dt|tau|gamma|beta|part|theta|alpha_f|alpha_m|c|k|m|M|C)( @| \*) ", ""),  # a missing factor
    (r"\b(dt|tau) \* ", r"\1 * \1 * "),  # a factor too many
    (r"\b0\.5\b", "0.4"),  # a wrong number
    (r"(?<![\w.])1 - (?=[a-z])", ""),  # a weight of the other end
    (r"\bgamma\b(?=[ )*/])", "beta"),  # another parameter
    (r"\bbeta\b(?=[ )*/])", "gamma"),
    (r"\balpha_m\b(?=[ )*])", "alpha_f"),
    (r"\balpha_f\b(?=[ )*])", "alpha_m"),
    (r"\b(v_new|v_ahead|faster)\b(?= *[-+)])", "v"),  # an old value instead of a new one
    (r"\b(u_ahead|ahead|at)\b(?= *[-+)\]])", "u"),
    (r" [-+] [\w.@*]+( [@*/] [\w.]+)*(?= [-+]|[;,)\n])", ""),  # a missing term
    (r"\bcos\(", "sin("),
    (r"\bt \+ (?=\w)", ""),
)

#: End of the program in JavaScript, which writes the motion instead of judging it.
_WRITES = """
const { problem, scheme, run } = JSON.parse(fs.readFileSync(process.argv[2], "utf-8"));
if (scheme.family !== "newmark" || problem.form !== "linear" || problem.u0.length > 1) process.exit(77);
if (problem.ground || run.sizes) process.exit(77);
const { u, v, a } = newmark({ problem, scheme, run });
const rows = u.map((_, i) => [i * Number(run.dt), u[i], v[i], a[i]].join(","));
fs.writeFileSync(process.argv[3], ["t,u1,v1,a1", ...rows].join("\\n"));
"""


class Mutant(NamedTuple):
    """One change of an example: its file, the changed line before and after, and the changed text."""

    file: str
    before: str
    after: str
    text: str


def mutants(file: str) -> Iterator[Mutant]:
    """All mutants of an example."""
    text = (EXAMPLES / file).read_text(encoding="utf-8")
    start = text.index(FORMULAS[file][0])
    end = text.index(FORMULAS[file][1], start)
    for pattern, new in RULES:
        for match in re.finditer(pattern, text[start:end]):
            begin, stop = start + match.start(), start + match.end()
            changed = match.expand(new)
            first, last = text.rindex("\n", 0, begin) + 1, text.index("\n", stop)
            yield Mutant(
                file,
                text[first:last].strip(),
                (text[first:begin] + changed + text[stop:last]).strip(),
                text[:begin] + changed + text[stop:],
            )


def runner(mutant: Mutant, folder: Path) -> runners.Runner:
    """Runner of a mutant. A program in C is compiled in the folder.

    Raises
    ------
    ValueError
        If the changed text is not a program.
    """
    if mutant.file.endswith(".py"):
        module: Any = ModuleType("mutant")
        exec(mutant.text, module.__dict__)
        return runners.step_runner(module.step)
    file = folder / mutant.file
    if mutant.file.endswith(".js"):
        file.write_text(mutant.text[: mutant.text.index("const test =")] + _WRITES, encoding="utf-8")
        return runners.command_runner(f"node {file} {{case}} {{out}}")
    file.write_text(mutant.text, encoding="utf-8")
    command: list[Any] = ["cc", "-O1", "-o", folder / "mutant", file, "-lm"]
    if subprocess.run(command, capture_output=True).returncode:
        raise ValueError("the program cannot be compiled")
    return runners.command_runner(f"{folder / 'mutant'} {{case}} {{out}}")


def causes(mutant: Mutant, chosen: Sequence[dict[str, Any]], folder: Path) -> Counter[str]:
    """Number of failed cases of a mutant by cause; empty if every case passes or every run raises an error."""
    try:
        run = runner(mutant, folder)
    except (ValueError, SyntaxError):
        return Counter()
    # `where` is empty if the code raises an error or returns numbers that are not finite
    return Counter(
        verdict.cause for verdict in judged(chosen, run) if verdict.verdict in ("differs", "fail") and verdict.where
    )


def drawn(number: int, seed: int, chosen: Sequence[dict[str, Any]], folder: Path) -> Iterator[tuple[Mutant, Counter]]:
    """Mutants that fail, in equal parts of the examples as far as these have so many, and their causes."""
    draw = random.Random(seed)
    lists, left = {file: [*mutants(file)] for file in FORMULAS if _has(file)}, number
    for waiting in lists.values():
        draw.shuffle(waiting)
    while left and any(lists.values()):
        for waiting in lists.values():
            counts = Counter[str]()
            while waiting and left and not counts:
                mutant = waiting.pop()
                if counts := causes(mutant, chosen, folder):
                    left -= 1
                    yield mutant, counts


def _has(file: str) -> bool:
    return shutil.which({"py": sys.executable, "c": "cc", "js": "node"}[file.rpartition(".")[2]]) is not None


def named(counts: Counter[str]) -> bool:
    """Whether one cause explains at least half of the failures, and is known and not a guess about precision."""
    ((cause, count),) = counts.most_common(1)
    guessed = cause == "not known" or cause.startswith("numbers are in single precision")
    return 2 * count >= counts.total() and not guessed


#: Fast cases that together reach every formula of the examples.
QUICK = ("A-", "D-HARM", "E-YIELD", "F-MASS", "G-HARM")


def few() -> list[dict[str, Any]]:
    """Cases for mutants."""
    return [case for case in cases() if case["name"].startswith(QUICK)]


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        total = Counter[bool]()
        for mutant, counts in drawn(int(sys.argv[1]), 1, few(), Path(name)):
            total[named(counts)] += 1
            ((cause, count),) = counts.most_common(1)
            print(f"{mutant.file}: {mutant.before}\n  -> {mutant.after}\n  {cause} ({count} of {counts.total()})")
    print(f"named: {total[True]} of {total.total()}")
