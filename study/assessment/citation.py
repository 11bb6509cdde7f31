"""``study.cite``: the works on which a dataset is based, as BibTeX."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from study.scheme.named import schemes

#: Bibliography of the study: in the repository a link to the article's file, in a wheel a copy of it.
WORKS = Path(__file__).with_name("references.bib")

#: Keys in the bibliography. ``PAPER`` is the key of Xie (1996). ``SOLVERS`` has the key of the work on a solver, by a
#: word in the solver's name.
PAPER, SOLVERS = "xie1996", {"heyoka": "biscani2021", "CVODE": "hindmarsh2005", "diffrax": "kidger2021"}

_ENTRY = re.compile(r"^@\w+\{(\w+),\n.*?^\}$", re.MULTILINE | re.DOTALL)

#: Pattern of the fields of the bibliography that are left out of citations.
_PRIVATE_FIELDS = re.compile(r"^  (?:shortjournal|shortbooktitle|unconfirmed) = .*\n", re.MULTILINE)


def _label(entry: str) -> str:
    """Authors and year of an entry, in the form in which a scheme states its source."""
    fields = {
        key: re.sub("[{}]", "", value) for key, value in re.findall(r"^  (\w+) = \{(.*)\},?$", entry, re.MULTILINE)
    }
    first, *others = (name.partition(",")[0] for name in fields["author"].split(" and "))
    suffix = "" if not others else f" and {others[0]}" if len(others) == 1 else " et al."
    return f"{first}{suffix} ({fields['year']})"


def _study(attributes: dict) -> str:
    created = attributes.get("date_created", "")[:4]
    year = f"  year = {{{created}}},\n" if created.isdigit() else ""
    return (
        "@software{time_integration_study,\n  author = {{The founders of the study}},\n  title = {Time integration "
        "schemes on non-linear dynamic equations: a reproducible study},\n"
        f"{year}  version = {{{attributes['version']}}}\n}}"
    )


def _record(attributes: dict) -> str:
    """Entry of a record of ground motion, from its name and the header of its file."""
    key = re.sub(r"\W+", "_", attributes["record"])
    title = re.sub(r"([%&#_$])", r"\\\1", attributes["record_source"])
    return f"@misc{{{key},\n  title = {{{title}}},\n  note = {{Record of ground motion}}\n}}"


def _sources(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Source and DOI of each scheme in a dataset; schemes that are not in the study are left out."""
    named = dataset["scheme"].values if "scheme" in dataset.variables else dataset.attrs.get("scheme", [])
    for name in np.atleast_1d(named).tolist():
        if name in schemes:
            yield schemes[name].source, schemes[name].doi


def cite(dataset: xr.Dataset) -> str:
    """BibTeX of the study and of the works on which a dataset is based.

    Parameters
    ----------
    dataset
        A dataset of the study, such as the result of :func:`study.assess`.

    Returns
    -------
    str
        Entries of the study, the paper that it reproduces, the sources of the dataset's schemes, the solvers of its
        reference, and its record of ground motion. Schemes that are not in the study have no entry, nor has a record of
        unknown source.

    Raises
    ------
    ValueError
        If ``dataset`` is not a dataset of the study.
    """
    if not isinstance(dataset, xr.Dataset) or "version" not in dataset.attrs:
        raise ValueError("cite takes a dataset of the study, such as the result of study.assess.")
    works = {match[1]: match[0] for match in _ENTRY.finditer(WORKS.read_text(encoding="utf-8"))}
    by_source = {(_label(text), (re.findall(r"  doi = \{(.*)\}", text) or [""])[0]): key for key, text in works.items()}
    solvers = " ".join(str(dataset.attrs.get(key, "")) for key in ("reference", "witness"))
    keys = {
        PAPER,
        *(by_source[source] for source in _sources(dataset)),
        *(key for w, key in SOLVERS.items() if w in solvers),
    }
    record_works = {key for (label, _), key in by_source.items() if label in dataset.attrs.get("record_source", "")}
    entries = [_study(dataset.attrs), *(_PRIVATE_FIELDS.sub("", works[key]) for key in sorted(keys | record_works))]
    return "\n\n".join(entries if record_works or "record" not in dataset.attrs else [*entries, _record(dataset.attrs)])
