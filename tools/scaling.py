"""Estimated time of a study on many cores, from the measured times of its jobs.

``python tools/scaling.py OUTPUT``, in the folder of a finished study, reads the plan of the pipeline and
``results/benchmarks``. It assigns ready jobs to free cores, first the job with the longest path to the end. It writes a
table OUTPUT.csv and a figure OUTPUT.png of time against cores. The time of a job is its elapsed time or, if shorter,
its processor time, as on one idle core. Figures and pages are drawn one after another. Waiting in a queue and the
exclusive node of timed jobs are not counted. On a node of a cluster each job also imports the study, as it does in a
study that was made with ``snakemake --no-hooks``.

The script also prints entries for ``profiles/slurm``: memory and run time of the rules that need more than the
defaults.
"""

import heapq
import json
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.ticker import LogLocator

#: Numbers of cores.
CORES = (1, 2, 4, 8, 16, 32, 64, 100, 128)
#: Memory in MB and run time in minutes that ``profiles/slurm`` gives every job.
DEFAULT_MEMORY, DEFAULT_MINUTES = 1500, 15
PLAN, BENCHMARKS = Path(".snakemake", "plan.json"), Path("results", "benchmarks")


class Job(NamedTuple):
    """A job: its time, the jobs that make its inputs, and its group, if any, whose jobs run one at a time."""

    name: str
    seconds: float
    after: tuple[str, ...]
    group: str = ""
    rule: str = ""
    memory: float = 0.0


def measured() -> dict[str, Job]:
    """The jobs of the last run's plan except the site, with their measured times.

    Raises
    ------
    SystemExit
        If there is no plan, or a job has no measured time.
    """
    if not PLAN.exists():
        raise SystemExit("there is no finished study in this folder; `make` makes it.")
    steps = [step for step in json.loads(PLAN.read_text())["steps"] if step["name"] != "site"]  # made on request only
    entries = [(step, job, f"{step['name']}_{job}" if job else step["name"]) for step in steps for job in step["jobs"]]
    maker = {output.replace("{job}", job): name for step, job, name in entries for output in step["outputs"]}
    jobs = {}
    for step, job, name in entries:
        file = BENCHMARKS / f"{name}.tsv"
        if not file.exists():
            raise SystemExit(f"the job '{name}' has no measured time in '{BENCHMARKS}'; make the whole study first.")
        inputs = step["jobs"][job]["inputs"]
        after = tuple(dict.fromkeys(maker[source] for source in inputs if source in maker))
        benchmark = pd.read_csv(file, sep="\t").iloc[0]
        seconds = min(benchmark.s, benchmark.cpu_time)
        jobs[name] = Job(name, float(seconds), after, step["group"] or "", step["name"], float(benchmark.max_rss))
    return jobs


def longest_paths(jobs: dict[str, Job]) -> dict[str, float]:
    """Smallest number of seconds from the start of each job to the end of all jobs that depend on it."""
    followers: dict[str, list[str]] = {name: [] for name in jobs}
    for job in jobs.values():
        for before in job.after:
            followers[before].append(job.name)

    @cache
    def length(name: str) -> float:
        return jobs[name].seconds + max(map(length, followers[name]), default=0.0)

    return {name: length(name) for name in jobs}


def critical_path(jobs: dict[str, Job]) -> list[str]:
    """Names of the jobs on the longest path, which no number of cores makes shorter."""
    length = longest_paths(jobs)
    path = [max(length, key=length.__getitem__)]
    while followers := [job.name for job in jobs.values() if path[-1] in job.after]:
        path.append(max(followers, key=length.__getitem__))
    return path


