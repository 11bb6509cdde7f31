"""Whether finished products are still what the pipeline has made.

Nothing reads a PDF or a page again, and a table or dataset that somebody else has written may look like one of ours. So
every job notes the checksums of its products as soon as it has made them, as ``cksum`` prints them, and the next run
puts aside the products that have changed since:

``python study/pipeline/products.py changed``
    puts them aside, with a sentence for each.
``python study/pipeline/products.py aside NAME...``
    puts aside products that a job could not use.

It is a script that imports nothing of the study, and so starts in a tenth of a second.
"""

import os
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

#: Folder of the notes, one of each job.
NOTES = Path(".snakemake", "products")


def _noted(note: Path) -> dict[Path, str]:
    """The lines of a note by the product; that of a job that was killed as it wrote may be cut."""
    parts = (line.split(" ", 2) for line in note.read_text(errors="replace").splitlines())
    return {Path(part[2]): " ".join(part) for part in parts if len(part) == 3}


def _changed_since(path: Path, note: Path) -> bool:
    """Whether a product was touched after its note was made, whatever date it bears."""
    return path.exists() and not path.is_symlink() and path.stat().st_ctime_ns > note.stat().st_mtime_ns


def _sums(paths: Iterable[Path]) -> set[str]:
    """What ``cksum`` prints of the files that it can read."""
    files = [str(path) for path in paths if path.is_file()]
    return set(subprocess.run(["cksum", "--", *files], capture_output=True, text=True).stdout.splitlines())


def put_aside(path: Path) -> Path:
    """Rename a product to a free name.

    Raises
    ------
    SystemExit
        If it cannot be renamed.
    """
    kept, number = path.with_name(f"{path.name}.unusable"), 1
    while os.path.lexists(kept):
        number += 1
        kept = path.with_name(f"{path.name}.{number}.unusable")
    try:
        return path.rename(kept)
    except OSError as error:
        raise SystemExit(
            f"'{path}' cannot be used, nor be renamed to '{kept}': {error.strerror}; "
            "make its folder writable, and call again."
        ) from None


def changed() -> Iterator[str]:
    """Put aside products that are not those that were made, with a sentence for each."""
    now = time.time_ns()
    noted = {note: _noted(note) for note in NOTES.glob("*")}
    touched = {note: [path for path in lines if _changed_since(path, note)] for note, lines in noted.items()}
    found = _sums(path for paths in touched.values() for path in paths) if any(touched.values()) else set()
    for note, paths in touched.items():
        for path in paths:
            if noted[note][path] not in found:
                yield f"'{path}' is no longer what was made; it is kept as '{put_aside(path)}', and is made again."
        if paths:
            os.utime(note, ns=(now, now))  # what was found to be the same is not read again


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["changed"]:
            print(*changed(), sep="\n", end="")
        case ["aside", *names]:
            for name in names:
                print(f"'{name}' is kept as '{put_aside(Path(name))}', and the next call makes it again.")
        case _:
            raise SystemExit("usage: python study/pipeline/products.py changed|aside NAME...")
