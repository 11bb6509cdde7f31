"""Motions of a code: from a Python function, a command that writes a CSV file, or a folder of such files."""

import importlib
import json
import multiprocessing
import os
import shlex
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from subprocess import DEVNULL, PIPE
from typing import Any

import numpy as np

from conformance.judge import CASES, Motion, Unsupported, times
from conformance.problem import Problem

#: Exit status by which a command states that it has no such scheme or problem.
SKIPPED = 77

#: Time limits of a run of a command, and of a call and the import of a function in seconds. The first call may compile.
TIMEOUT, CALL_TIMEOUT, IMPORT_TIMEOUT = 60.0, 300.0, 300.0

#: Function of a case and of the whole number that divides the step size of the case. It returns a motion.
Runner = Callable[[Mapping[str, Any], int], Motion]


def step_runner(step: Callable[..., Any]) -> Runner:
    """Runner of a Python function in this process.

    The function takes the problem, the scheme as a dictionary, the step size and the number of steps. It returns u, v
    and, if available, a, at the start and after every step, each of shape (steps + 1, n). For unequal steps the step
    size is an array of shape (steps,). The function raises ``NotImplementedError`` for an unsupported case.
    """

    def motion(case: Mapping[str, Any], part: int) -> Motion:
        dt, steps = times(case, part)
        try:
            with np.errstate(all="ignore"):
                result = step(Problem(case["problem"]), case["scheme"], dt, steps)
        except NotImplementedError as error:
            raise Unsupported(str(error)) from None
        except (Exception, SystemExit) as error:  # any error of the code is a failure of this case alone
            raise ValueError(f"the code raises {type(error).__name__}: {error}") from error
        return _checked(case, part, _arrays(result))

    return motion


def function_runner(place: str) -> Runner:
    """Runner of the function that ``MODULE:FUNCTION`` or ``FILE.py:FUNCTION`` names, in a process of its own.

    A crash or a hang, also of compiled code, ends that process and fails one case. ``step_runner`` states what the
    function takes and returns.

    Raises
    ------
    ValueError
        If the module cannot be imported or has no such function.
    """
    worker = Worker(place)

    def motion(case: Mapping[str, Any], part: int) -> Motion:
        return worker.motion(case, part)

    return motion


class Worker:
    """A process that imports a function and calls it; a new process takes the place of one that has ended."""

    def __init__(self, place: str):
        self.place = place
        self._start()

    def _start(self) -> None:
        spawn = multiprocessing.get_context("spawn")
        self._pipe, child = spawn.Pipe()
        self._process = spawn.Process(target=_serve, args=(self.place, child), daemon=True)
        self._process.start()
        child.close()
        self._answer(IMPORT_TIMEOUT)

    def _answer(self, limit: float) -> Any:
        if not self._pipe.poll(limit):
            self._process.kill()
            self._process.join()
            raise ValueError(f"the function takes longer than {limit:g} s")
        try:
            answer = self._pipe.recv()
        except (EOFError, ConnectionError):
            self._process.join()
            raise ValueError(f"the code {_ending(self._process.exitcode or 0)}") from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def motion(self, case: Mapping[str, Any], part: int) -> Motion:
        """The motion of a case, as a ``Runner`` returns it."""
        if not self._process.is_alive():
            self._start()
        self._pipe.send((case, part))
        return self._answer(CALL_TIMEOUT)


def _serve(place: str, pipe: Connection) -> None:
    """Answer with the motion of each case that arrives, or with the exception of its runner."""
    try:
        runner = step_runner(_imported(place))
        pipe.send(None)
    except ValueError as error:
        pipe.send(error)
        return
    with suppress(EOFError):  # the other process has ended
        while True:
            case, part = pipe.recv()
            try:
                pipe.send(runner(case, part))
            except (ValueError, Unsupported) as error:
                pipe.send(error)


def _imported(place: str) -> Callable[..., Any]:
    file, _, name = place.rpartition(":")
    folder, module = (str(Path(file).parent), Path(file).stem) if file.endswith(".py") else (".", file)
    # the folder stays on the path, because the function may import neighbouring modules when it runs
    sys.path.insert(0, str(Path(folder).absolute()))
    try:
        step = getattr(importlib.import_module(module), name)
        if not callable(step):
            raise TypeError(f"{name} is not a function")
    except Exception as error:  # importing a module may raise any error
        raise ValueError(
            f"'{place}' must name a module and a function in it, such as my_code:step ({error})."
        ) from None
    return step


def _ending(status: int) -> str:
    return f"ends with status {status}" if status >= 0 else f"is ended by signal {-status}"


def _arrays(result: Any) -> Motion:
    """The result of a function as arrays (steps + 1, n), with None for a missing velocity or acceleration."""
    if not isinstance(result, Sequence | np.ndarray) or len(result) not in (2, 3):
        raise ValueError("the function must return u, v and, if available, a")
    motion: dict[str, np.ndarray | None] = {"a": None}
    for name, values in zip("uva", result, strict=False):
        try:
            motion[name] = (
                None if values is None and name != "u" else np.asarray(values, float).reshape(len(values), -1)
            )
        except (TypeError, ValueError):
            raise ValueError(f"{name} must be an array of numbers, with a row for t = 0 and for each step") from None
    return motion


