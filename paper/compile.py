"""Compile the manuscript: ``python -m paper.compile RESULTS OUTPUT``."""

import sys
from pathlib import Path

import typst


def main(results: Path, output: Path) -> None:
    """Compile ``manuscript.typ`` with the numbers, tables and figures of a results folder.

    Typst may read below its root only; as results may lie anywhere, that is the root of the file system. The fixed
    time stamp makes the same inputs give the same bytes.
    """
    manuscript = Path(__file__).parent / "manuscript.typ"
    typst.compile(
        str(manuscript),
        output=str(output),
        root="/",
        sys_inputs={"results": str(results.resolve())},
        ignore_system_fonts=True,
        timestamp=0,
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
