"""Functions of tests that may be marked as slow: each line that they run is also run by a function without the mark.

A run of ``.venv/bin/pytest -n auto -m "not pipeline and not exhaustive" tests study --junitxml=results/tests.xml
--cov=study --cov=reference --cov=paper --cov=docs --cov-context=test`` measures times and lines, and
``.venv/bin/python tools/slow_tests.py results/tests.xml`` lists the functions, the slowest first, with their seconds.
"""

import sqlite3
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter, defaultdict
from pathlib import Path

from coverage.numbits import numbits_to_nums

#: Seconds from which on a function is slow.
SLOW = 1.0


def times(report: Path) -> dict[str, float]:
    """Seconds of each function of tests, from a report of pytest."""
    seconds = defaultdict[str, float](float)
    for case in ElementTree.parse(report).iter("testcase"):
        file, name = case.attrib["classname"].replace(".", "/"), case.attrib["name"].partition("[")[0]
        seconds[f"{file}.py::{name}"] += float(case.attrib["time"])
    return seconds


def lines(data: Path) -> dict[str, set[tuple[int, int]]]:
    """Lines that each function of tests runs, as numbers of file and line."""
    by_function = defaultdict[str, set[tuple[int, int]]](set)
    query = (
        "select context, file_id, numbits from line_bits join context on context.id = context_id where context != ''"
    )
    for context, file, numbers in sqlite3.connect(data).execute(query):
        by_function[context.partition("|")[0].partition("[")[0]] |= {(file, line) for line in numbits_to_nums(numbers)}
    return by_function


def slow(seconds: dict[str, float], lines_of: dict[str, set[tuple[int, int]]]) -> list[str]:
    """The slowest functions, as long as another function runs each of their lines."""
    runs = Counter(line for code_lines in lines_of.values() for line in code_lines)
    chosen = list[str]()
    for name, time in sorted(seconds.items(), key=lambda item: item[1], reverse=True):
        code_lines = lines_of.get(name, set())  # empty if another process runs the code
        if time >= SLOW and code_lines and name.startswith("tests/") and all(runs[line] > 1 for line in code_lines):
            runs.subtract(code_lines)
            chosen.append(name)
    return chosen


if __name__ == "__main__":
    measured = times(Path(sys.argv[1]))
    for name in slow(measured, lines(Path(".coverage"))):
        print(f"{measured[name]:6.1f} {name}")
