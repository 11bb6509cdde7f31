"""Numbers, figures and tables that the texts use, and requirements of statements without a number."""

import re
from pathlib import Path

from paper.products import Product, enter
from paper.requirements import as_many
from study.io import read
from study.words import listed

#: Common part of the texts.
LAYOUT = Path(__file__).parent / "text" / "layout.typ"
#: Files of the texts; each text becomes a PDF with its name.
TEXTS = [LAYOUT.with_name(name) for name in ("manuscript.typ", "supplement.typ", "replication.typ")]
#: Files that the texts include.
SHARED = [LAYOUT, *(LAYOUT.with_name(name) for name in ("energy_errors.typ", "metadata.yaml"))]

#: Pattern of a numbered figure, with its name, or table.
_NUMBERED = re.compile(r'\bpicture\("(?P<figure>[^"]+)"|#(?:tabular|choices)\(')
_COMMENT = re.compile(r"^[ \t]*//.*$", re.MULTILINE)
#: Patterns of the uses of numbers, figures and tables in a text, by kind.
_USES = {
    "number": re.compile(r'(?<![\w."])n\.(?:at\("([^"]+)"\)|(?!at\()([A-Za-z_]\w*))'),
    "figure": re.compile(r'\bpicture\("([^"]+)"'),
    "table": re.compile(r'\btable-of\("([^"]+)"'),
}


def uses(text: str) -> dict[str, dict[str, int]]:
    """Numbers, figures and tables that a text uses: kind, name, and the number of the first line with the name."""
    code = _COMMENT.sub("", text)
    lines: dict[str, dict[str, int]] = {kind: {} for kind in _USES}
    for kind, pattern in _USES.items():
        for match in pattern.finditer(code):
            name = next(filter(None, match.groups()))
            lines[kind].setdefault(name, code.count("\n", 0, match.start()) + 1)
    return lines


def numbered(text: Path) -> list[tuple[str, str]]:
    """The figures and tables of a text in their order: ``Figure 1`` or ``Table S2``, and the name of its file.

    The name of a table without a file is empty.
    """
    code = _COMMENT.sub("", text.read_text(encoding="utf-8"))
    prefix = "S" if text.stem == "supplement" else ""
    places = list(_NUMBERED.finditer(code))
    ends = [place.start() for place in places[1:]] + [len(code)]
    files, counts = [], {"Figure": 0, "Table": 0}
    for place, end in zip(places, ends, strict=True):
        kind = "Figure" if place["figure"] else "Table"
        data = _USES["table"].search(code, place.start(), end)
        # the next table may be used in the text between the two
        held = data if data and "\n\n" not in code[place.start() : data.start()] else None
        counts[kind] += 1
        files.append((f"{kind} {prefix}{counts[kind]}", place["figure"] or (held[1] if held else "")))
    return files


#: Name of each text, by the stem of its file.
TITLES = {"manuscript": "Article", "supplement": "Supplement", "replication": "Replication"}


def places() -> dict[tuple[str, str], str]:
    """Where the texts have a figure or table, as in "Figure S3 of the supplement", by its kind and name."""
    labels: dict[tuple[str, str], list[str]] = {}
    for text in TEXTS:
        for label, name in numbered(text):
            part_labels = labels.setdefault((label.split()[0].lower(), name), [])
            part_labels.append(f"{label} of the {TITLES[text.stem].lower()}")
    return {part: listed(part_labels) for part, part_labels in labels.items()}


def files_of(text: Path) -> list[tuple[str, str]]:
    """The figures and tables of a text, as in ``Figure S3``, each with its file in ``results`` or why it has none."""
    return [
        (label, f"`{label.split()[0].lower()}s/{name}`" if name else "in the text only")
        for label, name in numbered(text)
    ]


def listing() -> str:
    """The files of all figures and tables of the texts, as Markdown."""
    parts = ["# Figures and tables"]
    parts.append(
        "Which file is which figure and table of the texts. A figure is there as `.pdf`, as `.svg` whose text stays "
        "text, as `.png` with 300 dots per inch, and its points as `.csv`. A table is there as `.csv`, and as `.tex` "
        "for the package `booktabs`."
    )
    for text in TEXTS:
        rows = [f"| {label} | {file} |" for label, file in files_of(text)]
        parts.append("\n".join([f"## {TITLES[text.stem]}\n", "| number | file |", "| --- | --- |", *rows]))
    return "\n\n".join(parts) + "\n"


def check_uses(text: Path, results: Path) -> None:
    """Refuse a text that uses a number, figure or table that is not in a folder of results.

    Raises
    ------
    SystemExit
        If a number, figure or table is missing; the message has the line of the text.
    """
    there = {
        "number": read(results / "numbers.json"),
        "figure": {path.stem for path in (results / "figures").glob("*.pdf")},
        "table": {path.stem for path in (results / "tables").glob("*.csv")},
    }
    for kind, names in uses(text.read_text(encoding="utf-8")).items():
        for name, line in names.items():
            if name not in there[kind]:
                raise SystemExit(f"{text.name}, line {line}: there is no {kind} '{name}' in the results.")


#: Requirements of statements that the text makes without a number from the datasets.
_REQUIRES = {
    "large_steps.problems": ["hardening", "softening", "softening_large", "double_well"],
    "sensitivity.problem": "double_well",
    "sensitivity.perturbation": 1e-10,
    "stability.roots.paper_step_size": 2.5,
    "atlas.problems": as_many(3),
}

enter(Product("text", "manuscript", __name__, uses, {}, "", _REQUIRES))
