"""From the problems to the manuscript: references, experiments, figures, tables, ledger of claims, PDF."""

import json
import os
import sys

import grimp
from snakemake.utils import min_version

min_version("9.0")


configfile: f"{workflow.basedir}/config/study.yaml"


sys.path.insert(0, workflow.basedir)
from study.configuration import check
from study.schemes import schemes

check(config)

PYTHON = f"{sys.executable} -P"
PROJECT = workflow.basedir
os.environ["PYTHONPATH"] = PROJECT


# ---------------------------------------------------------------------------------------------------------------------
# What a rule depends on: the modules that its command imports, but of the schemes only those that the rule uses.
# So a changed scheme reruns what used it, and a changed figure script redraws that figure.

IMPORTS = grimp.build_graph("study", "reference", "paper", cache_dir=None)
for importer in IMPORTS.find_modules_that_directly_import("study.schemes"):
    IMPORTS.remove_import(importer=importer, imported="study.schemes")
ALWAYS = {"study.xla"}


def sources(module, used_schemes=()):
    """Files of a module and of everything that it imports."""
    modules = {module} | IMPORTS.find_upstream_modules(module)
    for name in used_schemes:
        scheme = type(schemes[name]).__module__
        modules |= {scheme} | IMPORTS.find_upstream_modules(scheme)
    if module.startswith(("study", "reference")):
        modules |= ALWAYS
    paths = (f"{PROJECT}/{name.replace('.', '/')}" for name in sorted(modules))
    return [f"{path}/__init__.py" if os.path.isdir(path) else f"{path}.py" for path in paths]


def options(section):
    """A section of the configuration as the JSON argument of its experiment."""
    return json.dumps(section)


def references(section):
    return [f"results/reference/{name}.nc" for name in section["problems"]]


PORTRAITS = list(config["phase_portrait"])
DATASETS = [
    "energy_error",
    "houbolt_start",
    "cpu_time",
    "energy_drift",
    "large_steps",
    "sensitivity",
    "spectral",
    *(f"phase_portrait/{name}" for name in PORTRAITS),
    *(f"reference/{name}" for name in config["references"]),
]


def portrait(name):
    return [f"results/phase_portrait/{name}.nc", f"results/reference/{name}.nc"]


#: Figure: its script, the datasets that it shows, and its caption for the report.
FIGURES = {
    "hardening": ("phase_portraits", portrait("hardening"), "Phase portraits of the hardening spring at T/20."),
    "softening": ("phase_portraits", portrait("softening"), "Phase portraits of the softening spring at T/20."),
    "instability": ("instability", portrait("softening_large"), "The α-method growing without bound."),
    "double_well": ("phase_portraits", portrait("double_well"), "Phase portraits of the double well at Δt = 2.5."),
    "energy_history": (
        "energy_history",
        [f"results/phase_portrait/{name}.nc" for name in ("hardening", "softening")],
        "Energy error against time.",
    ),
    "energy_drift": ("energy_drift", ["results/energy_drift.nc"], "Runge-Kutta captured by resonances."),
    "printed_digits": ("printed_digits", ["results/energy_error.nc"], "How the printed numbers were rounded."),
    "large_steps": ("large_steps", ["results/large_steps.nc"], "Where a step is small enough."),
}
#: Table: the datasets that it shows.
TABLES = {
    "schemes": ["results/energy_error.nc"],
    "energy_error": ["results/energy_error.nc"],
    "printed_digits": ["results/energy_error.nc"],
    "cpu_time": ["results/cpu_time.nc"],
    "houbolt_start": ["results/houbolt_start.nc"],
    "references": [f"results/reference/{name}.nc" for name in config["references"]],
}


wildcard_constraints:
    figure="|".join(FIGURES),
    table="|".join(TABLES),
    problem="|".join(config["references"]),
    portrait="|".join(PORTRAITS),


rule all:
    default_target: True
    input:
        "results/manuscript.pdf",
        "results/claims.csv",
        expand("results/{dataset}.nc", dataset=DATASETS),
        expand("results/figures/{figure}.{format}", figure=FIGURES, format=["pdf", "png", "svg"]),
        expand("results/tables/{table}.{format}", table=[*TABLES, "claims"], format=["csv", "tex"]),


# --------------------------------------------------------------------------------------------------------- references


