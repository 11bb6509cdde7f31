"""From the problems to the manuscript: references, experiments, figures, tables, ledger of claims, PDF and site.

Every experiment, figure, table and claim declares in its own file what it reads, how it is called and what it asks of
the configuration. The planner turns these declarations into steps, and every step becomes a rule. `snakemake` makes
everything but the site, which `snakemake site` makes.
"""

import os
import sys

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version
from study.io import write

min_version("9.15")


configfile: f"{workflow.basedir}/config/study.yaml"


report: "paper/pages/workflow.rst"


ROOT = os.path.relpath(workflow.basedir)  # relative, so that a project that is moved stays made
BIN = os.path.dirname(sys.executable)
# the commands run with this Python and find the project wherever the results are made
os.environ |= {
    "PATH": os.pathsep.join([BIN, *os.get_exec_path()]),
    "STUDY_BIN": BIN,
    "PYTHONPATH": workflow.basedir,
    "PYTHONSAFEPATH": "1",
    # the study needs all settings, also where the user declines some for other runs
    "STUDY_SETTINGS": "precision,compiler,cache",
}
sys.path.insert(0, workflow.basedir)

from pipeline.start import Refused, begun, planned

try:
    plan = planned(ROOT, config)
except Refused as error:
    raise WorkflowError(str(error))


onstart:
    global run  # what it holds ends with this process, however that ends
    try:
        run = begun(config, workflow.local_exec)
    except Refused as error:
        raise WorkflowError(str(error))


rule all:
    default_target: True
    input:
        plan["products"],
    message:
        "everything is made; see results/manuscript.pdf and results/explorer.html"


def in_report(output, listed):
    """An output that the report of Snakemake lists, with its heading and label by job."""
    return report(
        output,
        category=lambda wildcards: listed[wildcards.get("job", "")][0],
        labels=lambda wildcards: {"content": listed[wildcards.get("job", "")][1]},
    )


for step in plan["steps"]:
    kept, listed = temp if step["temporary"] else str, step["report"]
    several = any("{job}" in output for output in step["outputs"])
    name = step["name"] + ("_{job}" if several else "")

    rule:
        name:
            step["name"]
        group: step["group"]
        localrule: step["quick"]  # on a cluster it stays where Snakemake is
        input:
            lambda wildcards, jobs=step["jobs"]: jobs[wildcards.get("job", "")]["inputs"],
        output:
            *(in_report(kept(one), listed[one]) if one in listed else kept(one) for one in step["outputs"]),
        params:
            script=f"{ROOT}/pipeline/job.py",
            command=lambda wildcards, jobs=step["jobs"]: jobs[wildcards.get("job", "")]["command"],
        log:
            f"results/logs/{name}.log",
        benchmark:
            f"results/benchmarks/{name}.tsv"
        conda:
            "config/environment.yaml"  # for --sdm conda only
        wildcard_constraints:
            job="|".join(step["jobs"]),
        # what measures times has the machine alone: all cores of this one, or a node of a cluster
        threads: lambda wildcards, alone=step["alone"]: workflow.cores if alone and workflow.local_exec else 1
        resources:
            **({"slurm_extra": "'--exclusive'"} if step["alone"] else {}),
            **({"paper": 1} if step["group"] else {}),  # which a cluster draws one by one, in one job
        message:
            step["message"] + (": {wildcards.job}" if several else "")
        shell:
            "python -S {params.script} {params.command} > {log} 2>&1"