def makespan(jobs: dict[str, Job], cores: int) -> float:
    """Seconds until all jobs are done on a number of cores, if ready jobs with the longest path start first."""
    length, waits = longest_paths(jobs), {name: set(job.after) for name, job in jobs.items()}
    ready = [(-length[name], name) for name, after in waits.items() if not after]
    heapq.heapify(ready)
    running: list[tuple[float, str]] = []
    now = 0.0
    while ready or running:
        busy = {jobs[name].group for _, name in running} - {""}
        waiting = []
        while ready and len(running) < cores:
            first = heapq.heappop(ready)
            job = jobs[first[1]]
            if job.group in busy:
                waiting.append(first)
                continue
            busy |= {job.group} - {""}
            heapq.heappush(running, (now + job.seconds, job.name))
        for entry in waiting:
            heapq.heappush(ready, entry)
        now, done = heapq.heappop(running)
        for name, after in waits.items():
            if done in after:
                after.remove(done)
                if not after:
                    heapq.heappush(ready, (-length[name], name))
    return now


def resources(jobs: dict[str, Job]) -> str:
    """Entries of a profile for rules that need more than its defaults.

    A rule is given at least 1.5 times the memory and three times the run time of its largest and longest jobs.
    """
    rules: dict[str, list[Job]] = {}
    for job in jobs.values():
        rules.setdefault(job.rule, []).append(job)
    lines = ["set-resources:"]
    for rule, members in sorted(rules.items()):
        memory = 500 * -(-1.5 * max(job.memory for job in members) // 500)
        minutes = 5 * -(-3 * max(job.seconds for job in members) / 60 // 5)
        limits = [f"mem_mb: {memory:.0f} * attempt"] if memory > DEFAULT_MEMORY else []
        limits += [f"runtime: {minutes:.0f} * attempt"] if minutes > DEFAULT_MINUTES else []
        lines += [f"  {rule}: {{{', '.join(limits)}}}"] if limits else []
    return "\n".join(lines)


def table(jobs: dict[str, Job]) -> pd.DataFrame:
    """Time against cores, and the part of the cores' time that is idle."""
    work = sum(job.seconds for job in jobs.values())
    rows = [(cores, makespan(jobs, cores)) for cores in CORES]
    return pd.DataFrame(
        {
            "cores": [cores for cores, _ in rows],
            "seconds": [round(seconds, 1) for _, seconds in rows],
            "lost": [round(1 - work / (cores * seconds), 3) for cores, seconds in rows],
        }
    )


def draw(jobs: dict[str, Job], times: pd.DataFrame, output: Path) -> None:
    """Draw time against cores, with the lower bounds by work and by the critical path."""
    path, work = critical_path(jobs), sum(job.seconds for job in jobs.values())
    length = sum(jobs[name].seconds for name in path)
    figure, ax = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    ax.loglog(times.cores, times.seconds, "ko-", label="simulated")
    ax.loglog(times.cores, work / times.cores, "k:", label="nothing lost")
    ax.axhline(length, color="0.5", ls="--", label="critical path")
    named = " →\n".join(path)
    ax.annotate(named, (times.cores.iloc[0], length), (0, -4), textcoords="offset points", fontsize=6, va="top")
    ax.set(xlabel="cores", ylabel="time in s", ylim=(length / 3, None))
    ax.set_xticks(times.cores, map(str, times.cores), fontsize=7)
    ax.tick_params(axis="x", which="minor", bottom=False)
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.tick_params(axis="y", which="minor", left=False, labelleft=False)
    ax.legend(frameon=False)
    figure.savefig(output, dpi=150)


if __name__ == "__main__":
    jobs = measured()
    times = table(jobs)
    Path(f"{sys.argv[1]}.csv").write_text(times.to_csv(index=False))
    draw(jobs, times, Path(f"{sys.argv[1]}.png"))
    print(times.to_string(index=False))
    longest = sorted(jobs.values(), key=lambda job: -job.seconds)[:5]
    print("longest jobs:", ", ".join(f"{job.name} {job.seconds:.0f} s" for job in longest))
    print("critical path:", " → ".join(critical_path(jobs)))
    print(resources(jobs))
