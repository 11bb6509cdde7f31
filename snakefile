"""From the problems to the manuscript: references, experiments, figures, tables, ledger of claims, PDF and site.

Every experiment, figure, table and claim declares in its own file its inputs, its name and its requirements on the
configuration. The planner turns these declarations into steps, and every step becomes a rule. `snakemake` makes
everything but the site, which `snakemake site` makes.
"""

import logging
import os
import sys

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

min_version("9.27")

# the folder of this file, also if workflow/Snakefile includes it
PROJECT = str(workflow.current_basedir)


configfile: f"{PROJECT}/config/study.yaml"


report: "paper/pages/workflow.rst"


ROOT = os.path.relpath(PROJECT)  # relative, so that a moved project stays up to date
BIN = os.path.dirname(sys.executable)
# the commands run with this Python and find the project wherever the results are made
os.environ |= {
    "PATH": os.pathsep.join([BIN, *os.get_exec_path()]),
    "STUDY_BIN": BIN,
    "PYTHONPATH": PROJECT,
    "PYTHONSAFEPATH": "1",
    # the study needs all settings, even if the user disables some for other runs
    "STUDY_SETTINGS": "precision,compiler,cache",
}
sys.path.insert(0, PROJECT)
# on a full disk each line that Snakemake cannot write to its log would print a traceback
logging.raiseExceptions = False

from pipeline.start import Refused, begun, planned

try:
    plan = planned(ROOT, config)
except Refused as error:
    raise WorkflowError(str(error))


onstart:
    global run  # its handles close when this process ends, even if it is killed
    try:
        # the worker is for jobs on this machine; a cluster's nodes cannot reach it
        run = begun(config, workflow.local_exec)
    except Refused as error:
        raise WorkflowError(str(error))


rule all:
    default_target: True
    input:
        plan["products"],
    message:
        "everything is made; see results/manuscript.pdf and results/explorer.html"


for step in plan["steps"]:
    kept, listed = temp if step["temporary"] else str, step["report"]
    several = any("{job}" in output for output in step["outputs"])
    name = step["name"] + ("_{job}" if several else "")

    rule:
        name:
            step["name"]
        input:
            lambda wildcards, jobs=step["jobs"]: jobs[wildcards.get("job", "")][
                "inputs"
            ],
        output:
            *(
                # the report of Snakemake lists these outputs with heading and label by job
                (
                    report(
                        kept(file),
                        category=lambda wildcards, jobs=listed[file]: jobs[
                            wildcards.get("job", "")
                        ][0],
                        labels=lambda wildcards, jobs=listed[file]: {
                            "content": jobs[wildcards.get("job", "")][1]
                        },
                    )
                    if file in listed
                    else kept(file)
                )
                for file in step["outputs"]
            ),
        log:
            f"results/logs/{name}.log",
        wildcard_constraints:
            job="|".join(step["jobs"]),
        group:
            step["group"]
        localrule: step["quick"]  # on a cluster it runs next to Snakemake
        conda:
            "config/environment.yaml"  # for --sdm conda only
        # jobs that measure times run alone: on all cores of this machine, or on a node of a cluster
        threads:
            lambda wildcards, alone=step["alone"]: (
                workflow.cores if alone and workflow.local_exec else 1
            )
        resources:
            **({"slurm_extra": "'--exclusive'"} if step["alone"] else {}),
            **({"paper": 1} if step["group"] else {}),  # a cluster runs these one by one, in one job
        params:
            script=f"{ROOT}/pipeline/job.py",
            # Snakemake's own benchmark would measure the script only, and not the job in the worker's child
            measured=f"results/benchmarks/{name}.tsv",
            command=lambda wildcards, jobs=step["jobs"]: jobs[
                wildcards.get("job", "")
            ]["command"],
        message:
            step["message"] + (": {wildcards.job}" if several else "")
        shell:
            "python -S {params.script} {params.measured} {params.command} > {log} 2>&1"