rule reference:
    input:
        sources("reference.agreement"),
    output:
        "results/reference/{problem}.nc",
    params:
        options=lambda wildcards: options({"problem": wildcards.problem}),
    log:
        "results/logs/reference_{problem}.log",
    benchmark:
        "results/benchmarks/reference_{problem}.tsv"
    message:
        "reference of {wildcards.problem}: closed form, CVODE, diffrax"
    shell:
        "{PYTHON} -m reference.agreement {output} {params.options:q} > {log} 2>&1"


# -------------------------------------------------------------------------------------------------------- experiments


rule energy_error:
    input:
        references(config["energy_error"]),
        sources("study.experiments.energy_error", config["energy_error"]["schemes"]),
    output:
        "results/energy_error.nc",
    params:
        options=options(config["energy_error"]),
    log:
        "results/logs/energy_error.log",
    benchmark:
        "results/benchmarks/energy_error.tsv"
    message:
        "Tables 1 and 2: energy errors with printed and exact periods"
    shell:
        "{PYTHON} -m study.experiments.energy_error {output} {params.options:q} > {log} 2>&1"


rule houbolt_start:
    input:
        sources("study.experiments.houbolt_start", ["houbolt"]),
    output:
        "results/houbolt_start.nc",
    params:
        options=options(config["houbolt_start"]),
    log:
        "results/logs/houbolt_start.log",
    benchmark:
        "results/benchmarks/houbolt_start.tsv"
    message:
        "Houbolt's method under every start"
    shell:
        "{PYTHON} -m study.experiments.houbolt_start {output} {params.options:q} > {log} 2>&1"


rule cpu_time:
    input:
        sources("study.experiments.cpu_time", config["cpu_time"]["schemes"]),
    output:
        "results/cpu_time.nc",
    params:
        options=options(config["cpu_time"]),
    log:
        "results/logs/cpu_time.log",
    benchmark:
        "results/benchmarks/cpu_time.tsv"
    # every core, so that nothing else runs beside what is timed
    threads: workflow.cores
    message:
        "timing of the schemes, alone on the machine"
    shell:
        "{PYTHON} -m study.experiments.cpu_time {output} {params.options:q} > {log} 2>&1"


rule phase_portrait:
    input:
        lambda wildcards: sources(
            "study.experiments.phase_portrait", config["phase_portrait"][wildcards.portrait]["schemes"]
        ),
    output:
        "results/phase_portrait/{portrait}.nc",
    params:
        options=lambda wildcards: options(
            {"problem": wildcards.portrait} | config["phase_portrait"][wildcards.portrait]
        ),
    log:
        "results/logs/phase_portrait_{portrait}.log",
    benchmark:
        "results/benchmarks/phase_portrait_{portrait}.tsv"
    message:
        "phase portraits of {wildcards.portrait}"
    shell:
        "{PYTHON} -m study.experiments.phase_portrait {output} {params.options:q} > {log} 2>&1"


rule energy_drift:
    input:
        sources("study.experiments.energy_drift", [config["energy_drift"]["scheme"]]),
    output:
        "results/energy_drift.nc",
    params:
        options=options(config["energy_drift"]),
    log:
        "results/logs/energy_drift.log",
    benchmark:
        "results/benchmarks/energy_drift.tsv"
    message:
        "drift of the energy over many step sizes"
    shell:
        "{PYTHON} -m study.experiments.energy_drift {output} {params.options:q} > {log} 2>&1"


rule large_steps:
    input:
        sources("study.experiments.large_steps", config["large_steps"]["schemes"]),
    output:
        "results/large_steps.nc",
    params:
        options=options(config["large_steps"]),
    log:
        "results/logs/large_steps.log",
    benchmark:
        "results/benchmarks/large_steps.tsv"
    message:
        "small and large steps on every problem"
    shell:
        "{PYTHON} -m study.experiments.large_steps {output} {params.options:q} > {log} 2>&1"


rule sensitivity:
    input:
        sources("study.experiments.sensitivity", config["sensitivity"]["schemes"]),
    output:
        "results/sensitivity.nc",
    params:
        options=options(config["sensitivity"]),
    log:
        "results/logs/sensitivity.log",
    benchmark:
        "results/benchmarks/sensitivity.tsv"
    message:
        "sensitivity to the initial displacement"
    shell:
        "{PYTHON} -m study.experiments.sensitivity {output} {params.options:q} > {log} 2>&1"


