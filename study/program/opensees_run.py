"""A run of a model of OpenSees in a separate process, with the arguments ``FILE SCHEME DT DURATION OUTPUT``.

OpenSees has only one model per process, and a failure may end the process.
"""

import importlib
import math
import os
import runpy
import sys
import time
from collections.abc import Callable
from types import ModuleType
from typing import NamedTuple

import numpy as np

from study.program.attempt import Unfit

#: Exit code of the process if no step could run the model.
UNFIT_CODE = 64


class Integrator(NamedTuple):
    """OpenSees' integrator of a scheme, with the settings that it needs.

    Attributes
    ----------
    words
        Name and parameters of the integrator.
    algorithm, system
        Solution algorithm and system of equations.
    parts
        Number of OpenSees' steps in a step of the scheme.
    """

    words: tuple[str | float, ...]
    algorithm: str = "Newton"
    system: str = "UmfPack"
    parts: int = 1


#: Integrators by the study's names, or by OpenSees' names if the study has no such scheme. The names must be correct:
#: for an unknown name, OpenSees takes its default integrator and only prints a note.
INTEGRATORS = {
    "average_acceleration": Integrator(("Newmark", 0.5, 0.25)),
    "newmark_dissipative": Integrator(("Newmark", 0.6, 0.3025)),
    "linear_acceleration": Integrator(("Newmark", 0.5, 1 / 6)),
    "fox_goodwin": Integrator(("Newmark", 0.5, 1 / 12)),
    "wilson_theta": Integrator(("WilsonTheta", 1.4)),
    "houbolt": Integrator(("Houbolt",)),
    "hht_alpha": Integrator(("HHT", 0.9, 0.6, 0.3025)),
    "generalized_alpha": Integrator(("HHTGeneralized", 2 / 3, 5 / 9, 25 / 81, 11 / 18)),
    "bathe": Integrator(("TRBDF2",), parts=2),
    "central_difference": Integrator(("NewmarkExplicit", 0.5), "Linear"),
    "kr_alpha": Integrator(("KRAlphaExplicit", 0.8), "Linear", "FullGeneral"),
    "CentralDifference": Integrator(("CentralDifference",), "Linear"),
    "ExplicitDifference": Integrator(("ExplicitDifference",), "Linear", "Diagonal"),
}

#: Algorithms that are tried one after the other if Newton's iteration does not converge.
OTHERS = (("NewtonLineSearch",), ("KrylovNewton",), ("ModifiedNewton", "-initial"))

#: End of Newton's iteration: default tolerance for the norm of its displacement correction, in the units of the model,
#: and maximum number of iterations.
TOLERANCE, ITERATIONS = 1e-10, 50


def interpreter() -> ModuleType:
    """OpenSees' interpreter.

    Raises
    ------
    ImportError
        If the extra ``opensees`` of this package, or a library that it needs, is not installed.
    """
    try:
        return importlib.import_module("openseespy.opensees")
    except (ImportError, RuntimeError) as error:
        # openseespy raises another error, which hides the name of the missing library
        reason = error.__context__ or error
        raise ImportError(
            "OpenSees is not available: install the extra 'opensees' of this package and the system's libraries BLAS, "
            f"LAPACK and GNU Fortran, on Debian the packages libblas3, liblapack3 and libgfortran5 ({reason})."
        ) from None


def _prepare(ops: ModuleType, integrator: Integrator, tolerance: float) -> None:
    ops.wipeAnalysis()
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system(integrator.system)
    ops.test("NormDispIncr", tolerance, ITERATIONS, 0)
    ops.algorithm(integrator.algorithm)
    ops.integrator(*integrator.words)
    ops.analysis("Transient")


def _step(ops: ModuleType, integrator: Integrator, dt: float) -> None:
    """Take one step; if Newton's iteration fails, try the algorithms ``OTHERS``."""
    for _ in range(integrator.parts):
        failed = ops.analyze(1, dt / integrator.parts)
        for algorithm in OTHERS if failed and integrator.algorithm == "Newton" else ():
            ops.algorithm(*algorithm)
            failed = ops.analyze(1, dt / integrator.parts)
            ops.algorithm(integrator.algorithm)
            if not failed:
                break
        if failed:
            raise ArithmeticError(f"OpenSees finds no balance after t = {ops.getTime():g} s")


def history(file: dict, scheme: str, dt: float, duration: float) -> dict[str, np.ndarray]:
    """Times, elapsed seconds and measured quantities of a run, at its start and after every step.

    Parameters
    ----------
    file
        Values that the user's file defines, by name: ``build``, ``quantities`` and, optionally, ``tolerance``.

    Raises
    ------
    Unfit
        If ``build`` leaves the clock at another time than zero: a record would begin late, and gravity would grow.
    """
    ops, quantities = interpreter(), dict[str, Callable](file["quantities"])
    ops.wipe()
    file["build"](ops)
    if start := ops.getTime():
        raise Unfit(f"build(ops) leaves the clock at {start:g} s, and must end with ops.loadConst('-time', 0.0)")
    _prepare(ops, INTEGRATORS[scheme], file.get("tolerance", TOLERANCE))
    clock = time.perf_counter()
    rows = [[0.0, 0.0, *(measure(ops) for measure in quantities.values())]]
    for _ in range(math.ceil(duration / dt * (1 - 1e-9))):
        _step(ops, INTEGRATORS[scheme], dt)
        rows.append([ops.getTime(), time.perf_counter() - clock, *(measure(ops) for measure in quantities.values())])
    return dict(zip(("t", "seconds", *quantities), np.array(rows, float).T, strict=True))


def main(file: str, scheme: str, dt: str, duration: str, output: str) -> None:
    """Make a run, and write its times, seconds and quantities to a CSV file."""
    columns = history(runpy.run_path(file), scheme, float(dt), float(duration))
    np.savetxt(output, np.stack([*columns.values()], axis=1), "%.17g", ",", header=",".join(columns), comments="")


if __name__ == "__main__":
    code = 0
    try:
        main(*sys.argv[1:])
    except Unfit as error:
        print(error, file=sys.stderr, flush=True)
        code = UNFIT_CODE
    except Exception as error:  # the user's file may raise anything
        print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)
        code = 1
    # at a normal exit OpenSees prints a line, which would hide the reason
    os._exit(code)
