"""Motions of a code: from a Python function, a command that writes a CSV file, or a folder of such files."""

import importlib
import json
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from conformance.judge import Motion, Unsupported
from conformance.problem import Problem

#: Exit status by which a command says that it has no such scheme or problem.
SKIPPED = 77

#: Longest time of a command in seconds.
TIMEOUT = 60

#: Takes a case and a whole number by which its step is divided, and returns a motion.
Runner = Callable[[Mapping[str, Any], int], Motion]


def of_function(place: str) -> Runner:
    """Runner of ``MODULE:FUNCTION`` or ``FILE.py:FUNCTION``.

    The function takes the problem, the scheme as a dictionary, the step and the number of steps, and returns u, v and,
    if it has them, a at 0, Δt, 2Δt, ..., each (steps + 1, n). It raises ``NotImplementedError`` for what it does not
    do.

    Raises
    ------
    ValueError
        If there is no such function.
    """
    file, _, name = place.rpartition(":")
    folder, module = (str(Path(file).parent), Path(file).stem) if file.endswith(".py") else (".", file)
    sys.path.insert(0, folder)
    try:
        step = getattr(importlib.import_module(module), name)
    except Exception as error:  # whatever a module raises when it is imported
        raise ValueError(
            f"'{place}' must name a module and a function in it, such as my_code:step ({error})."
        ) from None
    finally:
        sys.path.remove(folder)

    def motion(case: Mapping[str, Any], part: int) -> Motion:
        dt, steps = float(case["run"]["dt"]) / part, case["run"]["steps"] * part
        try:
            with np.errstate(all="ignore"):
                found = step(Problem(case["problem"]), case["scheme"], dt, steps)
        except NotImplementedError as error:
            raise Unsupported(str(error)) from None
        except Exception as error:  # whatever a code raises is a failure of this case and of no other
            raise ValueError(f"the code raises {type(error).__name__}: {error}") from error
        arrays = [None if one is None else np.reshape(np.asarray(one, float), (len(one), -1)) for one in found]
        return _checked(case, part, dict(zip("uva", [*arrays, None], strict=False)))

    return motion


def of_command(template: str) -> Runner:
    """Runner of a command that reads the file ``{case}`` and writes the file ``{out}``.

    The file that it reads is a case with one run, whatever the kind of the case.
    """

    def motion(case: Mapping[str, Any], part: int) -> Motion:
        with tempfile.TemporaryDirectory() as folder:
            given, out = Path(folder, "case.json"), Path(folder, "out.csv")
            given.write_text(json.dumps(divided(case, part)), encoding="utf-8")
            command = [word.format(case=given, out=out) for word in shlex.split(template)]
            try:
                done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT)
            except subprocess.TimeoutExpired:
                raise ValueError(f"the command takes longer than {TIMEOUT} s") from None
            if done.returncode == SKIPPED:
                raise Unsupported(done.stderr.strip())
            if done.returncode or not out.exists():
                raise ValueError(f"the command ends with status {done.returncode}: {done.stderr.strip()[-200:]}")
            return _checked(case, part, _read(out, case))

    return motion


def of_folder(folder: Path) -> Runner:
    """Runner of files ``NAME.csv``, with ``NAME-2.csv`` for half the step and twice the steps, and so on.

    Raises
    ------
    ValueError
        If there is no such folder.
    """
    if not folder.is_dir():
        raise ValueError(f"there is no folder '{folder}'.")

    def motion(case: Mapping[str, Any], part: int) -> Motion:
        file = folder / (f"{case['name']}.csv" if part == 1 else f"{case['name']}-{part}.csv")
        if not file.exists():
            raise Unsupported(f"no file {file.name}")
        return _checked(case, part, _read(file, case))

    return motion


def divided(case: Mapping[str, Any], part: int) -> dict[str, Any]:
    """A case with a part of its step and as many times its steps, without what it expects."""
    run = {**case["run"], "dt": repr(float(case["run"]["dt"]) / part), "steps": case["run"]["steps"] * part}
    return {**{name: case[name] for name in ("name", "problem", "scheme")}, "run": run}


def _read(file: Path, case: Mapping[str, Any]) -> Motion:
    """The columns t, u1, u2, ..., v1, ..., a1, ... of a CSV file; those of v and a may be missing."""
    header = [name.strip() for name in file.read_text(encoding="utf-8").partition("\n")[0].split(",")]
    n = len(case["problem"]["u0"])
    try:
        rows = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise ValueError(f"{file.name} is no table of numbers with one line of names: {error}") from None
    wanted = {name: [f"{name}{i}" for i in range(1, n + 1)] for name in "uva"}
    if not set(wanted["u"]) <= set(header):
        raise ValueError(f"{file.name} must have the columns t, {', '.join(wanted['u'])}")
    return {
        name: rows[:, [header.index(column) for column in columns]] if set(columns) <= set(header) else None
        for name, columns in wanted.items()
    }


def _checked(case: Mapping[str, Any], part: int, motion: Motion) -> Motion:
    shape = case["run"]["steps"] * part + 1, len(case["problem"]["u0"])
    for name, values in motion.items():
        if values is not None and values.shape != shape:
            raise ValueError(f"{name} has the shape {values.shape}, not {shape}: a row at t = 0 and one a step")
    return motion
