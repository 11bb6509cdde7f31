"""``study.Program``: a model in another program."""

import hashlib
import inspect
import math
import pickle
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from study.algebra.scalars import is_number, is_whole
from study.observer.motion import Quantity
from study.program.attempt import Runnable

#: Default number of steps of a run with the coarsest step, and of a run with the finest step.
FEWEST_STEPS, MOST_STEPS = 16, 2**17


@dataclass(frozen=True)
class Program:
    """A model in another program, for :func:`study.assess`.

    The program may be anything that marches with a fixed step: a function of NumPy, a simulation in another process, a
    finite element code.
    :func:`study.opensees` makes a program from a model of OpenSees, and :func:`study.command` from an executable.

    Every run is kept on disk for an assessment that is repeated or continued. The source of a program identifies its
    runs: the file that contains ``run`` and the data that ``run`` holds. Other files and variables that the program
    reads are not part of the source. Every assessment therefore repeats one kept run of each scheme, and discards all
    kept runs with a warning if it differs. A change that this run does not show needs another ``name``.

    Parameters
    ----------
    run
        ``run(scheme, dt)`` runs the program with a scheme and a step in s up to ``duration``. It returns a mapping from
        names to quantities: arrays along its times ``t``, of shape (t,) or (t, components), and single numbers such as
        a peak. The components of an array share the scale of errors, so components of different units should be
        quantities of their own. The times are the ends of all steps, or of every n-th step. A program that measures its
        computing time in s returns it as ``seconds``. An exception is recorded and ends only that run.
    schemes
        Names of schemes for ``run``, at least two including the witnesses. If the study has a scheme of the same name,
        the assessment takes the title of the study's scheme, and whether it is explicit or implicit.
    duration
        Simulated time of every run in s.
    spacing
        Time in s between the samples of a record. If it is given, all steps are integer fractions of it.
    coarsest, finest
        Largest and smallest step in s. The default largest step is the spacing, or a sixteenth of the duration if no
        spacing is given. The default smallest step is the duration divided by 131,072.
    witnesses
        Names of further schemes, which only serve to find the reference.
    name
        Title of the program. If it is given, it identifies the runs in place of the source.
    folder
        Folder in which runs are kept, by default in the user's cache folder.
    workers
        Number of runs at once, by default the number of cores. Runs are made in other processes if ``run`` can be
        pickled, as a function in a file can. A script then needs ``if __name__ == "__main__":``. If ``run`` cannot be
        pickled, if it reads variables that other processes do not have, or if ``workers`` is 1, runs are made one after
        the other in this process.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> def run(scheme, dt):
    ...     '''The oscillator ü + u = 0 from u = 1 at rest.'''
    ...     t, u, v = np.arange(0, 10 + dt / 2, dt), [1.0], [0.0]
    ...     for _ in t[1:]:
    ...         if scheme == "symplectic_euler":
    ...             v.append(v[-1] - dt * u[-1])
    ...             u.append(u[-1] + dt * v[-1])
    ...         else:
    ...             v.append(((1 - dt**2 / 4) * v[-1] - dt * u[-1]) / (1 + dt**2 / 4))
    ...             u.append(u[-1] + dt * (v[-1] + v[-2]) / 2)
    ...     return {"t": t, "displacement": u}
    >>> schemes = ["average_acceleration", "symplectic_euler"]
    >>> program = Program(run, schemes, duration=10.0)
    """

    run: Runnable
    schemes: Sequence[str]
    duration: float
    _: KW_ONLY
    spacing: float | None = None
    coarsest: float | None = None
    finest: float | None = None
    witnesses: Sequence[str] = ()
    name: str | None = None
    folder: str | Path | None = None
    workers: int | None = None

    def __post_init__(self):
        if not callable(self.run):
            raise TypeError(f"run must be a function of the name of a scheme and a step, not {self.run!r}.")
        for key in ("schemes", "witnesses"):
            names = getattr(self, key)
            if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(n, str) for n in names):
                raise TypeError(f"{key} must be a list of names, such as ['newmark', 'hht'], not {names!r}.")
        if not self.schemes or len(set(self.all_schemes)) < max(2, len(self.all_schemes)):
            raise ValueError(
                f"schemes must be at least two different names, not {self.all_schemes}: the reference is the motion on "
                "which two schemes agree."
            )
        for key in ("duration", "spacing", "coarsest", "finest"):
            value = getattr(self, key)
            if not (value is None and key != "duration") and not (is_number(value) and 0 < value < np.inf):
                raise ValueError(f"{key} must be a time in s greater than zero, not {value!r}.")
        if not isinstance(self.name, str | None):
            raise TypeError(f"name must be a string, not {self.name!r}.")
        if self.workers is not None and not is_whole(self.workers, 1):
            raise ValueError(f"workers must be a whole number greater than zero, not {self.workers!r}.")
        if self.largest > self.duration / 2 or self.smallest >= self.largest:
            raise ValueError(
                f"steps from {self.largest:g} s down to {self.smallest:g} s do not fit a duration of {self.duration:g} "
                "s; give a coarsest step of at most half the duration, and a smaller finest step."
            )

    @property
    def all_schemes(self) -> list[str]:
        """Names of the schemes and the witnesses."""
        return [*self.schemes, *self.witnesses]

    @property
    def largest(self) -> float:
        """The coarsest step, in s."""
        return self.fitted(self.coarsest or self.spacing or self.duration / FEWEST_STEPS)

    @property
    def smallest(self) -> float:
        """The finest step, in s."""
        return self.finest or self.duration / MOST_STEPS

    def fitted(self, step: float) -> float:
        """The largest integer fraction of the spacing up to ``step``; ``step`` itself if there is no spacing."""
        return self.spacing / math.ceil(self.spacing / step * (1 - 1e-9)) if self.spacing else step

    @property
    def title(self) -> str:
        """The name of the program, or the title or name of ``run``."""
        run_title = getattr(self.run, "title", None) or getattr(self.run, "__name__", type(self.run).__name__)
        return self.name or str(run_title)

    @property
    def quantities(self) -> dict[str, Quantity]:
        """The quantities of a problem that runs as a program, by name; they state the scales of errors."""
        return {
            quantity.name: quantity
            for quantity in getattr(self.run, "quantities", ())
            if isinstance(quantity, Quantity)
        }

    @property
    def place(self) -> Path:
        """The folder in which the runs are kept."""
        return Path(self.folder or platformdirs.user_cache_path("time-integration-study") / "programs")

    def identity(self) -> str:
        """Digest of the program's name, or otherwise of its source, which identifies the runs.

        Raises
        ------
        ValueError
            If the program has no name, and its source cannot be read.
        """
        if self.name is not None:
            return hashlib.sha256(self.name.encode()).hexdigest()
        try:
            return hashlib.sha256(repr(_source(self.run)).encode()).hexdigest()
        except (OSError, TypeError, pickle.PicklingError, AttributeError) as error:
            raise ValueError(
                f"the runs of '{self.title}' cannot be distinguished from runs of other programs, because its "
                f"source cannot be read ({error}); give the program a name."
            ) from None


