"""From the problems to the manuscript: references, experiments, figures, tables, ledger of claims, PDF.

Every experiment, figure, table and claim declares in its own file what it reads, how it is called and what it asks of
the configuration. Three commands turn these declarations into a plan of steps, and every step becomes a rule. The site
is no part of what is made by default: ``snakemake site`` makes it.
"""

import atexit
import hashlib
import json
import os
import runpy
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import psutil
import yaml

from snakemake.cli import get_argument_parser
from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

min_version("9.0")


configfile: f"{workflow.basedir}/config/study.yaml"


report: "paper/pages/workflow.rst"


PROJECT = workflow.basedir
HERE = Path.cwd()  # where the results are made; of a call with --directory, Snakemake leaves it before it ends
ROOT = os.path.relpath(PROJECT)  # relative, so that a project that is moved stays made
# the commands run with this Python and find the project wherever the results are made
os.environ |= {
    "PATH": os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]),
    "PYTHONPATH": PROJECT,
    "PYTHONSAFEPATH": "1",
    # the study needs all settings, also where the user declines some for other runs
    "STUDY_SETTINGS": "precision,compiler,cache",
}


def printed_by(*command, given=None):
    """What a command of this Python prints; the workflow ends with its sentence if it refuses something."""
    done = subprocess.run([sys.executable, *map(str, command)], input=given, capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        raise WorkflowError("\n".join(lines) if "Traceback" in done.stderr else lines[-1])
    return done.stdout


def script(name, *arguments):
    """What a script of the pipeline prints; it imports nothing of the study, which takes a second."""
    return printed_by(f"{PROJECT}/study/pipeline/{name}.py", *arguments)


writing = runpy.run_path(f"{PROJECT}/study/writing.py")  # by itself: the package takes a second
whole, lack_of_room = writing["whole"], writing["lack_of_room"]


def planned():
    """The plan of datasets, paper and site, which is kept until a source or the configuration changes."""
    text = yaml.safe_dump(config, sort_keys=False)
    sources = sorted(path for room in ("study", "reference", "paper", "docs") for path in Path(PROJECT, room).rglob("*.py"))
    sources += sorted(Path(PROJECT, "docs").rglob("*.md"))  # pages name what they read
    key = hashlib.sha256("\0".join([sys.version, PROJECT, ROOT, text]).encode())
    for path in sources:
        key.update(str(path).encode() + path.read_bytes())
    kept = Path(".snakemake", "plans", f"{key.hexdigest()}.json")
    with suppress(OSError, ValueError):  # there is none yet, or it is damaged
        return json.loads(kept.read_text())
    data = printed_by("-m", "study.pipeline.plan", ROOT, text)
    paper = printed_by("-m", "paper.plan", ROOT, given=data)
    site = printed_by("-m", "docs.plan", ROOT, given=data)
    plan = dict(zip(("data", "paper", "site"), map(json.loads, (data, paper, site)))) | {"configuration": config}
    with whole(kept) as unfinished:
        unfinished.write_text(json.dumps(plan))
    return plan


def keep_plan():
    """Keep the plan of a run that could start, and was no dry one, as that of the results: the archive reads it."""
    if workflow.scheduler is None or workflow.dryrun:
        return
    try:
        with whole(HERE / ".snakemake/plans/last.json") as unfinished:
            unfinished.write_text(json.dumps(PLAN))
    except OSError as error:
        print(error, file=sys.stderr)


def tell_of_room():
    """Say that the disk is full as the last thing: Snakemake cannot tell well that it lacks room for its records."""
    if lacking := lack_of_room(HERE / "results", HERE / ".snakemake"):
        print(lacking, file=sys.stderr)


for folder in ("results", "results/logs", "results/benchmarks", ".snakemake", ".snakemake/products"):
    try:
        Path(folder).mkdir(exist_ok=True)
        writable = os.access(folder, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        raise WorkflowError(f"the folder '{Path(folder).absolute()}' cannot be made or written; run where it can.")
if lacking := lack_of_room(HERE / "results", HERE / ".snakemake"):
    raise WorkflowError(lacking)


# calls that make nothing, so that they may look while another run is at work
LOOKS = """
    dryrun dag rulegraph filegraph d3dag report summary detailed_summary lint unlock print_compilation
    list_rules list_target_rules list_changes list_input_changes list_params_changes list_untracked
""".split()


def makes_something():
    """Whether this call makes products, by its options, which Snakemake does not tell a snakefile in time."""
    asked, _ = get_argument_parser().parse_known_args(sys.argv[1:])
    return not any(getattr(asked, option, None) for option in LOOKS)


enters = workflow.is_main_process and makes_something()
if enters:
    atexit.register(tell_of_room)  # the first that is registered is the last that is called
    run, told = json.loads(script("runs", os.getpid()))
    if run is None:
        raise WorkflowError(" ".join(told))
    # what is left of a run that died tells the next one of it
    atexit.register((HERE / ".snakemake" / "runs" / f"{run}.json").unlink, missing_ok=True)
    os.environ |= {"STUDY_RUN": run}
    for sentence in (*told, *script("products", "changed").splitlines()):
        print(sentence, file=sys.stderr)


PLAN = planned()
DATA, PAPER, SITE = (PLAN[part] for part in ("data", "paper", "site"))
if enters:
    atexit.register(keep_plan)


def end_jobs():
    """Start no further jobs, and end those that run, by force after two seconds: one that compiles does not listen."""
    workflow.scheduler.exit_gracefully()
    patience = time.monotonic() + 2
    while True:
        for job in psutil.Process().children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                job.terminate() if time.monotonic() < patience else job.kill()
        time.sleep(0.2)


def end(number, frame):
    """End this run; a second Ctrl-C ends it wherever it is."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if workflow.local_exec:
        # not here, where the scheduler may hold its lock
        threading.Thread(target=end_jobs, daemon=True).start()
        return
    for job in psutil.Process().children(recursive=True):  # the quick ones, which no node has
        with suppress(psutil.NoSuchProcess):
            job.terminate()
    raise KeyboardInterrupt  # on which Snakemake cancels the jobs of a cluster


onstart:
    if workflow.local_exec:
        # to keep to a rate of jobs that is never reached here, Snakemake 9.27 weighs all waiting jobs again every second,
        # once for every job that has started
        workflow.scheduler.job_rate_limiter = None
    else:
        # before it ends, Snakemake would wait for its next look at the queue, up to 40 seconds
        workflow.scheduler._executor.wait_thread.join = lambda: None
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)


def put_aside(job):
    """Rename the products that a failed job could not use, so that the next call makes them again."""
    said = Path(job.log[0]).read_text(errors="replace") if job.log and Path(job.log[0]).exists() else ""
    unusable = [product for product in job.input if f"'{product}' cannot be used" in said and os.path.exists(product)]
    if unusable:
        print(script("products", "aside", *unusable), end="", file=sys.stderr)
        Path(".snakemake", "again").touch()


onerror:
    jobs = [job for failed in workflow.scheduler.failed for job in getattr(failed, "jobs", [failed])]  # also of groups
    for job in jobs:
        # Snakemake puts back the files that a failed job was to replace, and they look new; with an old date and without
        # a record of their making, the next call makes them again
        for product in filter(os.path.exists, job.output):
            os.utime(product, (1, 1))
            workflow.persistence.cleanup_metadata(product)
    for job in jobs:
        put_aside(job)
    if not workflow.local_exec:
        script("runs", "cancel")  # jobs that were on their way to the queue when this run was ended


rule all:
    default_target: True
    input:
        PAPER["products"],
        [f"results/{name}.nc" for name in DATA["datasets"]],
        DATA["pages"],
    message:
        "everything is made; see results/manuscript.pdf and results/explorer.html"


def in_report(output, listed):
    """An output that the report of Snakemake lists, with its heading and label by job."""
    return report(
        output,
        category=lambda wildcards: listed[wildcards.get("job", "")][0],
        labels=lambda wildcards: {"content": listed[wildcards.get("job", "")][1]},
    )


for step in [*DATA["steps"], *PAPER["steps"], *SITE["steps"]]:
    # an output is an update: when a job fails, what was there before stays
    kept = temp if step.get("temporary") else update
    listed = step.get("report", {})
    outputs = [in_report(kept(one), listed[one]) if one in listed else kept(one) for one in step["outputs"]]
    several = any("{job}" in output for output in step["outputs"])
    name = step["name"] + ("_{job}" if several else "")

    rule:
        name:
            step["name"]
        group: step.get("group")
        localrule: step.get("quick", False)  # on a cluster it stays where Snakemake is
        input:
            lambda wildcards, jobs=step["jobs"]: jobs[wildcards.get("job", "")]["inputs"],
        output:
            *outputs,
        params:
            command=lambda wildcards, jobs=step["jobs"]: jobs[wildcards.get("job", "")]["command"],
            note=f".snakemake/products/{name}",
        log:
            f"results/logs/{name}.log",
        benchmark:
            f"results/benchmarks/{name}.tsv"
        conda:
            "config/environment.yaml"  # for --sdm conda only
        wildcard_constraints:
            job="|".join(step["jobs"]),
        # what measures times has the machine alone: all cores of this one, or a node of a cluster
        threads: lambda wildcards, alone=step.get("alone"): workflow.cores if alone and workflow.local_exec else 1
        resources:
            **({"slurm_extra": "'--exclusive'"} if step.get("alone") else {}),
            **({"paper": 1} if step.get("group") else {}),  # which a cluster draws one by one, in one job
        message:
            step["message"] + (": {wildcards.job}" if several else "")
        shell:
            # a job that does not end well leaves no note of what it has made
            "{{ rm -f {params.note}; {params.command} && cksum {output} > {params.note}; }} > {log} 2>&1"
