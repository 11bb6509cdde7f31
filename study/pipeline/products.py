"""Whether finished products are still what a run of the pipeline has made.

Nothing reads a PDF or a page again, and a table or dataset that somebody else has written may look like one of ours. So
a run notes size, date and SHA-256 of its products when it ends (``python study/pipeline/products.py note``, with the
names on the standard input), and the next one puts aside what has changed since (``... changed SINCE``, which prints
sentences). It is a script that imports nothing of the study, and so starts in a tenth of a second.
"""

import hashlib
import json
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

#: The notes of the last run.
NOTES = Path(".snakemake", "products.json")

#: What is known of a product: size in bytes, date in nanoseconds, SHA-256.
Known = tuple[int, int, str]


def _sum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _noted() -> dict[str, Known]:
    try:
        return {name: (size, date, of) for name, (size, date, of) in json.loads(NOTES.read_text()).items()}
    except (OSError, ValueError, AttributeError, TypeError):  # no run has ended yet, or one was killed as it wrote
        return {}


def _known(path: Path, noted: Known | None) -> Known:
    """What there is to know of a file; it is read only if size or date are not those that were noted."""
    state = path.stat()
    if noted is not None and noted[:2] == (state.st_size, state.st_mtime_ns):
        return noted
    return state.st_size, state.st_mtime_ns, _sum(path)


def note(products: Iterable[str]) -> None:
    """Note the products that are there."""
    noted = _noted()
    found = {name: _known(Path(name), noted.get(name)) for name in products if Path(name).is_file()}
    if found != noted:
        NOTES.parent.mkdir(parents=True, exist_ok=True)
        unfinished = NOTES.with_suffix(f".{os.getpid()}")
        unfinished.write_text(json.dumps(found))
        unfinished.replace(NOTES)


def changed(since: float) -> Iterator[str]:
    """Put aside products that are not those of the last run, with a sentence for each.

    Parameters
    ----------
    since
        Time in seconds from which on a run that has died may have made what has changed.
    """
    for name, noted in _noted().items():
        path = Path(name)
        if path.is_symlink() or not path.exists() or path.stat().st_mtime >= since:
            continue
        if path.is_dir() or _known(path, noted)[2] != noted[2]:
            path.replace(f"{name}.unusable")
            yield f"'{name}' is no longer what was made; it is kept as '{name}.unusable', and is made again."


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["note"]:
            note(sys.stdin.read().splitlines())
        case ["changed", since]:
            print(*changed(float(since)), sep="\n", end="")
        case _:
            raise SystemExit("usage: python study/pipeline/products.py note|changed SINCE")
