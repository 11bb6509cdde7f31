"""``python -m paper.latex RESULTS FOLDER`` writes article and supplement as LaTeX sources with all that they include.

Pandoc reads the texts as they are, with a layout of its own. What journals expect of a source and pandoc does not write
is added on pandoc's tree of the document: numbered equations, labels of figures, tables and headings, references to
them by kind, and widths of columns. The sources compile with pdfLaTeX.
"""

import json
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pypandoc

from paper.latex.symbols import in_latex
from paper.manuscript import TEXTS, check_uses, made_in
from paper.writing import write

_HERE = Path(__file__).parent
_BIBLIOGRAPHY = TEXTS[0].parent.parent / "references.bib"
#: Words before a reference, by the kind of what it refers to.
_WORDS = {"Figure": "Figure~", "Table": "Table~", "Header": "Section~", "Math": ""}
#: Characters of a line of a table; wider tables get columns in proportion to their texts, of at most as many as these.
_LINE, _COLUMN = 90, 40

Node = dict[str, Any]


def _nodes(part: Any) -> Iterator[Node]:
    """All nodes of a tree, parents first."""
    if isinstance(part, dict):
        if "t" in part:
            yield part
        part = list(part.values())
    if isinstance(part, list):
        for one in part:
            yield from _nodes(one)


def _label(node: Node) -> str:
    """The label of an empty span; empty for any other node."""
    return node["c"][0][0] if node["t"] == "Span" and not node["c"][1] else ""


def _attach_labels(blocks: list[Node], kinds: dict[str, str]) -> list[Node]:
    """Blocks with the labels that follow them; equations become environments."""
    kept: list[Node] = []
    for block in blocks:
        label = _label(block["c"][0]) if block["t"] in ("Para", "Plain") else ""
        if label and kept:
            owner = kept[-1]
            kinds[label] = owner["t"]
            (owner["c"][1] if owner["t"] == "Header" else owner["c"][0])[0] = label
            del block["c"][:2]  # with the space after it
            if not block["c"]:
                continue
        if block["t"] == "Para":
            _attach_to_equations(block["c"], kinds)
        kept.append(block)
    return kept


def _attach_to_equations(inlines: list[Node], kinds: dict[str, str]) -> None:
    for place in range(len(inlines) - 1, -1, -1):
        node = inlines[place]
        if node["t"] == "Math" and node["c"][0]["t"] == "DisplayMath":
            after = place + 1
            while after < len(inlines) and inlines[after]["t"] in ("SoftBreak", "Space"):
                after += 1
            label = _label(inlines[after]) if after < len(inlines) else ""
            body = node["c"][1]
            if label:
                kinds[label] = "Math"
                del inlines[place + 1 : after + 1]
                body = f"\\label{{{label}}}\n{body}"
            inlines[place] = _raw(f"\\begin{{equation}}\n{body}\n\\end{{equation}}")


def _raw(latex: str) -> Node:
    return {"t": "RawInline", "c": ["latex", latex]}


def _refer(tree: Any, kinds: dict[str, str]) -> None:
    """Turn links to labels into references by kind."""
    for node in _nodes(tree):
        if node["t"] == "Link" and node["c"][2][0].removeprefix("#") in kinds:
            label = node["c"][2][0].removeprefix("#")
            reference = f"\\ref{{{label}}}" if kinds[label] != "Math" else f"\\eqref{{{label}}}"
            node.update(_raw(_WORDS[kinds[label]] + reference))


def _place_images(tree: Any) -> None:
    """Let images stand where the source has them, beside it."""
    for node in _nodes(tree):
        if node["t"] == "Image":
            node["c"][2][0] = f"figures/{Path(node['c'][2][0]).name}"


def _text(part: Any) -> str:
    return "".join(
        " " if node["t"] == "Space" else node.get("c", "") for node in _nodes(part) if node["t"] in ("Str", "Space")
    )


def _widen(blocks: list[Node]) -> None:
    """Give the columns of wide tables widths in proportion to their longest texts."""
    for table in (block for block in _nodes(blocks) if block["t"] == "Table"):
        rows = [row for part in (table["c"][3][1], *(body[3] for body in table["c"][4])) for row in part]
        texts = [[_text(row[1][k]) for row in rows] for k in range(len(table["c"][2]))]
        if sum(max(map(len, column)) for column in texts) <= _LINE:
            continue
        longest_words = [max(len(word) for text in column for word in (text.split() or [""])) for column in texts]
        lengths = [
            max(word, min(_COLUMN, max(map(len, column)))) + 2
            for word, column in zip(longest_words, texts, strict=True)
        ]
        for column, length in zip(table["c"][2], lengths, strict=True):
            column[1] = {"t": "ColWidth", "c": length / sum(lengths)}


def _latex(document: Node, blocks: list[Node]) -> str:
    text = json.dumps(document | {"blocks": blocks})
    return in_latex(pypandoc.convert_text(text, "latex", format="json", extra_args=["--natbib", "--wrap=preserve"]))


def converted(folder: Path, name: str) -> str:
    """The LaTeX source of a text in a folder that holds it with its layout, numbers and tables.

    Raises
    ------
    ValueError
        If the text has a character that LaTeX would not print.
    """
    document = json.loads(pypandoc.convert_file(str(folder / name), "json", format="typst"))
    kinds: dict[str, str] = {}
    blocks = _attach_labels(document["blocks"], kinds)
    _refer(blocks, kinds)
    _place_images(blocks)
    _widen(blocks)
    start = next(place for place, block in enumerate(blocks) if block["t"] == "Header")
    title, subtitle, authors = (_latex(document, [block]).strip() for block in blocks[:3])
    template = (_HERE / "template.tex").read_text()
    for key, value in {
        "TITLE": title,
        "SUBTITLE": subtitle,
        "AUTHORS": authors,
        # LaTeX prints the heading itself
        "ABSTRACT": _latex(document, blocks[3:start]).removeprefix("\\textbf{Abstract.} "),
        "BODY": _latex(document, blocks[start:]),
        "LETTER": "S" if name.startswith("supplement") else "",
    }.items():
        template = template.replace(f"@{key}@", value)
    return template


def main(results: Path, output: Path) -> None:
    """Write the sources, their bibliography and their figures into a folder.

    Raises
    ------
    SystemExit
        If a text uses what the results lack, or has a character that LaTeX would not print.
    """
    (output / "figures").mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder, "paper", "text")
        there.mkdir(parents=True)
        shutil.copytree(results / "tables", there / "tables")
        for source in (results / "numbers.json", _HERE / "layout.typ", *TEXTS):
            shutil.copy(source, there)
        shutil.copy(_BIBLIOGRAPHY, there.parent)
        shutil.copy(_BIBLIOGRAPHY.parents[1] / "CITATION.cff", folder)
        for text in TEXTS:
            try:
                check_uses(text, made_in(results))
                write(output / f"{text.stem}.tex", converted(there, text.name))
            except ValueError as error:
                raise SystemExit(f"{text.name}: {error}") from None
    write(output / "references.bib", in_latex(_BIBLIOGRAPHY.read_text(encoding="utf-8")))
    for figure in sorted((results / "figures").glob("*.pdf")):
        write(output / "figures" / figure.name, figure.read_bytes())


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
