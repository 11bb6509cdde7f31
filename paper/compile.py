"""Compile the texts: ``python -m paper.compile RESULTS FOLDER`` writes the PDF of each, and README.md."""

import sys
from pathlib import Path

import typst

from paper.manuscript import TEXTS, check_uses, listing
from study.io import one_sentence, read, write


@one_sentence()
def main(results: Path, folder: Path) -> None:
    """Compile article, supplement and replication with the numbers, tables and figures of a folder of results.

    Typst reads only below its root. Results may lie anywhere, so the root is the root of the file system. With the
    fixed time stamp the same inputs give the same bytes. README.md lists the files of figures and tables. Facts of the
    text that the data contradict are printed; their sentences are omitted.

    Raises
    ------
    SystemExit
        If a text uses a number, figure or table that the results lack, or if a file of the results is damaged. The
        message on a missing number, figure or table has the line of the text.
    """
    numbers = read(results / "numbers.json")
    for included in (*results.glob("figures/*.pdf"), *results.glob("tables/*.csv")):
        read(included)
    for text in TEXTS:
        check_uses(text, results)
    contradicted = [name for name, value in numbers.items() if value is False]
    if contradicted:
        print(f"The text omits statements that these results do not support: {', '.join(contradicted)}.")
    for text in TEXTS:
        pdf = typst.compile(
            str(text),
            root="/",
            sys_inputs={"results": str(results.resolve())},
            ignore_system_fonts=True,
            timestamp=0,
        )
        write(pdf, folder / f"{text.stem}.pdf")
    write(listing(), folder / "README.md")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