rule spectral:
    input:
        sources("study.experiments.spectral", config["spectral"]["schemes"]),
    output:
        "results/spectral.nc",
    params:
        options=options(config["spectral"]),
    log:
        "results/logs/spectral.log",
    benchmark:
        "results/benchmarks/spectral.tsv"
    message:
        "linear theory: spectral radii"
    shell:
        "{PYTHON} -m study.experiments.spectral {output} {params.options:q} > {log} 2>&1"


# -------------------------------------------------------------------------------------------------------------- paper


rule figure:
    input:
        data=lambda wildcards: FIGURES[wildcards.figure][1],
        sources=lambda wildcards: sources(f"paper.figures.{FIGURES[wildcards.figure][0]}"),
    output:
        "results/figures/{figure}.pdf",
        "results/figures/{figure}.png",
        report("results/figures/{figure}.svg", caption="paper/figures/caption.rst", category="Figures"),
    params:
        script=lambda wildcards: FIGURES[wildcards.figure][0],
        caption=lambda wildcards: FIGURES[wildcards.figure][2],
    log:
        "results/logs/figure_{figure}.log",
    benchmark:
        "results/benchmarks/figure_{figure}.tsv"
    message:
        "figure {wildcards.figure}"
    shell:
        "{PYTHON} -m paper.figures.{params.script} {output[0]} {input.data} > {log} 2>&1"


rule table:
    input:
        data=lambda wildcards: TABLES[wildcards.table],
        sources=lambda wildcards: sources(f"paper.tables.{wildcards.table}"),
    output:
        "results/tables/{table}.csv",
        "results/tables/{table}.tex",
    log:
        "results/logs/table_{table}.log",
    benchmark:
        "results/benchmarks/table_{table}.tsv"
    message:
        "table {wildcards.table}"
    shell:
        "{PYTHON} -m paper.tables.{wildcards.table} {output[0]} {input.data} > {log} 2>&1"


rule claims:
    input:
        data=[f"results/{name}.nc" for name in DATASETS],
        sources=sources("paper.claims.__main__"),
    output:
        "results/claims.csv",
    params:
        names=DATASETS,
    log:
        "results/logs/claims.log",
    benchmark:
        "results/benchmarks/claims.tsv"
    message:
        "ledger of claims"
    shell:
        "{PYTHON} -m paper.claims {output} results {params.names} > {log} 2>&1"


rule claims_table:
    input:
        "results/claims.csv",
        "results/energy_error.nc",
        sources=sources("paper.tables.claims"),
    output:
        "results/tables/claims.csv",
        "results/tables/claims.tex",
    log:
        "results/logs/table_claims.log",
    benchmark:
        "results/benchmarks/table_claims.tsv"
    message:
        "table of claims"
    shell:
        "{PYTHON} -m paper.tables.claims {output[0]} {input[0]} {input[1]} > {log} 2>&1"


rule numbers:
    input:
        "results/claims.csv",
        [f"results/{name}.nc" for name in ("energy_error", "energy_drift", "cpu_time", "sensitivity")],
        expand("results/phase_portrait/{name}.nc", name=["softening_large", "double_well"]),
        sources=sources("paper.numbers"),
    output:
        "results/numbers.json",
    log:
        "results/logs/numbers.log",
    benchmark:
        "results/benchmarks/numbers.tsv"
    message:
        "numbers of the text"
    shell:
        "{PYTHON} -m paper.numbers results {output} > {log} 2>&1"


rule manuscript:
    input:
        "results/numbers.json",
        expand("results/figures/{figure}.pdf", figure=FIGURES),
        expand("results/tables/{table}.csv", table=[*TABLES, "claims"]),
        text=f"{PROJECT}/paper/manuscript.typ",
        bibliography=f"{PROJECT}/paper/references.bib",
        sources=sources("paper.compile"),
    output:
        "results/manuscript.pdf",
    log:
        "results/logs/manuscript.log",
    benchmark:
        "results/benchmarks/manuscript.tsv"
    message:
        "manuscript"
    shell:
        "{PYTHON} -m paper.compile results {output} > {log} 2>&1"
