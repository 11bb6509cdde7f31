"""Compile the manuscript: ``python -m paper.compile RESULTS OUTPUT``."""

import sys
from pathlib import Path

import typst

from paper.data import check_included
from paper.manuscript import TEXT, check_uses, made_in
from paper.writing import write


def main(results: Path, output: Path) -> None:
    """Compile ``manuscript.typ`` with the numbers, tables and figures of a folder of results.

    Typst reads only below its root. Results may lie anywhere, so the root is that of the file system. The fixed time
    stamp makes the same inputs give the same bytes.

    Raises
    ------
    SystemExit
        If the text uses a number, figure or table that the results lack, in which case the message has the line of the
        text, or one of them is damaged.
    """
    for file in (results / "numbers.json", *results.glob("figures/*.pdf"), *results.glob("tables/*.csv")):
        check_included(file)
    try:
        check_uses(TEXT.read_text(encoding="utf-8"), made_in(results))
    except ValueError as error:
        raise SystemExit(str(error)) from None
    pdf = typst.compile(
        str(TEXT),
        root="/",
        sys_inputs={"results": str(results.resolve())},
        ignore_system_fonts=True,
        timestamp=0,
    )
    write(output, pdf)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
