"""``study.opensees``: a model of OpenSees as a program."""

import hashlib
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from study.program import opensees_run
from study.program.command import Command
from study.program.definition import Program
from study.program.opensees_run import INTEGRATORS
from study.registry import UnknownName, did_you_mean
from study.scheme.named import schemes as schemes_by_name

#: Key of ``INTEGRATORS`` for each name of an integrator in OpenSees. If several keys have this integrator, the first
#: key is taken.
_NAMES = {integrator.words[0]: name for name, integrator in reversed(INTEGRATORS.items())}


def _name(scheme: str) -> str:
    """Key of ``INTEGRATORS`` for a scheme that is given by its name in OpenSees or in the study."""
    if not isinstance(scheme, str):
        raise TypeError(
            f"a scheme of OpenSees must be a name, such as 'hht_alpha', not an object of {type(scheme).__name__}."
        )
    name = _NAMES.get(scheme, scheme)
    if name not in INTEGRATORS and name in schemes_by_name:
        name = schemes_by_name.resolve(name)
    if name not in INTEGRATORS:
        raise UnknownName(f"OpenSees has no scheme {scheme!r}; {did_you_mean(scheme, INTEGRATORS)}")
    return name


def opensees(
    file: str | Path, schemes: Sequence[str], duration: float, *, time_limit: float | None = None, **options: Any
) -> Program:
    """A model of OpenSees as a program, for :func:`study.assess`.

    The extra ``opensees`` of this package installs OpenSees. Each run is a separate process.

    Parameters
    ----------
    file
        A file of Python that defines a function and a dict. The function ``build(ops)`` makes the model in the
        interpreter ``ops``, with its masses, damping and patterns. If it applies gravity, it must end with
        ``ops.loadConst("-time", 0.0)``, because :func:`study.assess` refuses a model whose clock is not at zero. The
        dict ``quantities`` maps the name of each quantity to a function of ``ops`` that returns a number, such as
        ``{"roof": lambda ops: ops.nodeDisp(5, 1)}``. The file does not define the transient analysis. Newton's
        iteration ends when the norm of the correction is at most 1e-10, or ``tolerance`` if the file defines it.
    schemes
        Names of schemes of the study, such as ``"average_acceleration"``, ``"hht_alpha"`` or ``"bathe"``, or of
        OpenSees' integrators, such as ``"Newmark"``, ``"TRBDF2"`` or ``"CentralDifference"``.
    duration, time_limit
        As for :func:`study.command`.
    **options
        Further parameters of :class:`study.Program`.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    KeyError
        If OpenSees has no such scheme.
    TypeError, ValueError
        If a scheme is not a name, or another argument is invalid.
    ImportError
        If OpenSees is not installed.
    """
    if not Path(file).is_file():
        raise FileNotFoundError(f"there is no file '{file}' with a model of OpenSees.")
    names = [_name(scheme) for scheme in ([schemes] if isinstance(schemes, str) else schemes)]
    opensees_run.interpreter()
    words = [sys.executable, "-m", opensees_run.__name__, str(Path(file).resolve())]
    driver = hashlib.sha256(Path(opensees_run.__file__).read_bytes()).hexdigest()
    template = f"{shlex.join(words)} {{scheme}} {{dt}} {{duration}} {{output}}"
    run = Command(Path(file).stem, template, duration, time_limit, driver, opensees_run.UNFIT_CODE)
    return Program(run, names, duration, **options)
