"""Speed of the study: ratios of its times to times of a baseline, measured in turns, mostly on one core.

``make benchmark`` measures the ratios, prints them as a table and writes them to ``results/benchmark.nc``.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import control
import ensembles
import first_calls
import numpy as np
import pandas as pd
import peer
import single_runs
import structures
import xarray as xr
from case import Case

from study.io import provenance, write

#: Number of measured turns of each case, after one turn to warm up; nine give reliable ratios.
REPEATS = int(os.environ.get("REPEATS", "9"))
#: Largest acceptable time to trace and compile, in s.
COMPILE_AT_MOST = 0.3

_COMPILE = """
import sys, time, jax, study
from study.observer.energy import MaxEnergyError
from study.marching.timing import Timed
misses = []
jax.monitoring.register_event_listener(lambda name, **_: misses.append(1) if name.endswith("cache_misses") else None)
jax.jit(lambda x: x + 1)(1.0)
for problem in ("hardening", "softening"):
    for name, scheme in study.schemes.items():
        print(problem, name, Timed(study.problems[problem], scheme, (MaxEnergyError(),)).seconds_to_compile)
print(len(misses))
"""


def compilation() -> pd.DataFrame:
    """Seconds to trace and compile each problem and scheme, and number of compiled programs, in two processes."""
    with tempfile.TemporaryDirectory() as folder:
        # both processes share a new cache; the import of the study has set JAX's variables to the usual cache
        inherited = {name: value for name, value in os.environ.items() if not name.startswith("JAX_")}
        environment = inherited | {"XDG_CACHE_HOME": folder}
        columns = {}
        for process in ("first process", "second process"):
            completed = subprocess.run(
                [sys.executable, "-c", _COMPILE], env=environment, capture_output=True, text=True, check=True
            )
            *lines, compiled = completed.stdout.split("\n")[:-1]
            values = {tuple(line.split()[:2]): float(line.split()[2]) for line in lines}
            columns[process] = pd.Series(values | {("programs", "compiled"): float(compiled)})
    return pd.DataFrame(columns)


def measure(cases: list[Case]) -> xr.Dataset:
    """Times of every case and of its baseline, measured in turns after one turn to warm up, and their ratios."""
    ours, baseline = np.empty((len(cases), REPEATS)), np.empty((len(cases), REPEATS))
    for c, case in enumerate(cases):
        for repeat in range(-1, REPEATS):
            pair = case.ours(), case.baseline()
            if repeat >= 0:
                ours[c, repeat], baseline[c, repeat] = 1e9 * np.array(pair) / case.steps
        print(f"{case.name}: {np.median(ours[c] / baseline[c]):.3f}", flush=True)
    ratio = ours / baseline
    quartiles = np.quantile(ratio, [0.25, 0.75], axis=1)
    dims = ("case", "repeat")
    return xr.Dataset(
        {
            "time": (dims, ours, {"long_name": "time of a step", "units": "ns"}),
            "baseline_time": (dims, baseline, {"long_name": "time of a step of the baseline", "units": "ns"}),
            "ratio": ("case", np.median(ratio, axis=1), {"long_name": "median ratio of the two times", "units": "1"}),
            "spread": (
                "case",
                quartiles[1] - quartiles[0],
                {"long_name": "interquartile range of the ratio", "units": "1"},
            ),
            "target": ("case", [c.target for c in cases], {"long_name": "largest acceptable ratio", "units": "1"}),
        },
        {
            "case": ("case", [c.name for c in cases], {"long_name": "timed case : baseline"}),
            "repeat": ("repeat", np.arange(REPEATS), {"long_name": "repeat", "units": "1"}),
        },
    )


def main(output: Path) -> None:
    """Measure all cases, print a table and write the dataset."""
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        if not peer.compiler():
            print("no C compiler: the comparisons with C are left out; install gcc, or name a compiler in CC.")
        cases = [
            *single_runs.cases(folder),
            *ensembles.cases(folder),
            *structures.cases(),
            *control.cases(),
            *first_calls.cases(),
        ]
        ds = measure(cases)
    table = pd.DataFrame(
        {
            "ns": ds.time.median("repeat").round(1),
            "baseline ns": ds.baseline_time.median("repeat").round(1),
            "ratio": ds.ratio.round(3),
            "±": ds.spread.round(3),
            "at most": ds.target,
            "": np.where(ds.ratio <= ds.target, "", "missed"),
        },
        index=ds.case.values,
    )
    compiled = compilation()
    print(table.to_string(), "\n", compiled.to_string())
    slow = compiled["first process"].drop(index=("programs", "compiled"))
    print(
        f"compiling takes at most {slow.max():.2f} s ({', '.join(slow.idxmax())}); it should take {COMPILE_AT_MOST} s."
    )
    process = ("process", ["first", "second"], {"long_name": "process"})
    times = compiled.drop(index=("programs", "compiled"))
    ds = ds.assign_coords(
        process=process, program=("program", [", ".join(p) for p in times.index], {"long_name": "program"})
    )
    ds["seconds_to_compile"] = (
        ("program", "process"),
        times.values,
        {"long_name": "time to trace and compile", "units": "s"},
    )
    ds.attrs = provenance("Ratios of times, side by side", "tools/benchmarks/benchmark.py")
    write(ds, output)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
