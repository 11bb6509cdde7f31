"""Checks of the ledger and the pages of a finished study."""

import csv
import json
import re
import subprocess
from itertools import combinations
from pathlib import Path

import study
from paper.claims.ledger import Verdict

#: Least and largest number of pages of each text; a replication in ReScience C has eight at most.
PAGES = {"manuscript": (9, 16), "supplement": (9, 40), "replication": (4, 8)}


#: Pattern of a word in the output of Poppler: its box, measured from the left and the top, and its letters.
WORD = re.compile(r'<word xMin="(.+?)" yMin="(.+?)" xMax="(.+?)" yMax="(.+?)">(.*?)</word>')
#: Largest width of the lower and the right margin, and how far a word may reach into that margin, in points.
MARGIN, INTO_MARGIN = 54, 6
#: Largest number of pairs of overlapping words on a page; signs of an equation may overlap.
OVERLAPS = 2


def check_pages(results: Path) -> None:
    """Check the number of pages, and that no page has many overlapping words, or words in its lower or right margin."""
    for name, (least, most) in PAGES.items():
        command = ["pdftotext", "-bbox", str(results / f"{name}.pdf"), "-"]
        stated = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        pages = re.findall(r'<page width="(.+?)" height="(.+?)">(.*?)</page>', stated, re.DOTALL)
        assert least <= len(pages) <= most, name
        for number, (width, height, page) in enumerate(pages, 1):
            boxes = [(*map(float, word[:4]), word[4]) for word in WORD.findall(page)]
            lowest = float(height) - MARGIN + INTO_MARGIN
            low = [word for *_, bottom, word in boxes if bottom > lowest and not word.isdigit()]
            assert not low, (name, number, low)
            outside = [word for _, _, right, _, word in boxes if right > float(width) - MARGIN + INTO_MARGIN]
            assert not outside, (name, number, outside)
            over = [(box[4], other[4]) for box, other in combinations(boxes, 2) if _overlap(box, other)]
            assert len(over) <= OVERLAPS, (name, number, over)


def _overlap(box: tuple, other: tuple) -> bool:
    """Whether the boxes of two words share more than a point in width, and more than half of the smaller height."""
    across = min(box[2], other[2]) - max(box[0], other[0])
    down = min(box[3], other[3]) - max(box[1], other[1])
    return across > 1 and down > min(box[3] - box[1], other[3] - other[1]) / 2


def check_ledger(results: Path) -> None:
    """Check that every claim has a verdict and, unless it is reproduced, a reason, in words that can be printed."""
    claims = list(csv.DictReader((results / "claims.csv").read_text().splitlines()))
    assert len(claims) >= 35
    assert {c["verdict"] for c in claims} <= {*Verdict}
    for claim in claims:
        assert claim["verdict"] == "reproduced" or claim["reason"], claim["claim"]
        printed = f"{claim['ours']} {claim['reason']}"
        assert not re.search(r"\bnan\b|\binf\b|\d[eE][-+−]?\d|\w_\w", printed), printed
        assert not set(re.findall(r"\w+", printed)) & set(study.schemes), printed
    numbers = json.loads((results / "numbers.json").read_text())
    assert numbers["cells_rounded_twice"] == "97"
