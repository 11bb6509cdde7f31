"""Files with records of acceleration: PEER AT2, ESM, K-NET, and text of one or two columns."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

#: Size of each unit of acceleration in metres per second squared.
UNITS = {"g": 9.80665, "m/s2": 1.0, "cm/s2": 0.01, "mm/s2": 0.001, "in/s2": 0.0254, "ft/s2": 0.3048}

#: Size of each unit of time in seconds.
TIMES = {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3}
TIMES |= {"millisecond": 1e-3, "milliseconds": 1e-3}

#: Names of a column that numbers the samples.
NUMBERING = ("n", "i", "no", "nr", "number", "index", "sample", "samples", "point", "step")

#: Relative tolerance of the spacing of samples, since a file holds few digits of their times.
UNIFORM = 1e-2

#: Number of lines at the beginning of a file in which a header is searched.
HEADER = 100

#: A number, as C or Fortran print it: Fortran also writes D, or no letter before an exponent of three digits.
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eEdD]([+-]?\d+)|([+-]\d{3}))?$")

#: A number with a decimal point, and several of them without a blank between, as Fortran prints full columns.
_POINT = r"(?:\d+\.\d*|\.\d+)(?:[eEdD][+-]?\d+)?"
_STUCK = re.compile(rf"[+-]?{_POINT}(?:[+-]{_POINT})+")

#: The name DT of an AT2 file, and the unit that may follow in brackets.
_DT = r"\bDT\b(?:\s*[(\[]\s*(\w+)\s*[)\]])?"

#: A time between two samples, or a number of samples in a second, with its unit, at the end of a part of a line.
_SPACING = re.compile(
    r"\b(?:dt|(?:time|sampling|sample)[ _-]*(?:step|interval|period)|(?:sampling|sample)[ _-]*(rate|freq\w*))[\s:=]+"
    r"((?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*[(\[]?([a-z]*)[)\]]?\s*(?:[,;]\s*\D|$)",
    re.IGNORECASE,
)
#: Size of each unit of a rate in samples per second.
RATES = {"": 1.0, "hz": 1.0, "sps": 1.0, "khz": 1e3}

#: Accelerations, shape (samples,).
Samples = Float[np.ndarray, "samples"]


class Record(NamedTuple):
    """A record as its file holds it.

    Attributes
    ----------
    samples
        Accelerations from t = 0 on.
    dt
        Time between two samples in s.
    unit
        Unit of the samples, one of ``UNITS``; None if the file does not state it.
    source
        Origin, from the header; empty if there is none.
    """

    samples: Samples
    dt: float
    unit: str | None
    source: str = ""


def _number(word: str) -> float | None:
    """The number that a word is; None if it is no finite number."""
    if not (match := _NUMBER.match(word)):
        return None
    value = float(f"{match[1]}e{match[2] or match[3] or 0}")
    return value if np.isfinite(value) else None


def _words(line: str) -> list[str]:
    line = re.split(r"[#%]", line)[0]
    if ";" in line and "." not in line:
        line = line.replace(",", ".")  # decimal commas
    words = line.replace(",", " ").replace(";", " ").split()
    return [
        part for word in words for part in (re.findall(rf"[+-]?{_POINT}", word) if _STUCK.fullmatch(word) else [word])
    ]


def _unit_of(word: str) -> str | None:
    """The unit of ``UNITS`` that a word of a header means; None if there is no such unit."""
    plain = re.sub(r"[\s*^.,;:()]", "", word.lower()).replace("sec", "s").replace("/s/s", "/s2").replace("²", "2")
    return {"gal": "cm/s2"}.get(plain, plain if plain in UNITS else None)


def _stated_unit(header: str) -> str | None:
    """The unit of acceleration that a header states, after "units" or in brackets; None if there is not exactly one."""
    stated = re.findall(r"\bunits?\s*(?:of\b|in\b|[:=])\s*([^\s,;]+)", header, re.IGNORECASE)
    for words in (stated, re.findall(r"[(\[]([^)\]]+)[)\]]", header)):
        if units := {unit for word in words if (unit := _unit_of(word))}:
            return units.pop() if len(units) == 1 else None
    return None


def _check_spacing(path: Path, heading: list[str], dt: float) -> None:
    """Refuse a time between samples that differs from all that lines of words clearly state."""
    stated = list[float]()
    for is_rate, number, unit in (match for line in heading for match in _SPACING.findall(line)):
        size = (RATES if is_rate else TIMES | {"": 1.0}).get(unit.lower(), 0.0) * float(number)
        stated += [1 / size if is_rate else size] if size else []
    if stated and all(abs(value - dt) > UNIFORM * dt for value in stated):
        raise ValueError(f"the header of '{path}' states samples {stated[0]:g} s apart, and they are {dt:g} s apart.")


def _seconds(path: Path, unit: str) -> float:
    """Size in s of a unit of time; no unit means seconds."""
    plain = unit.strip(" .").lower()
    if plain and plain not in TIMES:
        raise ValueError(f"the header of '{path}' states times in '{unit}', and they must be in s, sec, ms or msec.")
    return TIMES.get(plain, 1.0)


def read_record(path: Path, dt: float | None) -> Record:
    """Read a record; ``dt`` is the time between the samples of a file that does not state it.

    Raises
    ------
    ValueError
        If the file is not a record of acceleration, if header and samples or ``dt`` disagree, or if samples are
        missing or not evenly spaced.
    """
    lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    head = "\n".join(line for line in lines[:HEADER] if _words(line))
    if re.search(r"^SAMPLING_INTERVAL_S\s*:", head, re.MULTILINE):
        record = _read_esm(path, lines)
    elif "Scale Factor" in head and "Sampling Freq" in head:
        record = _read_knet(path, lines)
    elif re.search(r"\bNPTS\b", head, re.IGNORECASE):
        record = _read_peer(path, lines)
    else:
        record = _read_columns(path, lines, dt)
    if dt is not None and abs(record.dt - dt) > UNIFORM * record.dt:
        raise ValueError(f"the samples of '{path}' are {record.dt:g} s apart, not dt={dt:g}.")
    return record


def _check_quantity(path: Path, header: str) -> None:
    quantity = re.search(r"(?<![a-z])(velocit(?:y|ies)|velo?|displacements?|displ?)(?![a-z])", header, re.IGNORECASE)
    if quantity and not re.search(r"(?<![a-z])acc(el\w*)?(?![a-z])", header, re.IGNORECASE):
        kind = "velocity" if quantity[0].lower().startswith("v") else "displacement"
        raise ValueError(f"the header of '{path}' announces {kind}, and a record of acceleration is needed.")


def _rows(path: Path, lines: list[str], first: int) -> dict[int, list[float]]:
    """Numbers of each line from the index ``first`` on, by the number of the line, which counts from one."""
    rows = {}
    for number, line in enumerate(lines[first:], start=first + 1):
        values = [(_number(word), word) for word in _words(line)]
        for value, word in values:
            if value is None:
                raise ValueError(f"row {number} of '{path}' holds '{word}', which is not a finite number.")
        if values:
            rows[number] = [value for value, _ in values if value is not None]
    return rows


def _samples(path: Path, lines: list[str], first: int, count: int | None) -> Samples:
    """All numbers from the line with the index ``first`` on."""
    samples = np.array([value for row in _rows(path, lines, first).values() for value in row])
    if count is not None and len(samples) != count:
        raise ValueError(f"the header of '{path}' announces {count} samples, and the file holds {len(samples)}.")
    return samples


def _first_row(lines: list[str], start: int = 0) -> int:
    """Index of the first line from ``start`` on that begins with a number, or "nan"; after the last, if none does."""
    for place, line in enumerate(lines[start:], start=start):
        if (words := _words(line)) and (
            _number(words[0]) is not None or words[0].lower().lstrip("+-") in ("nan", "inf")
        ):
            return place
    return len(lines)


def _count_and_spacing(path: Path, lines: list[str]) -> tuple[int, float, int]:
    """NPTS and DT in s of an AT2 file, and the index of the line after them."""
    place = next(i for i, line in enumerate(lines) if re.search(r"\bNPTS\b", line, re.IGNORECASE))
    line = lines[place].upper()
    names = re.findall(r"\b(NPTS|DT)\b", line)
    count_after = re.search(r"\bNPTS\s*[=:]\s*([^\s,;]+)", line)
    dt_after = re.search(
        rf"{_DT}\s*[=:]\s*((?:{_POINT}|\d+)(?:[ED][+-]?\d+)?)(?![\d./])\s*[(\[]?((?!NPTS\b)[A-Z]*)", line
    )
    if count_after or re.search(rf"{_DT}\s*[=:]", line):
        header = {"NPTS": _number(count_after[1]) if count_after else None}
        header["DT"] = _number(dt_after[2]) if dt_after else None
        unit = (dt_after[1] or dt_after[3]) if dt_after else ""
    else:
        # numbers before the names, or in the next line
        numbers = [value for word in _words(line) if (value := _number(word)) is not None]
        if not numbers and place + 1 < len(lines):
            place += 1
            numbers = [value for word in _words(lines[place]) if (value := _number(word)) is not None]
            line += f" {lines[place].upper()}"
        header = dict(zip(names, numbers, strict=False))
        known = [word for word in re.findall(r"[A-Z]+", line) if word.lower() in TIMES]
        unit = (in_brackets[1] if (in_brackets := re.search(_DT, line)) else "") or "".join(known[:1])
    count, dt = header.get("NPTS"), header.get("DT")
    if count is None or dt is None or count != round(count) or dt <= 0:
        raise ValueError(f"the header of '{path}' names NPTS, and must state both NPTS and DT as positive numbers.")
    if not count:
        raise ValueError(f"the header of '{path}' announces no samples.")
    return int(count), dt * _seconds(path, unit), place + 1


def _read_peer(path: Path, lines: list[str]) -> Record:
    """A file of the PEER ground motion database, whose first sample belongs to t = DT."""
    count, dt, end = _count_and_spacing(path, lines)
    first = _first_row(lines, end)
    header = " ".join(lines[:first])
    _check_quantity(path, header)
    source = ", ".join(line.strip() for line in lines[:2])
    return Record(np.append(0.0, _samples(path, lines, first, count)), dt, _stated_unit(header), source)


def _stated(path: Path, head: str, name: str, pattern: str) -> str:
    """Text that a header states for a name; ``pattern`` has one group, this text."""
    match = re.search(pattern, head, re.MULTILINE)
    if match is None:
        raise ValueError(f"the header of '{path}' lacks the value of '{name}'.")
    return match[1].strip()


def _positive(path: Path, head: str, name: str, pattern: str) -> float:
    text = _stated(path, head, name, pattern)
    value = _number(text)
    if value is None or value <= 0:
        raise ValueError(f"the header of '{path}' must state '{name}' as a number greater than zero, not '{text}'.")
    return value


def _read_esm(path: Path, lines: list[str]) -> Record:
    """A file of the Engineering Strong Motion database, whose header has lines ``KEY: value``."""
    first = _first_row(lines)
    head = "\n".join(lines[:first])
    keys = {name: rf"^{name}\s*:(.*)$" for name in ("SAMPLING_INTERVAL_S", "NDATA", "UNITS", "DATA_TYPE")}
    kind = _stated(path, head, "DATA_TYPE", keys["DATA_TYPE"])
    _check_quantity(path, kind)
    if "spectr" in kind.lower():
        raise ValueError(f"the header of '{path}' announces a spectrum, and a record of acceleration is needed.")
    dt, count = (_positive(path, head, name, keys[name]) for name in ("SAMPLING_INTERVAL_S", "NDATA"))
    unit = _unit_of(_stated(path, head, "UNITS", keys["UNITS"]))
    source = ", ".join(re.findall(r"^(?:EVENT_NAME|EVENT_ID|STATION_CODE)\s*:\s*(\S.*)$", head, re.MULTILINE))
    return Record(_samples(path, lines, first, int(count)), dt, unit, source)


def _read_knet(path: Path, lines: list[str]) -> Record:
    """A file of K-NET or KiK-net: counts of the instrument, whose mean is its offset."""
    first = next((i + 1 for i, line in enumerate(lines[:HEADER]) if line.startswith("Memo")), 0)
    head = "\n".join(lines[:first])
    rate = _positive(path, head, "Sampling Freq(Hz)", r"^Sampling Freq\S*\s+([^\s]+?)\s*Hz")
    full, counts = (
        _positive(path, head, "Scale Factor", rf"^Scale Factor\s+{pattern}")
        for pattern in (r"([^\s(]+)\s*\(gal\)", r"\S*\(gal\)\s*/\s*(\S+)")
    )
    seconds = re.search(r"^Duration Time\S*\s+(\d+)", head, re.MULTILINE)
    samples = _samples(path, lines, first, round(int(seconds[1]) * rate) if seconds else None)
    source = ", ".join(re.findall(r"^(?:Origin Time|Station Code|Dir\.)\s+(\S.*)$", head, re.MULTILINE))
    return Record((samples - samples.mean()) * full / counts, 1 / rate, "cm/s2", source)


def _after_count(rows: dict[int, list[float]]) -> tuple[dict[int, list[float]], float | None]:
    """The rows without a first one that states the number of the samples, and the time between them, if it follows."""
    (_, stated), *others = [*rows.items()] or [(0, [])]
    values = [row for _, row in others]
    if len(stated) not in (1, 2) or stated[0] not in (len(values), sum(map(len, values))) or len(values) < 2:
        return rows, None
    return dict(others), stated[1] if len(stated) == 2 else None


def _is_continuous(rows: list[list[float]], dt: float) -> bool:
    """Whether rows hold samples one after the other: all are of one length but for the last, and none begins with t."""
    first = np.array([row[0] for row in rows])
    step = float(first[1] - first[0]) if len(rows) > 2 else dt
    times = len(rows) > 1 and step > 0 and np.allclose(np.diff(first), step, rtol=UNIFORM, atol=0)
    return not times and len({len(row) for row in rows[:-1]}) <= 1 and len(rows[-1]) <= len(rows[0])


def _name_and_unit(field: str) -> tuple[str, str]:
    """Name of a column in small letters, and its unit, which follows in brackets or after a blank or an underscore."""
    field = field.strip(" \"'").lower()
    name, _, rest = re.sub(r"[\s_(\[]+", " ", field).strip().partition(" ")
    brackets = re.search(r"[(\[]([^)\]]*)[)\]]", field)
    bare = rest.removeprefix("in ")
    unit = brackets[1] if brackets else bare if bare in TIMES or re.fullmatch(r"[a-z]{1,3}", bare) else ""
    return name.strip("])"), unit.strip() if field[:1] not in "([" else ""


def _times(path: Path, heading: list[str]) -> tuple[int, float]:
    """Index of the column of times, and the size of their unit in s; the heading may name columns in either order."""
    place, unit = 0, ""
    for line in heading:
        plain = line.strip(" #%\t")
        fields = re.split(r"[,;\t]", plain)
        if len(fields) != 2:
            fields = re.findall(r"[^\s(\[]+(?:\s*[(\[][^)\]]*[)\]])?", plain)
        if len(fields) == 4 and TIMES.keys() & {fields[1].lower(), fields[3].lower()}:  # names and units by turns
            fields = [" ".join(fields[:2]), " ".join(fields[2:])]
        columns = [_name_and_unit(field) for field in fields]
        if len(columns) == 2 and columns[0][0] in NUMBERING:
            raise ValueError(f"'{path}' numbers its samples and states no times: leave out this column, and give dt=.")
        times = [i for i, (name, _) in enumerate(columns) if name in ("t", "time", "times") or name in TIMES]
        if len(columns) != 2 or len(times) != 1:
            continue
        if times == [1] and not re.search(r"[,;\t]", plain) and not re.match(r"a|.*/s|g$", columns[0][0]):
            continue  # a title, such as "origin time"
        place = times[0]
        name, name_unit = columns[place]
        unit = name if name in TIMES else name_unit or unit
        if columns[1 - place][0] in ("u", "v", "d"):
            kind = "velocity" if columns[1 - place][0] == "v" else "displacement"
            raise ValueError(f"the header of '{path}' announces {kind}, and a record of acceleration is needed.")
    in_brackets = re.findall(r"[(\[]\s*(\w+)\s*[)\]]", "\n".join(heading))
    return place, _seconds(path, unit or next((word for word in in_brackets if word.lower() in TIMES), ""))


def _read_columns(path: Path, lines: list[str], dt: float | None) -> Record:
    """A file with times and accelerations, or with accelerations alone; lines of words may precede them."""
    first = _first_row(lines)
    heading = " ".join(lines[:first])
    _check_quantity(path, heading)
    width = len(_words(lines[first])) if first < len(lines) else 0
    while first and len(words := _words(lines[first - 1])) == width and any(_number(w) is not None for w in words):
        first -= 1  # a row of samples with a word among them, and no heading
    rows, announced = _after_count(_rows(path, lines, first))
    width = len(next(iter(rows.values()), ()))
    dt = announced or dt
    if width > 3 and dt is not None and not heading.strip() and _is_continuous([*rows.values()], dt):
        return Record(np.array([value for row in rows.values() for value in row]), dt, None)
    if width not in (1, 2):
        raise ValueError(
            f"'{path}' is no file of PEER, ESM or K-NET and has {width or 'no'} columns of numbers: leave one of "
            "accelerations, or one of times and one of accelerations."
        )
    if odd := [number for number, row in rows.items() if len(row) != width]:
        raise ValueError(f"row {odd[0]} of '{path}' has {len(rows[odd[0]])} numbers, and the first row {width}.")
    unit = _stated_unit(heading)
    if width == 1:
        if dt is None:
            raise ValueError(f"'{path}' has one column: give the time between its samples in s, such as dt=0.01.")
        _check_spacing(path, lines[:first], dt)
        return Record(np.array([row[0] for row in rows.values()]), dt, unit)
    if len(rows) < 2:
        raise ValueError(f"'{path}' has one row, and a record needs at least two samples.")
    place, second = _times(path, lines[:first])
    columns = np.array(list(rows.values())).T
    t, samples = second * columns[place], columns[1 - place]
    if dt is not None and np.allclose(t - t[0], dt * np.arange(len(t)), rtol=0.0, atol=0.75 * dt):
        t = t[0] + dt * np.arange(len(t))  # times with few digits
    spacing = float(np.median(np.diff(t)))
    uneven = np.flatnonzero(np.abs(np.diff(t) - spacing) > UNIFORM * abs(spacing))
    if uneven.size or spacing <= 0:
        location = f" after t = {t[uneven[0]]:g}" if uneven.size else ""
        raise ValueError(
            f"the samples of '{path}' must be a constant time apart, and are not{location}: if the times are rounded, "
            "give dt=."
        )
    if t[0] < -UNIFORM * spacing:
        raise ValueError(f"the times of '{path}' must begin at zero or later, and begin at {t[0]:g}: shift them.")
    spacing = float(t[-1] - t[0]) / (len(t) - 1)
    _check_spacing(path, lines[:first], spacing)
    begin = round(t[0] / spacing)
    if abs(t[0] - begin * spacing) > UNIFORM * spacing:
        raise ValueError(f"the times of '{path}' must be multiples of {spacing:g}, and the first is {t[0]:g}.")
    return Record(np.concatenate([np.zeros(begin), samples]), spacing, unit)
