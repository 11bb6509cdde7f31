"""Random mutants of the code, made by cosmic-ray, and the first test that catches each of them.

``.venv/bin/uv run --no-sync --with cosmic-ray tools/mutants.py 120 1 mutants.csv -m "not pipeline and not exhaustive"``
makes 120 mutants with the seed 1 in a copy of the project. The arguments after the table go to pytest. The tests that
mirror the changed file run first, and all others only if these catch nothing.
"""

import ast
import csv
import os
import random
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.pipeline.pipeline import copied

#: The environment of the project, in which the tests run. cosmic-ray need not be in it.
PYTHON = Path(__file__).parents[1] / ".venv" / "bin" / "python"
#: Packages whose files are changed.
PACKAGES = ("study", "reference")
#: Operators of cosmic-ray that are not used: the first one mostly removes caches, the others need a configuration.
LEFT_OUT = {"core/RemoveDecorator", "core/VariableReplacer", "core/VariableInserter"}
#: Seconds after which a mutant that never ends counts as caught.
LONGEST = 1800


class Mutant(NamedTuple):
    """A file with one changed place."""

    file: Path
    line: int
    operator: str
    text: str


def _annotated(text: str) -> set[int]:
    """Lines with annotations, whose mutants change nothing that is computed."""
    nodes = [getattr(node, name, None) for node in ast.walk(ast.parse(text)) for name in ("annotation", "returns")]
    return {line for node in nodes if node is not None for line in range(node.lineno, node.end_lineno + 1)}


def random_mutant(file: Path, chance: random.Random) -> Mutant | None:
    """One mutant of a file at a random place, or None if there is no such place."""
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator, operator_names

    text = file.read_text(encoding="utf-8")
    tree, annotated, places = get_ast(text), _annotated(text), defaultdict(list)
    operators = {name: get_operator(name)() for name in operator_names() if name not in LEFT_OUT}
    for name, operator in operators.items():
        positions = (place for node in ast_nodes(tree) for place in operator.mutation_positions(node))
        for number, (start, _) in enumerate(positions):
            if start[0] not in annotated:
                places[start].append((name, number))
    if not places:
        return None
    start = chance.choice(sorted(places))
    name, number = chance.choice(places[start])
    return Mutant(file, start[0], name.removeprefix("core/"), mutate_code(text, operators[name], number))


def mutants(project: Path, count: int, seed: int) -> Iterator[Mutant]:
    """Mutants of random files; a file is chosen in proportion to its lines."""
    chance = random.Random(seed)
    files = sorted(path for package in PACKAGES for path in (project / package).rglob("*.py"))
    lengths = [len(path.read_text(encoding="utf-8").splitlines()) for path in files]
    while count:
        (file,) = chance.choices(files, lengths)
        if mutant := random_mutant(file, chance):
            count -= 1
            yield mutant


def mirror(file: Path) -> str:
    """Folder of the tests of a file below the project: ``tests/scheme`` for ``study/scheme/newmark.py``."""
    package, *rooms = file.parts[:-1]
    return "/".join(["tests", *rooms[:1]] if package == "study" else ["tests", package])


def caught_by(project: Path, *arguments: str) -> str:
    """First test that fails, or an empty string."""
    command = [str(PYTHON), "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *arguments]
    environment = os.environ | {"PYTHONPATH": str(project), "XDG_CACHE_HOME": str(project / "cache")}
    try:
        process = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return "a test that does not end"
    if process.returncode == 0:
        return ""
    failed = [line.split()[1] for line in process.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return (failed or ["the start of pytest"])[0]


def main(count: str, seed: str, table: str, *arguments: str) -> None:
    with TemporaryDirectory() as folder, open(table, "w", newline="", encoding="utf-8") as file:
        rows, project = csv.writer(file), copied(Path(folder))
        rows.writerow(["file", "line", "operator", "caught by", "seconds"])
        for mutant in mutants(project, int(count), int(seed)):
            name, text, start = mutant.file.relative_to(project), mutant.file.read_text(), time.monotonic()
            mutant.file.write_text(mutant.text)
            caught = caught_by(project, mirror(name), *arguments) or caught_by(project, *arguments)
            mutant.file.write_text(text)
            rows.writerow([name, mutant.line, mutant.operator, caught, round(time.monotonic() - start)])
            file.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
