"""From the problems to the manuscript: references, experiments, figures, tables, ledger of claims, PDF.

Every experiment, figure, table and claim declares where it stands what it reads and what it asks of the configuration;
the rules follow from these declarations.
"""

import os
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

min_version("9.0")


configfile: f"{workflow.basedir}/config/study.yaml"


PROJECT = workflow.basedir
sys.path.insert(0, PROJECT)
from paper import products
from study.datasets import check_writable
from study.pipeline import configuration
from study.pipeline.experiment import discover
from study.pipeline.sources import Sources
from study.pipeline.steps import Job, Step, command, dataset, steps_of

try:
    EXPERIMENTS, PRODUCTS = discover("reference", "study.experiments"), products.discover()
    config = configuration.check(EXPERIMENTS, config)
    DATASETS = configuration.datasets_of(EXPERIMENTS, config)
    products.check(PRODUCTS, config)
    check_writable("results/any")
except (ValueError, KeyError, SystemExit) as error:
    raise WorkflowError(str(error)) from None

# the commands run with this Python and find the project wherever the results are made
os.environ |= {
    "PATH": os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]),
    "PYTHONPATH": PROJECT,
    "PYTHONSAFEPATH": "1",
}
ROOT = Path(os.path.relpath(PROJECT))  # relative, so that a project that is moved stays made
SOURCES = Sources(ROOT, "study", "reference", "paper")
FORMATS = {"figure": ("pdf", "png", "svg"), "table": ("csv", "tex"), "page": ("html",)}
FOLDERS = {"figure": "results/figures/", "table": "results/tables/", "page": "results/"}
CATEGORIES = {"figure": "Figures", "table": "", "page": "Maps of stability"}


def files_of(product):
    """The files that a product is made of."""
    printed = sorted((ROOT / "paper" / "published").glob("*.csv"))
    paths = SOURCES.of(product.module, "paper.products")
    printed = printed if ROOT / "paper" / "published" / "__init__.py" in paths else []
    return (*(f"results/{name}" for name in product.files), *map(str, paths), *map(str, printed))


def step_of(kind):
    """The step that makes all figures, tables or pages."""
    chosen = [one for one in PRODUCTS if one.kind == kind]
    return Step(
        name=kind,
        message=kind,
        outputs=tuple(f"{FOLDERS[kind]}{{job}}.{form}" for form in FORMATS[kind]),
        jobs={
            one.name: Job(
                command("paper.products", one.module, one.name, "results", f"{FOLDERS[kind]}{one.name}.{FORMATS[kind][0]}"),
                files_of(one),
            )
            for one in chosen
        },
        captions={one.name: one.caption for one in chosen},
        category=CATEGORIES[kind],
    )


def step_of_all(name, output, kind):
    """The step that makes one file of everything of a kind."""
    files = dict.fromkeys(file for one in PRODUCTS if one.kind == kind for file in files_of(one))
    return Step(name, name, (output,), {"": Job(command(f"paper.{name}", "results", output), tuple(files))})


def made_by(*steps):
    """All files that steps make."""
    return [output.replace("{job}", job) for step in steps for output in step.outputs for job in step.jobs]


PAPER = [step_of(kind) for kind in FORMATS]
PAPER += [step_of_all("claims", "results/claims.csv", "claim"), step_of_all("numbers", "results/numbers.json", "numbers")]
#: Formats that the manuscript reads.
READ_BY_TEXT = (".pdf", ".csv", ".json")
TEXT = [str(ROOT / "paper" / name) for name in ("manuscript.typ", "references.bib")]
MANUSCRIPT = Step(
    "manuscript",
    "manuscript",
    ("results/manuscript.pdf",),
    {
        "": Job(
            command("paper.compile", "results", "results/manuscript.pdf"),
            (*(file for file in made_by(*PAPER) if file.endswith(READ_BY_TEXT)), *TEXT, *map(str, SOURCES.of("paper.compile"))),
        )
    },
)


onerror:
    # what was there before a failed job is put back, and looks new; an old date and no record of how it was made have
    # it made anew next time, whatever the cause of the failure
    for job in workflow.scheduler.failed:
        for product in job.output:
            if Path(product).exists():
                os.utime(product, (1, 1))
                workflow.persistence.cleanup_metadata(product)


rule all:
    default_target: True
    input:
        "results/manuscript.pdf",
        made_by(*PAPER),
        [dataset(name) for name in DATASETS],
    message:
        "everything is made; see results/manuscript.pdf and results/explorer.html"


for step in [*steps_of(EXPERIMENTS, config, SOURCES), *PAPER, MANUSCRIPT]:
    # an output is an update: when a job fails, what was there before stays
    kept = temp if step.temporary else update
    *others, last = (kept(output) for output in step.outputs)
    if step.category:
        last = report(last, caption="paper/figures/caption.rst", category=step.category)
    suffix = "_{job}" if any("{job}" in output for output in step.outputs) else ""

    rule:
        name:
            step.name
        input:
            lambda wildcards, jobs=step.jobs: jobs[wildcards.get("job", "")].inputs,
        output:
            *others,
            last,
        params:
            command=lambda wildcards, jobs=step.jobs: jobs[wildcards.get("job", "")].command,
            caption=lambda wildcards, captions=step.captions: captions.get(wildcards.get("job", ""), ""),
        log:
            f"results/logs/{step.name}{suffix}.log",
        benchmark:
            f"results/benchmarks/{step.name}{suffix}.tsv"
        conda:
            "config/environment.yaml"  # for --sdm conda only
        wildcard_constraints:
            job="|".join(step.jobs),
        threads: workflow.cores if step.alone else 1
        message:
            f"{step.message} {{wildcards.job}}" if suffix else step.message
        shell:
            "{params.command} > {log} 2>&1"
