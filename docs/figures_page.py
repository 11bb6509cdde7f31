"""All figures of the study as a page of the site."""

from docs.plan import FIGURES
from docs.text import described, table
from paper.manuscript import TEXTS, TITLES, files_of, places


def figures_page() -> str:
    """The page of all figures, each with its caption and its place in the texts."""
    known, sections = places(), []
    for figure in FIGURES:
        title, place = figure.name.replace("_", " ").capitalize(), known.get((figure.kind, figure.name))
        sections.append(
            f"## {title}\n\n```{{figure}} /figures/{figure.name}.svg\n:alt: {title}\n:class: paper\n:loading: lazy\n\n"
            f"{figure.caption}{f' {place}.' if place else ''}\n```"
        )
    first = (
        "`results/figures/` has each figure as PDF, as SVG whose text stays text, as PNG with 300 dots per inch, and "
        "its points as CSV. [The files by number](#files-by-number) are those of the figures and tables of the texts."
    )
    rows = [[f"{label} of the {TITLES[text.stem].lower()}", file] for text in TEXTS for label, file in files_of(text)]
    files = table(["number", "file in `results/`"], rows, numbers_from=2)
    text = "\n\n".join(["# All figures", first, *sections, "## Files by number", files]) + "\n"
    return described("All figures of the study of time integration schemes, with their captions.", text)
