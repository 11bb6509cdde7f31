"""``study.command``: an executable as a program."""

import hashlib
import shlex
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import psutil

from study.algebra.scalars import is_number
from study.program.attempt import TIME, Unfit, Unusable
from study.program.definition import Program

#: Placeholders of a command, which each run replaces by its values.
PLACES = ("dt", "scheme", "output", "duration")

#: Maximum number of characters that the reason of a failure quotes from the last line of a program's output.
LAST_WORDS = 200


#: Encoding of input files, with which bytes that are no text stay as they are.
_BYTES: dict[str, Any] = {"encoding": "utf-8", "errors": "surrogateescape"}


@dataclass(frozen=True)
class Command:
    """Function that runs an executable, which writes a CSV file."""

    title: str
    template: str
    duration: float
    time_limit: float | None
    #: Digest of files that determine the runs but are not named in the command.
    more: str = ""
    #: Exit code with which the executable states that no step can run it.
    unfit_code: int | None = None
    #: Text of an input file with placeholders, and its name; without a file both are empty.
    deck: str = ""
    deck_name: str = ""

    #: True makes :class:`study.Program` use threads, which suffice because each run starts a process itself.
    starts_a_process = True

    def __post_init__(self):
        if self.time_limit is not None and not (is_number(self.time_limit) and self.time_limit > 0):
            raise ValueError(f"time_limit must be a time in s greater than zero, not {self.time_limit!r}.")

    @property
    def source(self) -> str:
        """The command, ``more``, and digests of all files that the command names; together they identify the runs."""
        words = shlex.split(self.template)
        files = [Path(shutil.which(words[0]) or words[0]), *map(Path, words[1:])]
        digests = [hashlib.sha256(file.read_bytes()).hexdigest() for file in files if file.is_file()]
        return " ".join([self.template, self.more, *digests])

    def __call__(self, scheme: str, dt: float) -> dict[str, np.ndarray]:
        """Run the command in a process, and return the quantities in its output."""
        with tempfile.TemporaryDirectory() as folder:
            output, printed = Path(folder) / "output.csv", Path(folder) / "printed"
            values = {
                "dt": repr(float(dt)),
                "scheme": scheme,
                "output": str(output),
                "duration": repr(float(self.duration)),
            }
            if self.deck:
                filled = Path(folder) / self.deck_name
                filled.write_text(_filled(self.deck, values), **_BYTES)
                values["deck"] = str(filled)
            words = [_filled(word, values) for word in shlex.split(self.template)]
            # output goes to a file, because a process that outlives the program would keep a pipe open
            with printed.open("wb") as file:
                process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT)
                try:
                    code = process.wait(self.time_limit)
                except subprocess.TimeoutExpired:
                    _kill(process)
                    raise Unusable("timed_out", f"it was stopped after {self.time_limit:g} s") from None
            self._check_end(code, printed.read_text(errors="replace"))
            return _quantities(output)

    def _check_end(self, code: int, printed: str) -> None:
        lines = printed.strip().splitlines()
        if code and code == self.unfit_code:
            raise Unfit(f"'{self.title}' cannot be run: {lines[-1]}.")
        last = f": {lines[-1][:LAST_WORDS]}" if lines else ""
        if code < 0:
            raise Unusable("signal", f"the signal {signal.Signals(-code).name} ended it{last}")
        if code > 0:
            raise Unusable("exit_code", f"it ended with the exit code {code}{last}")


def _kill(process: subprocess.Popen) -> None:
    """End a process and all processes that it has started."""
    parent = psutil.Process(process.pid)
    for running in [*parent.children(recursive=True), parent]:
        with suppress(psutil.NoSuchProcess):
            running.kill()
    process.wait()


def _filled(word: str, values: dict[str, str]) -> str:
    for place, value in values.items():
        word = word.replace(f"{{{place}}}", value)
    return word


def _quantities(output: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV file with a header, by name; a file of one row without times holds single numbers."""
    if not output.is_file() or not output.stat().st_size:
        raise Unusable("nothing", "it wrote nothing to {output}")
    try:
        table = pd.read_csv(output, skipinitialspace=True, comment="#")
    except ValueError as error:
        raise Unusable("unusable", f"its output is not a CSV file ({error})") from None
    if table.empty:
        raise Unusable("nothing", "its output has a header and no row")
    if TIME in table:
        return {name: table[name].to_numpy() for name in table}
    if len(table) > 1:
        raise Unusable("unusable", f"its output has no column '{TIME}'")
    return {name: table[name].to_numpy()[0] for name in table}


def command(
    template: str,
    schemes: Sequence[str],
    duration: float,
    *,
    deck: str | Path | None = None,
    time_limit: float | None = None,
    **options: Any,
) -> Program:
    """An executable that writes a CSV file, as a program.

    Parameters
    ----------
    template
        The command, such as ``./mycode --dt {dt} --scheme {scheme} --output {output}``. The step in s, a scheme and the
        file to write are put in place of ``{dt}``, ``{scheme}`` and ``{output}``, and the duration in s in place of
        ``{duration}``. No shell interprets the command. Runs share the working directory of this process, so a program
        that writes files of fixed names needs ``workers=1``. The first line of the CSV file names its columns: ``t``
        and quantities along time, or quantities that are single numbers in one row.
    schemes, duration
        As for :class:`study.Program`.
    deck
        Path of an input file of the program in which ``{dt}``, ``{scheme}``, ``{duration}`` or ``{output}`` stand. Each
        run writes a copy of the file with the values of the run, and puts its path in place of ``{deck}`` in the
        command. The page on programs of the site lists where the step stands in the input of common codes.
    time_limit
        Seconds after which a run is stopped. The run is recorded as failed, and its scheme is not run at finer steps.
        By default there is no limit.
    **options
        Further parameters of :class:`study.Program`.

    Returns
    -------
    Program
        The program, for :func:`study.assess`. The command and the content of its files identify the runs.

    Raises
    ------
    FileNotFoundError
        If there is no such executable or input file.
    TypeError
        If the command is not a string, or an argument of :class:`study.Program` has a wrong type.
    ValueError
        If the command cannot be split into words, or neither the command nor the input file has ``{dt}``, ``{scheme}``
        and ``{output}``, or if the command has no place ``{deck}`` for an input file, or if the time limit or an
        argument of :class:`study.Program` is invalid.
    """
    if not isinstance(template, str):
        raise TypeError(f"the command must be a string, not {template!r}.")
    try:
        words = shlex.split(template)
    except ValueError as error:
        raise ValueError(f"the command {template!r} cannot be split into words: {error}.") from None
    text = "" if deck is None else Path(deck).read_text(**_BYTES)
    if deck is not None and "{deck}" not in template:
        raise ValueError(f"the command lacks {{deck}}, the place of the input file: {template!r}.")
    if lacking := [place for place in PLACES[:3] if f"{{{place}}}" not in template + text]:
        lack = "lacks" if deck is None else f"and '{deck}' lack"
        raise ValueError(f"the command {lack} {{{lacking[0]}}}, which each run replaces by its value: {template!r}.")
    if shutil.which(words[0]) is None:
        raise FileNotFoundError(f"there is no executable '{words[0]}'.")
    digest, name = ("", "") if deck is None else (hashlib.sha256(text.encode(**_BYTES)).hexdigest(), Path(deck).name)
    run = Command(Path(words[0]).name, template, duration, time_limit, digest, deck=text, deck_name=name)
    return Program(run, schemes, duration, **options)
