"""The works of ``paper/references.bib``, and how docstrings and schemes cite them."""

import inspect
import re
from pathlib import Path
from unicodedata import normalize

PROJECT = Path(__file__).parent.parent
FILE = PROJECT / "paper" / "references.bib"
Work = dict[str, str]

_ENTRY = re.compile(r"^@(\w+)\{([^\s,]+),\n(.*?)\n\}$", re.MULTILINE | re.DOTALL)
_FIELD = re.compile(r"  (\w+) = \{(.*)\},?")
_PLACE = re.compile(r"(, (sections?|chapters?) [\w., ]+?| \([^)]*\))?\.( |$)")


#: Combining character of each accent of LaTeX.
_ACCENTS = {"`": "\u0300", "'": "\u0301", "^": "\u0302", '"': "\u0308", "~": "\u0303", "=": "\u0304", ".": "\u0307"}
_ACCENTS |= {"u": "\u0306", "v": "\u030c", "H": "\u030b", "c": "\u0327", "r": "\u030a", "k": "\u0328"}
#: Letters that LaTeX names.
_LETTERS = {"ss": "ß", "o": "ø", "O": "Ø", "l": "ł", "L": "Ł", "i": "i"}
_LETTERS |= {"ae": "æ", "AE": "Æ", "oe": "œ", "aa": "å", "AA": "Å"}
_ACCENTED = re.compile(r"\\(?:([`'^\"~=.])|([uvHcrk])(?=[ {]))\s*\{?(?:\\(?=i))?(\w)\}?")
_LETTER = re.compile(r"\\(ss|[oOlLi]|ae|AE|oe|aa|AA)(?:\{\}|(?![a-zA-Z]) ?)")


def _unicode(value: str) -> str:
    """A field with the letters that its accents of LaTeX stand for."""
    value = _ACCENTED.sub(lambda match: normalize("NFC", match[3] + _ACCENTS[match[1] or match[2]]), value)
    return _LETTER.sub(lambda match: _LETTERS[match[1]], value)


def works() -> dict[str, Work]:
    """Fields of every work by its key; the type of its BibTeX entry is the field ``kind``."""
    entries: dict[str, Work] = {}
    for kind, key, body in _ENTRY.findall(FILE.read_text()):
        fields = [_FIELD.fullmatch(line) for line in body.splitlines()]
        if key in entries or not all(fields):
            raise ValueError(f"{FILE.name}: '{key}' occurs twice, or one of its lines is not a field in braces.")
        entries[key] = {"kind": kind} | {field[1]: _unicode(field[2]) for field in fields if field}
        for name, value in entries[key].items():
            if command := re.search(r"\\(?!&)\S*", value):
                raise ValueError(f"{FILE.name}: {name} of '{key}' has {command[0]!r}; write the letter itself.")
    return entries


def _plain(value: str) -> str:
    return value.replace("{", "").replace("}", "").replace("\\&", "&").replace("--", "-")


def _authors(work: Work) -> list[tuple[str, str]]:
    """Last names and initials."""
    names = [_plain(author).split(", ") for author in work["author"].split(" and ")]
    return [(last, initials) for last, initials in names]


def label(work: Work) -> str:
    """Authors and year in the form of a scheme's source, such as "Noh and Bathe (2019)"."""
    first, *others = [last for last, _ in _authors(work)]
    more = "" if not others else f" and {others[0]}" if len(others) == 1 else " et al."
    return f"{first}{more} ({work['year']})"


def reference(work: Work) -> str:
    """The citation of the work in a docstring, without the place in the work and without the full stop."""
    year, volume, pages = work["year"], work.get("volume", ""), work.get("pages", "")
    if work["kind"] == "article":
        number = f"({work['number']})" if "number" in work else ""
        where = [f"{work['shortjournal']} {volume}{number}", year, pages]
    elif work["kind"] == "inproceedings":
        where = [work["shortbooktitle"], year, pages]
    elif work["kind"] == "book":
        edition = f"{work['edition']} ed." if "edition" in work else ""
        where = [f"vol. {volume}" if volume else "", edition, work["publisher"], year]
    else:
        where = [f"{work.get('type', 'Thesis')} {work.get('number', '')}".strip()]
        where += [work.get("institution") or work["school"], year]
    authors = [f"{initials} {last}" for last, initials in _authors(work)]
    return _plain(", ".join(filter(None, [*authors, work["title"], *where])))


def cited_in(docstring: str, references: dict[str, str]) -> list[str]:
    """Keys of the works in the section References of a docstring.

    Raises
    ------
    ValueError
        If the section has other text than ``references``. After each reference, a place in the work is optional, and a
        full stop is required.
    """
    _, _, section = inspect.cleandoc(docstring).partition("References\n----------\n")
    text, keys = " ".join(section.split()), []
    while text:
        for key, words in references.items():
            if text.startswith(words) and (place := _PLACE.match(text, len(words))):
                keys.append(key)
                text = text[place.end() :]
                break
        else:
            raise ValueError(f"{FILE.name} has no such work: {text[:200]!r}")
    return keys
