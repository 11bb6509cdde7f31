"""Run a module and write what it took: ``python -m pipeline.measured FILE MODULE ARGUMENT...``."""

import resource
import runpy
import sys
import time
from pathlib import Path


def run(file: str, *command: str) -> None:
    """Run a module with arguments in this process; if it succeeds, write its wall and processor time and its memory.

    The file has the columns ``s`` and ``cpu_time`` in s, and ``max_rss``, the largest memory of the process in MB.
    Processor time includes ended child processes.
    """
    begin = time.monotonic()
    sys.argv = list(command)
    try:
        runpy.run_module(command[0], run_name="__main__", alter_sys=True)
    except SystemExit as end:
        if end.code:
            raise
    seconds = time.monotonic() - begin
    process, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    processor = sum(usage.ru_utime + usage.ru_stime for usage in (process, children))
    Path(file).parent.mkdir(parents=True, exist_ok=True)
    Path(file).write_text(f"s\tcpu_time\tmax_rss\n{seconds:.3f}\t{processor:.3f}\t{_memory():.1f}\n")


def _memory() -> float:
    """Largest memory of this process in MB."""
    try:
        # Linux, whose getrusage may state the memory of the process that started this one
        status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
        return int(status["VmHWM"].split()[0]) / 1024
    except OSError:  # macOS, in bytes
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


if __name__ == "__main__":
    run(*sys.argv[1:])