def data_read(run: Any) -> dict[str, bytes]:
    """Pickled variables of modules that a function and the functions it calls read, by name.

    Variables that cannot be pickled, such as modules, are left out, and so are functions of other files.
    """
    pickled: dict[str, bytes] = {}
    seen: set[Any] = set()
    waiting = [run]
    while waiting:
        candidate = waiting.pop()
        candidate = candidate.func if isinstance(candidate, partial) else getattr(candidate, "__func__", candidate)
        function = candidate if inspect.isroutine(candidate) else type(candidate).__call__
        code = getattr(function, "__code__", None)
        if code is None or code in seen:
            continue
        seen.add(code)
        codes = [code]
        for inner in codes:
            codes += [constant for constant in inner.co_consts if inspect.iscode(constant)]
        names = {name for inner in codes for name in inner.co_names}
        for name in sorted(names & function.__globals__.keys()):
            value = function.__globals__[name]
            if inspect.isfunction(value):
                waiting += [value] if value.__module__ == function.__module__ else []
            elif inspect.ismodule(value) or inspect.isclass(value):
                attributes = {key: vars(value)[key] for key in sorted(names & vars(value).keys())}
                pickled |= _pickled({f"{name}.{key}": data for key, data in attributes.items()})
            else:
                pickled |= _pickled({name: value})
    return pickled


def _pickled(data: dict[str, Any]) -> dict[str, bytes]:
    pickled = {}
    for name, value in data.items():
        if not (callable(value) or inspect.ismodule(value)):
            with suppress(pickle.PicklingError, AttributeError, TypeError):
                pickled[name] = pickle.dumps(value)
    return pickled


def _source(run: Any) -> list:
    """The text of the file that contains a function, and the data that the function holds."""
    if isinstance(run, partial):
        return [_source(run.func), pickle.dumps((run.args, run.keywords))]
    if hasattr(run, "source"):
        return [run.source]
    if not inspect.isroutine(run):
        return [_source(type(run).__call__), pickle.dumps(vars(run))]
    if inspect.ismethod(run):
        return [_source(run.__func__), pickle.dumps(run.__self__)]
    file = inspect.getsourcefile(run)
    text = Path(file).read_text(encoding="utf-8") if file and Path(file).is_file() else inspect.getsource(run)
    contents = [cell.cell_contents for cell in getattr(run, "__closure__", None) or ()]
    contents += [getattr(run, key, None) for key in ("__defaults__", "__kwdefaults__")]
    return [
        text,
        run.__qualname__,
        *(_source(content) if inspect.isfunction(content) else pickle.dumps(content) for content in contents),
    ]
