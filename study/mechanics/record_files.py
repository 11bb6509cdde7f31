"""Files with records of acceleration: PEER AT2, ESM, K-NET, and text of one or two columns."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

#: Size of each unit of acceleration in metres per second squared.
UNITS = {"g": 9.80665, "m/s2": 1.0, "cm/s2": 0.01, "mm/s2": 0.001, "in/s2": 0.0254, "ft/s2": 0.3048}

#: Relative tolerance of the spacing of samples, since a file holds few digits of their times.
UNIFORM = 1e-2

#: Number of lines at the beginning of a file in which a header is searched.
HEADER = 100

#: A number, as C or Fortran print it: Fortran also writes D, or no letter before an exponent of three digits.
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eEdD]([+-]?\d+)|([+-]\d{3}))?$")

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
    if not (found := _NUMBER.match(word)):
        return None
    value = float(f"{found[1]}e{found[2] or found[3] or 0}")
    return value if np.isfinite(value) else None


def _words(line: str) -> list[str]:
    return re.split(r"[#%]", line)[0].replace(",", " ").replace(";", " ").split()


def _unit_of(word: str) -> str | None:
    """The unit of ``UNITS`` that a word of a header means; None if there is no such unit."""
    plain = re.sub(r"[\s*^.,;:()]", "", word.lower()).replace("sec", "s").replace("/s/s", "/s2").replace("²", "2")
    return {"gal": "cm/s2"}.get(plain, plain if plain in UNITS else None)


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
        record = _of_esm(path, lines)
    elif "Scale Factor" in head and "Sampling Freq" in head:
        record = _of_knet(path, lines)
    elif re.search(r"\bNPTS\b", head, re.IGNORECASE):
        record = _of_peer(path, lines)
    else:
        record = _of_columns(path, lines, dt)
    if dt is not None and abs(record.dt - dt) > UNIFORM * record.dt:
        raise ValueError(f"the samples of '{path}' are {record.dt:g} s apart, not dt={dt:g}.")
    return record


def _check_quantity(path: Path, header: str) -> None:
    other = re.search(r"velocity|displacement", header, re.IGNORECASE)
    if other and not re.search("acceleration", header, re.IGNORECASE):
        raise ValueError(
            f"the header of '{path}' announces {other[0].lower()}, and a record of acceleration is needed."
        )


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
    """NPTS and DT of an AT2 file, and the index of the line after them."""
    place = next(i for i, line in enumerate(lines) if re.search(r"\bNPTS\b", line, re.IGNORECASE))
    line = lines[place].upper()
    names = re.findall(r"\b(NPTS|DT)\b", line)
    after = {name: re.search(rf"\b{name}\s*[=:]\s*([^\s,;]+)", line) for name in ("NPTS", "DT")}
    if any(after.values()):
        found = {name: _number(match[1]) for name, match in after.items() if match}
    else:
        # numbers before the names, or in the next line
        numbers = [value for word in _words(line) if (value := _number(word)) is not None]
        if not numbers and place + 1 < len(lines):
            place += 1
            numbers = [value for word in _words(lines[place]) if (value := _number(word)) is not None]
        found = dict(zip(names, numbers, strict=False))
    count, dt = found.get("NPTS"), found.get("DT")
    if count is None or dt is None or count != round(count) or dt <= 0:
        raise ValueError(f"the header of '{path}' names NPTS, and must state both NPTS and DT as positive numbers.")
    if not count:
        raise ValueError(f"the header of '{path}' announces no samples.")
    return int(count), dt, place + 1


def _of_peer(path: Path, lines: list[str]) -> Record:
    """A file of the PEER ground motion database, whose first sample belongs to t = DT."""
    count, dt, end = _count_and_spacing(path, lines)
    first = _first_row(lines, end)
    header = " ".join(lines[:first])
    _check_quantity(path, header)
    stated = re.search(r"units of (\S+)", header, re.IGNORECASE)
    unit = _unit_of(stated[1]) if stated else None
    source = ", ".join(line.strip() for line in lines[:2])
    return Record(np.append(0.0, _samples(path, lines, first, count)), dt, unit, source)


def _stated(path: Path, head: str, name: str, pattern: str) -> str:
    """Text that a header states for a name; ``pattern`` has one group, this text."""
    found = re.search(pattern, head, re.MULTILINE)
    if found is None:
        raise ValueError(f"the header of '{path}' lacks the value of '{name}'.")
    return found[1].strip()


def _positive(path: Path, head: str, name: str, pattern: str) -> float:
    text = _stated(path, head, name, pattern)
    value = _number(text)
    if value is None or value <= 0:
        raise ValueError(f"the header of '{path}' must state '{name}' as a number greater than zero, not '{text}'.")
    return value


def _of_esm(path: Path, lines: list[str]) -> Record:
    """A file of the Engineering Strong Motion database, whose header has lines ``KEY: value``."""
    first = _first_row(lines)
    head = "\n".join(lines[:first])
    keys = {name: rf"^{name}\s*:(.*)$" for name in ("SAMPLING_INTERVAL_S", "NDATA", "UNITS", "DATA_TYPE")}
    _check_quantity(path, _stated(path, head, "DATA_TYPE", keys["DATA_TYPE"]))
    dt, count = (_positive(path, head, name, keys[name]) for name in ("SAMPLING_INTERVAL_S", "NDATA"))
    unit = _unit_of(_stated(path, head, "UNITS", keys["UNITS"]))
    source = ", ".join(re.findall(r"^(?:EVENT_NAME|EVENT_ID|STATION_CODE)\s*:\s*(\S.*)$", head, re.MULTILINE))
    return Record(_samples(path, lines, first, int(count)), dt, unit, source)


def _of_knet(path: Path, lines: list[str]) -> Record:
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


def _of_columns(path: Path, lines: list[str], dt: float | None) -> Record:
    """A file with times and accelerations, or with accelerations alone; lines of words may precede them."""
    first = _first_row(lines)
    heading = " ".join(lines[:first])
    _check_quantity(path, heading)
    width = len(_words(lines[first])) if first < len(lines) else 0
    for place, line in enumerate(lines[:first]):
        words = _words(line)
        if len(words) == width and any(_number(word) is not None for word in words):
            first = place  # a row of samples with a word among them, and no heading
            break
    rows = _rows(path, lines, first)
    if width not in (1, 2):
        raise ValueError(f"'{path}' is neither a file of PEER, ESM or K-NET nor one of one or two columns.")
    if odd := [number for number, row in rows.items() if len(row) != width]:
        raise ValueError(f"row {odd[0]} of '{path}' has {len(rows[odd[0]])} numbers, and the first row {width}.")
    units = {unit for word in re.findall(r"[(\[]([^)\]]+)[)\]]", heading) if (unit := _unit_of(word))}
    unit = units.pop() if len(units) == 1 else None
    if width == 1:
        if dt is None:
            raise ValueError(f"'{path}' has one column: give the time between its samples in s, such as dt=0.01.")
        return Record(np.array([row[0] for row in rows.values()]), dt, unit)
    if len(rows) < 2:
        raise ValueError(f"'{path}' has one row, and a record needs at least two samples.")
    t, samples = np.array(list(rows.values())).T
    found = float(np.median(np.diff(t)))
    off = np.flatnonzero(np.abs(np.diff(t) - found) > UNIFORM * abs(found))
    if off.size or found <= 0:
        at = f" after t = {t[off[0]]:g}" if off.size else ""
        raise ValueError(f"the samples of '{path}' must be a constant time apart, and are not{at}.")
    found = float(t[-1] - t[0]) / (len(t) - 1)
    begin = round(t[0] / found)
    if begin < 0 or abs(t[0] - begin * found) > UNIFORM * found:
        raise ValueError(f"the times of '{path}' must be multiples of {found:g}, and the first is {t[0]:g}.")
    return Record(np.concatenate([np.zeros(begin), samples]), found, unit)
