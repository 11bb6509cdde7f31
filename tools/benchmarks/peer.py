"""The schemes in C, which the benchmark compiles."""

import ctypes
import os
import shutil
import subprocess
import time
from functools import cache
from pathlib import Path

import numpy as np

SPRINGS = {"hardening": 0, "softening": 1}
#: The schemes that are written in C.
SCHEMES = (
    "average_acceleration",
    "central_difference",
    "newmark_dissipative",
    "wilson_theta",
    "houbolt",
    "hht_alpha_1996",
    "rk4",
)
_SINGLE = ("-O3", "-march=native")
_ENSEMBLE = ("-O3", "-march=native", "-ffast-math", "-fopenmp-simd")


def compiler() -> str | None:
    """Path of the C compiler; None if there is no compiler."""
    return shutil.which(os.environ.get("CC", "gcc"))


@cache
def _library(spring: str, flags: tuple[str, ...], folder: str) -> ctypes.CDLL:
    target = Path(folder) / f"{spring}{len(flags)}.so"
    source = Path(__file__).with_name("peer.c")
    options = [*flags, f"-DSPRING={SPRINGS[spring]}", "-Wno-unknown-pragmas", "-shared", "-fPIC"]
    subprocess.run([str(compiler()), *options, "-o", target, source, "-lm"], check=True)
    return ctypes.CDLL(str(target))


def single(spring: str, scheme: str, u0: float, dt: float, steps: int, folder: str) -> tuple[float, float]:
    """Seconds of one run in C, and its largest energy error as a fraction."""
    run = getattr(_library(spring, _SINGLE, folder), f"run_{scheme}")
    run.restype = ctypes.c_double
    start = time.perf_counter()
    error = run(ctypes.c_double(u0), ctypes.c_double(dt), ctypes.c_long(steps))
    return time.perf_counter() - start, error


def ensemble(spring: str, u0: np.ndarray, dt: float, steps: int, force, folder: str) -> tuple[float, np.ndarray]:
    """Seconds of an ensemble in C with two Newton iterations in every step, and the displacements at its end."""
    run = _library(spring, _ENSEMBLE, folder).ensemble
    u, v, a, largest = u0.copy(), np.zeros_like(u0), -np.asarray(force(u0)), np.zeros_like(u0)
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (u, v, a, largest)]
    start = time.perf_counter()
    run(ctypes.c_long(len(u0)), ctypes.c_double(dt), ctypes.c_long(steps), *pointers)
    return time.perf_counter() - start, u