def command_runner(template: str) -> Runner:
    """Runner of a command that reads a case from the file ``{case}`` and writes a table to the file ``{out}``.

    The case describes a single run. For a case of the kind ``order`` the command is called four times, each time with
    another step size.

    Raises
    ------
    ValueError
        If the command does not contain both ``{case}`` and ``{out}``, or its quotes are not closed.
    """
    if "{case}" not in template or "{out}" not in template:
        raise ValueError(f"the command '{template}' must contain {{case}} and {{out}}, for the files of a case.")
    try:
        words = shlex.split(template)
    except ValueError as error:
        raise ValueError(f"the command '{template}' cannot be split into words ({error}).") from None

    def motion(case: Mapping[str, Any], part: int) -> Motion:
        with tempfile.TemporaryDirectory() as folder:
            case_file, out = Path(folder, "case.json"), Path(folder, "out.csv")
            case_file.write_text(json.dumps(divided(case, part)), encoding="utf-8")
            command = [word.replace("{case}", str(case_file)).replace("{out}", str(out)) for word in words]
            status, message = _ended(command)
            if status == SKIPPED:
                raise Unsupported(message)
            if status:
                raise ValueError(f"the command {_ending(status)}{message and ': '}{message[-200:]}")
            if not out.is_file():
                raise ValueError(f"the command writes no file {{out}}{message and ': '}{message[-200:]}")
            return _read(out, case, part)

    return motion


def _ended(command: list[str]) -> tuple[int, str]:
    """Run a command, and return its exit status, negative for a signal, and its standard error."""
    try:
        # in a separate process group, so that a command over its time limit is killed with the programs it has started
        process = subprocess.Popen(
            command, stdin=DEVNULL, stdout=DEVNULL, stderr=PIPE, text=True, errors="replace", start_new_session=True
        )
    except OSError as error:
        raise FileNotFoundError(f"the command '{command[0]}' cannot be started ({error.strerror}).") from None
    try:
        message = process.communicate(timeout=TIMEOUT)[1]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise ValueError(f"the command takes longer than {TIMEOUT:g} s") from None
    return process.returncode, message.strip()


def folder_runner(folder: Path) -> Runner:
    """Runner of the tables ``NAME.csv`` in a folder, with half the step size in ``NAME-2.csv``, and so on.

    Raises
    ------
    ValueError
        If there is no such folder, or the folder contains no table of a case.
    """
    if not folder.is_dir():
        raise ValueError(f"there is no folder '{folder}'.")
    if not any((folder / file.with_suffix(".csv").name).exists() for file in CASES.glob("*.json")):
        raise ValueError(f"the folder '{folder}' has no table of a case, such as A-LIN-AVG.csv.")

    def motion(case: Mapping[str, Any], part: int) -> Motion:
        file = folder / (f"{case['name']}.csv" if part == 1 else f"{case['name']}-{part}.csv")
        if not file.exists():
            raise Unsupported(f"no file {file.name}")
        return _read(file, case, part)

    return motion


def divided(case: Mapping[str, Any], part: int) -> dict[str, Any]:
    """A case without expected values, with its step size divided and its number of steps multiplied by ``part``."""
    run = case["run"]
    if part > 1:
        run = {**run, "dt": repr(float(run["dt"]) / part), "steps": run["steps"] * part}
    return {**{name: case[name] for name in ("name", "problem", "scheme")}, "run": run}


def _read(file: Path, case: Mapping[str, Any], part: int) -> Motion:
    """Motion from the columns t, u1, u2, ..., v1, ..., a1, ... of a CSV file, which may have no v and a."""
    try:
        first, *lines = file.read_text(encoding="utf-8-sig").splitlines()
        rows = [[float(number) for number in line.split(",")] for line in lines if line.strip()]
        names = [name.strip() for name in first.split(",")]
        columns = dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))
    except ValueError:
        raise ValueError(
            f"{file.name} must have a line of names and rows with as many numbers, separated by commas"
        ) from None
    names_by_quantity = {name: [f"{name}{i + 1}" for i in range(len(case["problem"]["u0"]))] for name in "uva"}
    if missing := [name for name in ("t", *names_by_quantity["u"]) if name not in columns]:
        raise ValueError(f"{file.name} has no column {missing[0]}")
    motion = {
        name: np.column_stack([columns[column] for column in parts]) if set(parts) <= set(columns) else None
        for name, parts in names_by_quantity.items()
    }
    return _checked(case, part, motion, columns["t"])


def _checked(case: Mapping[str, Any], part: int, motion: Motion, t: np.ndarray | None = None) -> Motion:
    dt, steps = times(case, part)
    ends = np.append(0.0, np.cumsum(dt)) if np.ndim(dt) else dt * np.arange(steps + 1)
    shape = steps + 1, len(case["problem"]["u0"])
    for name, values in motion.items():
        if values is not None and values.shape != shape:
            raise ValueError(f"{name} has the shape {values.shape}, not {shape}: a row for t = 0 and for each step")
    if t is not None and (wrong := np.flatnonzero(~(abs(t - ends) < np.min(dt) / 100))).size:
        raise ValueError(f"t is {t[wrong[0]]:g} after {wrong[0]} steps, and not {ends[wrong[0]]:g}")
    return motion
