"""From the problems to the manuscript: references, experiments, figures, tables, ledger of claims, PDF."""

import json
import os
import sys
from pathlib import Path

import grimp
from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

min_version("9.0")


configfile: f"{workflow.basedir}/config/study.yaml"


sys.path.insert(0, workflow.basedir)
from study.configuration import check, complete
from study.datasets import check_writable
from study.schemes import schemes

try:
    check(config)
    check_writable("results/any")
except (ValueError, KeyError, SystemExit) as error:
    raise WorkflowError(str(error)) from None
config = complete(config)

PROJECT = workflow.basedir
SOURCES = Path(os.path.relpath(PROJECT))  # relative, so that a project that is moved stays made
# the commands run with this Python and find the project wherever the results are made
os.environ |= {
    "PATH": os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]),
    "PYTHONPATH": PROJECT,
    "PYTHONSAFEPATH": "1",
}
ENVIRONMENT = "config/environment.yaml"  # for --sdm conda only
# the maps take a tenth less time, compiled or not, when XLA writes what a step computes once, and does not compute it
# again for each of its uses; programs of structures and solvers, though, it then compiles at great length
MULTI_OUTPUT_FUSION = "XLA_FLAGS=--xla_backend_extra_options=xla_cpu_use_multi_output_fusion=true"


# ---------------------------------------------------------------------------------------------------------------------
# What a rule depends on: the modules that its command imports, but of the schemes only those that the rule uses.
# So a changed scheme reruns what used it, and a changed figure script redraws that figure.

IMPORTS = grimp.build_graph("study", "reference", "paper", cache_dir=None)
for importer in IMPORTS.find_modules_that_directly_import("study.schemes"):
    IMPORTS.remove_import(importer=importer, imported="study.schemes")


def sources(module, used_schemes=()):
    """Files of a module and of everything that it imports."""
    modules = {module} | IMPORTS.find_upstream_modules(module)
    for name in used_schemes:
        scheme = type(schemes[name]).__module__
        modules |= {scheme} | IMPORTS.find_upstream_modules(scheme)
    if not module.startswith("paper"):
        modules.add("study.xla")  # imported by the package itself
    paths = [SOURCES.joinpath(*name.split(".")) for name in sorted(modules)]
    printed = (SOURCES / "paper" / "published").glob("*.csv") if "paper.published" in modules else []
    return [path / "__init__.py" if path.is_dir() else path.with_suffix(".py") for path in paths] + sorted(printed)


# ---------------------------------------------------------------------------------------------------------------------
# What there is to make. Every output is an update: when a job fails, what was there before stays.

PORTRAITS = list(config["phase_portrait"])
#: Experiment: the schemes that it uses. Its options are the section of the configuration of the same name.
EXPERIMENTS = {
    "energy_error": config["energy_error"]["schemes"],
    "accuracy": config["accuracy"]["schemes"],
    "houbolt_start": ["houbolt"],
    "cpu_time": config["cpu_time"]["schemes"],
    "energy_drift": [config["energy_drift"]["scheme"]],
    "large_steps": config["large_steps"]["schemes"],
    "sensitivity": config["sensitivity"]["schemes"],
    "spectral": config["spectral"]["schemes"],
    "round_off": [*config["round_off"]["schemes"]],
    "long_times": config["long_times"]["schemes"],
    "recommendation": [],
}


def references(problems):
    return [f"reference/{name}" for name in problems]


#: Experiment: the datasets that it reads.
READS = {
    "energy_error": references(config["energy_error"]["problems"]),
    "accuracy": references(config["accuracy"]["problems"]),
    "round_off": references([config["round_off"]["problem"]]),
    "long_times": references([config["long_times"]["problem"]]),
    "recommendation": ["work_precision"],
}
#: What else is asked about stability: the experiment, and the schemes that it uses.
STABILITY = {
    "roots": ("roots", config["stability"]["roots"]["schemes"]),
    "numerical_map": ("numerical_map", config["stability"]["numerical_map"]["schemes"]),
    "bifurcation": ("bifurcation", [config["stability"]["bifurcation"]["scheme"]]),
    "structures": ("structure_stability", config["stability"]["structures"]["schemes"]),
}
#: Structure: the length of its runs.
STRUCTURES = {one["problem"]: one["periods"] for one in config["structures"]["lengths"]}
HISTORIES = list(config["structure_history"])
DATASETS = [
    *EXPERIMENTS,
    "reference/amplitudes",
    "stability/atlas",
    "stability/robustness",
    *(f"stability/{name}" for name in STABILITY),
    "structures",
    *(f"structure_history/{name}" for name in HISTORIES),
    *references(STRUCTURES),
    "reference_agreement",
    "work_precision",
    *(f"phase_portrait/{name}" for name in PORTRAITS),
    *references(config["references"]["problems"]),
]


def dataset(*names):
    return [f"results/{name}.nc" for name in names]


def portrait(name):
    return dataset(f"phase_portrait/{name}", f"reference/{name}")


#: Figure: its script, the datasets that it shows, and its caption for the report.
FIGURES = {
    "hardening": ("phase_portraits", portrait("hardening"), "Phase portraits of the hardening spring at T/20."),
    "softening": ("phase_portraits", portrait("softening"), "Phase portraits of the softening spring at T/20."),
    "instability": ("instability", portrait("softening_large"), "The α-method growing without bound."),
    "double_well": ("phase_portraits", portrait("double_well"), "Phase portraits of the double well at Δt = 2.5."),
    "energy_history": (
        "energy_history",
        dataset("phase_portrait/hardening", "phase_portrait/softening"),
        "Energy error against time.",
    ),
    "energy_drift": ("energy_drift", dataset("energy_drift"), "Runge-Kutta caught by resonances."),
    "printed_digits": ("printed_digits", dataset("energy_error"), "How the printed numbers were rounded."),
    "large_steps": ("large_steps", dataset("large_steps"), "Where a step is small enough."),
    "tolerance": ("tolerance", dataset("reference_agreement"), "What a tolerance delivers."),
    "accuracy": ("accuracy", dataset("accuracy"), "Every measure of error against the step size."),
    "work_precision": ("work_precision", dataset("work_precision"), "Every measure of error against time."),
    "force_evaluations": ("force_evaluations", dataset("work_precision"), "Every measure of error against forces."),
    "solvers": ("solvers", dataset("work_precision"), "General solvers beside schemes at fixed steps."),
    "spectral_radius": ("spectral_radius", dataset("spectral"), "Spectral radius of every scheme."),
    "linear_accuracy": ("linear_accuracy", dataset("spectral"), "Period elongation and damping by linear theory."),
    "promises": ("promises", dataset("spectral", "accuracy"), "Linear theory beside what the springs show."),
    "families": ("families", dataset("work_precision"), "Speed against error for every scheme."),
    "round_off": ("round_off", dataset("round_off"), "Round-off, and what compensated summation buys."),
    "long_times": ("long_times", dataset("long_times"), "Energy and phase over very long times, and round-off."),
    "stiff_soft": ("stiff_soft", dataset("structure_history/stiff_soft"), "A mass on a stiff spring, its velocity."),
    "oscillatory_energies": (
        "oscillatory_energies",
        dataset("structure_history/energy_exchange", "structure_history/long_times"),
        "Energies of the stiff springs of the Fermi-Pasta-Ulam chain.",
    ),
    "energy_growth": (
        "energy_growth",
        dataset("structure_history/stiff_bar", "structure_history/stiff_truss"),
        "Energy error where stiff modes are not resolved.",
    ),
    "structures": ("structures", dataset("structures"), "Error of the displacement of structures."),
    "atlas": ("atlas", dataset("stability/atlas", "spectral"), "How runs end over step size and amplitude, 1996."),
    "atlas_of_today": (
        "atlas_of_today",
        dataset("stability/atlas", "spectral"),
        "How runs end over step size and amplitude, schemes of today.",
    ),
    "roots": ("roots", dataset("stability/roots"), "Roots of the effective equation, and Newton's choice."),
    "numerical_map": ("numerical_map", dataset("stability/numerical_map"), "Phase portraits of the numerical map."),
    "bifurcation": ("bifurcation", dataset("stability/bifurcation"), "Order and chaos of average acceleration."),
    "structure_stability": (
        "structure_stability",
        dataset("stability/structures"),
        "Lyapunov exponents of the schemes on structures.",
    ),
    "structure_outcomes": (
        "structure_outcomes",
        dataset("stability/structures"),
        "How runs of structures end over step size and excitation.",
    ),
}
#: Table: the datasets that it shows.
TABLES = {
    "schemes": dataset("energy_error"),
    "energy_error": dataset("energy_error"),
    "printed_digits": dataset("energy_error"),
    "cpu_time": dataset("cpu_time"),
    "houbolt_start": dataset("houbolt_start"),
    "orders": dataset("accuracy"),
    "recommendation": dataset("recommendation"),
    "schemes_of_today": dataset("spectral"),
    "linear_theory": dataset("spectral"),
    "stability": dataset("spectral", "large_steps"),
    "orders_of_today": dataset("accuracy"),
    "needs": dataset("recommendation"),
    "references": dataset("reference_agreement", *references(config["references"]["problems"])),
    "structures": dataset("structures"),
    "round_off_growth": dataset("long_times"),
    "verdicts": dataset("stability/atlas"),
    "robustness": dataset("stability/robustness"),
    "claims": ["results/claims.csv", *dataset("energy_error")],
}


onerror:
    # what was there before a failed job is put back, and looks new; an old date and no record of how it was made have
    # it made anew next time, whatever the cause of the failure
    for job in workflow.scheduler.failed:
        for product in job.output:
            if Path(product).exists():
                os.utime(product, (1, 1))
                workflow.persistence.cleanup_metadata(product)


wildcard_constraints:
    experiment="|".join(EXPERIMENTS),
    figure="|".join(FIGURES),
    portrait="|".join(PORTRAITS),
    history="|".join(HISTORIES),
    structure="|".join(STRUCTURES),
    problem="|".join(config["references"]["problems"]),
    table="|".join(TABLES),
    scheme="|".join(schemes),
    tile="|".join(map(str, range(config["atlas"]["tiles"]))),
    stability="|".join(STABILITY),
    spring="|".join(config["robustness"]["problems"]),


rule all:
    default_target: True
    input:
        "results/manuscript.pdf",
        "results/explorer.html",
        "results/claims.csv",
        dataset(*DATASETS),
        expand("results/figures/{figure}.{format}", figure=FIGURES, format=["pdf", "png", "svg"]),
        expand("results/tables/{table}.{format}", table=TABLES, format=["csv", "tex"]),
    message:
        "everything is made; see results/manuscript.pdf and results/explorer.html"


rule reference:
    input:
        sources("reference.exact"),
    output:
        update("results/reference/{problem}.nc"),
    params:
        options=lambda wildcards: json.dumps(
            {"problem": wildcards.problem, "steps_per_period": config["references"]["steps_per_period"]}
        ),
    log:
        "results/logs/reference_{problem}.log",
    benchmark:
        "results/benchmarks/reference_{problem}.tsv"
    conda:
        ENVIRONMENT
    message:
        "truth of {wildcards.problem}, beyond double precision"
    shell:
        "python -m reference.exact {output} {params.options:q} > {log} 2>&1"


rule agreement:
    input:
        sources("reference.agreement"),
    output:
        update("results/reference_agreement.nc"),
    params:
        options=json.dumps({"problems": config["references"]["problems"], **config["agreement"]}),
    log:
        "results/logs/agreement.log",
    benchmark:
        "results/benchmarks/agreement.tsv"
    conda:
        ENVIRONMENT
    message:
        "what a tolerance delivers on every problem: CVODE, diffrax, heyoka"
    shell:
        "python -m reference.agreement {output} {params.options:q} > {log} 2>&1"


def inputs_of(experiment):
    """The datasets that an experiment reads, and its sources."""
    return dataset(*READS.get(experiment, [])) + sources(f"study.experiments.{experiment}", EXPERIMENTS[experiment])


rule experiment:
    input:
        lambda wildcards: inputs_of(wildcards.experiment),
    output:
        update("results/{experiment}.nc"),
    params:
        options=lambda wildcards: json.dumps(config[wildcards.experiment]),
        # where compiling is timed too, nothing may come from an earlier process
        cache=lambda wildcards: "false" if wildcards.experiment == "cpu_time" else "true",
    log:
        "results/logs/{experiment}.log",
    benchmark:
        "results/benchmarks/{experiment}.tsv"
    conda:
        ENVIRONMENT
    # what is timed takes every core, so that nothing else runs beside it
    threads: lambda wildcards: workflow.cores if wildcards.experiment == "cpu_time" else 1
    message:
        "experiment {wildcards.experiment}"
    shell:
        "JAX_ENABLE_COMPILATION_CACHE={params.cache}"
        " python -m study.experiments.{wildcards.experiment} {output} {params.options:q} > {log} 2>&1"


rule work_precision:
    input:
        dataset("accuracy", *references(config["references"]["problems"])),
        sources("study.experiments.work_precision", config["work_precision"]["schemes"]["schemes"]),
        sources("reference.work_precision"),
        sources("study.gather"),
    output:
        schemes=temp("results/work_precision/schemes.nc"),
        solvers=temp("results/work_precision/solvers.nc"),
        whole=update("results/work_precision.nc"),
    params:
        schemes=json.dumps(config["work_precision"]["schemes"]),
        solvers=json.dumps(config["work_precision"]["solvers"]),
    log:
        "results/logs/work_precision.log",
    benchmark:
        "results/benchmarks/work_precision.tsv"
    conda:
        ENVIRONMENT
    # both are timed in one job that has the machine to itself, each on one core
    threads: workflow.cores
    message:
        "what accuracy costs: schemes and general solvers, timed with nothing else running"
    shell:
        "( export OMP_NUM_THREADS=1"
        " && python -m study.experiments.work_precision {output.schemes} {params.schemes:q}"
        " && python -m reference.work_precision {output.solvers} {params.solvers:q}"
        " && python -m study.gather {output.whole} none {output.schemes} {output.solvers} ) > {log} 2>&1"


rule structure_reference:
    input:
        sources("reference.structures"),
    output:
        update("results/reference/{structure}.nc"),
    params:
        options=lambda wildcards: json.dumps(
            {
                "problem": wildcards.structure,
                "periods": STRUCTURES[wildcards.structure],
                "samples_per_period": config["structures"]["samples_per_period"],
                "rtol": config["structures"]["rtol"],
            }
        ),
    log:
        "results/logs/reference_{structure}.log",
    benchmark:
        "results/benchmarks/reference_{structure}.tsv"
    conda:
        ENVIRONMENT
    message:
        "reference of {wildcards.structure}: diffrax and CVODE"
    shell:
        "python -m reference.structures {output} {params.options:q} > {log} 2>&1"


rule structure:
    input:
        dataset("reference/{structure}"),
        sources("study.experiments.structures", config["structures"]["schemes"]),
    output:
        temp("results/structures/{structure}.nc"),
    params:
        options=lambda wildcards: json.dumps(
            {
                "problem": wildcards.structure,
                "periods": STRUCTURES[wildcards.structure],
                "schemes": config["structures"]["schemes"],
                "steps_per_period": config["structures"]["steps_per_period"],
            }
        ),
    log:
        "results/logs/structure_{structure}.log",
    benchmark:
        "results/benchmarks/structure_{structure}.tsv"
    conda:
        ENVIRONMENT
    message:
        "the schemes on {wildcards.structure}"
    shell:
        "python -m study.experiments.structures {output} {params.options:q} > {log} 2>&1"


rule gathered_structures:
    input:
        parts=dataset(*(f"structures/{name}" for name in STRUCTURES)),
        sources=sources("study.gather"),
    output:
        update("results/structures.nc"),
    log:
        "results/logs/structures.log",
    benchmark:
        "results/benchmarks/structures.tsv"
    conda:
        ENVIRONMENT
    message:
        "the schemes on all structures"
    shell:
        "python -m study.gather {output} problem {input.parts} > {log} 2>&1"


rule structure_history:
    input:
        lambda wildcards: dataset(*references([config["structure_history"][wildcards.history]["problem"]])),
        lambda wildcards: sources(
            "study.experiments.structure_history", config["structure_history"][wildcards.history]["schemes"]
        ),
    output:
        update("results/structure_history/{history}.nc"),
    params:
        options=lambda wildcards: json.dumps(config["structure_history"][wildcards.history]),
    log:
        "results/logs/structure_history_{history}.log",
    benchmark:
        "results/benchmarks/structure_history_{history}.tsv"
    conda:
        ENVIRONMENT
    message:
        "histories of {wildcards.history}"
    shell:
        "python -m study.experiments.structure_history {output} {params.options:q} > {log} 2>&1"


rule amplitudes:
    input:
        sources("reference.amplitudes"),
    output:
        update("results/reference/amplitudes.nc"),
    params:
        options=json.dumps({"problems": config["atlas"]["problems"], "exponents": config["atlas"]["amplitudes"]}),
    log:
        "results/logs/amplitudes.log",
    benchmark:
        "results/benchmarks/amplitudes.tsv"
    conda:
        ENVIRONMENT
    message:
        "exact periods over decades of amplitude"
    shell:
        "python -m reference.amplitudes {output} {params.options:q} > {log} 2>&1"


rule atlas:
    input:
        dataset("reference/amplitudes"),
        lambda wildcards: sources("study.experiments.atlas", [wildcards.scheme]),
    output:
        maps=update("results/stability/tiles/{scheme}_{tile}.nc"),
        portraits=update("results/stability/portraits/{scheme}_{tile}.nc"),
    params:
        fusion=MULTI_OUTPUT_FUSION,
        options=lambda wildcards: json.dumps(
            {
                "scheme": wildcards.scheme,
                "tile": int(wildcards.tile),
                **{key: config["atlas"][key] for key in ("problems", "dt_over_period", "periods", "portraits", "tiles")},
            }
        ),
    log:
        "results/logs/atlas_{scheme}_{tile}.log",
    benchmark:
        "results/benchmarks/atlas_{scheme}_{tile}.tsv"
    conda:
        ENVIRONMENT
    message:
        "maps of stability of {wildcards.scheme}, tile {wildcards.tile}"
    shell:
        "{params.fusion} python -m study.experiments.atlas {output} {params.options:q} > {log} 2>&1"


rule gathered_atlas:
    input:
        tiles=expand(
            "results/stability/tiles/{scheme}_{tile}.nc",
            scheme=config["atlas"]["schemes"],
            tile=range(config["atlas"]["tiles"]),
        ),
        sources=sources("study.gather"),
    output:
        update("results/stability/atlas.nc"),
    log:
        "results/logs/atlas.log",
    benchmark:
        "results/benchmarks/atlas.tsv"
    conda:
        ENVIRONMENT
    message:
        "maps of stability, all schemes"
    shell:
        "python -m study.gather {output} scheme,amplitude {input.tiles} > {log} 2>&1"


rule robustness:
    input:
        dataset("reference/amplitudes"),
        sources("study.experiments.robustness", config["robustness"]["schemes"]),
    output:
        temp("results/stability/robustness/{spring}.nc"),
    params:
        fusion=MULTI_OUTPUT_FUSION,
        options=lambda wildcards: json.dumps({**config["robustness"], "problems": [wildcards.spring]}),
    log:
        "results/logs/robustness_{spring}.log",
    benchmark:
        "results/benchmarks/robustness_{spring}.tsv"
    conda:
        ENVIRONMENT
    message:
        "steps a period that are enough on {wildcards.spring}"
    shell:
        "{params.fusion} python -m study.experiments.robustness {output} {params.options:q} > {log} 2>&1"


rule gathered_robustness:
    input:
        parts=dataset(*(f"stability/robustness/{name}" for name in config["robustness"]["problems"])),
        sources=sources("study.gather"),
    output:
        update("results/stability/robustness.nc"),
    log:
        "results/logs/robustness.log",
    benchmark:
        "results/benchmarks/robustness.tsv"
    conda:
        ENVIRONMENT
    message:
        "steps a period that are enough, all problems"
    shell:
        "python -m study.gather {output} problem {input.parts} > {log} 2>&1"


rule stability:
    input:
        lambda wildcards: sources(f"study.experiments.{STABILITY[wildcards.stability][0]}", STABILITY[wildcards.stability][1]),
    output:
        update("results/stability/{stability}.nc"),
    params:
        experiment=lambda wildcards: STABILITY[wildcards.stability][0],
        options=lambda wildcards: json.dumps(config["stability"][wildcards.stability]),
    log:
        "results/logs/stability_{stability}.log",
    benchmark:
        "results/benchmarks/stability_{stability}.tsv"
    conda:
        ENVIRONMENT
    message:
        "why a scheme fails: {wildcards.stability}"
    shell:
        "python -m study.experiments.{params.experiment} {output} {params.options:q} > {log} 2>&1"


rule gathered_portraits:
    input:
        tiles=expand(
            "results/stability/portraits/{scheme}_{tile}.nc",
            scheme=config["atlas"]["schemes"],
            tile=range(config["atlas"]["tiles"]),
        ),
        sources=sources("study.gather"),
    output:
        update("results/stability/portraits.nc"),
    log:
        "results/logs/portraits.log",
    benchmark:
        "results/benchmarks/portraits.tsv"
    conda:
        ENVIRONMENT
    message:
        "samples of the runs of the maps, all schemes"
    shell:
        "python -m study.gather {output} scheme,amplitude {input.tiles} > {log} 2>&1"


rule explorer:
    input:
        data=dataset(
            "stability/atlas",
            "stability/portraits",
            "reference/amplitudes",
            *(f"phase_portrait/{name}" for name in PORTRAITS),
        ),
        sources=sources("paper.explorer"),
    output:
        report(
            update("results/explorer.html"), caption="paper/figures/caption.rst", category="Maps of stability"
        ),
    params:
        caption="Every run of the maps of stability, to look at.",
    log:
        "results/logs/explorer.log",
    benchmark:
        "results/benchmarks/explorer.tsv"
    conda:
        ENVIRONMENT
    message:
        "page to explore the maps of stability"
    shell:
        "python -m paper.explorer {output} {input.data} > {log} 2>&1"


rule phase_portrait:
    input:
        lambda wildcards: sources(
            "study.experiments.phase_portrait", config["phase_portrait"][wildcards.portrait]["schemes"]
        ),
    output:
        update("results/phase_portrait/{portrait}.nc"),
    params:
        options=lambda wildcards: json.dumps(
            {"problem": wildcards.portrait, **config["phase_portrait"][wildcards.portrait]}
        ),
    log:
        "results/logs/phase_portrait_{portrait}.log",
    benchmark:
        "results/benchmarks/phase_portrait_{portrait}.tsv"
    conda:
        ENVIRONMENT
    message:
        "phase portraits of {wildcards.portrait}"
    shell:
        "python -m study.experiments.phase_portrait {output} {params.options:q} > {log} 2>&1"


rule figure:
    input:
        data=lambda wildcards: FIGURES[wildcards.figure][1],
        sources=lambda wildcards: sources(f"paper.figures.{FIGURES[wildcards.figure][0]}"),
    output:
        pdf=update("results/figures/{figure}.pdf"),
        png=update("results/figures/{figure}.png"),
        svg=report(
            update("results/figures/{figure}.svg"), caption="paper/figures/caption.rst", category="Figures"
        ),
    params:
        script=lambda wildcards: FIGURES[wildcards.figure][0],
        caption=lambda wildcards: FIGURES[wildcards.figure][2],
    log:
        "results/logs/figure_{figure}.log",
    benchmark:
        "results/benchmarks/figure_{figure}.tsv"
    conda:
        ENVIRONMENT
    message:
        "figure {wildcards.figure}"
    shell:
        "python -m paper.figures.{params.script} {output.pdf} {input.data} > {log} 2>&1"


rule claims:
    input:
        data=dataset(*DATASETS),
        sources=sources("paper.claims.__main__"),
    output:
        update("results/claims.csv"),
    params:
        names=DATASETS,
    log:
        "results/logs/claims.log",
    benchmark:
        "results/benchmarks/claims.tsv"
    conda:
        ENVIRONMENT
    message:
        "ledger of claims"
    shell:
        "python -m paper.claims {output} results {params.names} > {log} 2>&1"


rule table:
    input:
        data=lambda wildcards: TABLES[wildcards.table],
        sources=lambda wildcards: sources(f"paper.tables.{wildcards.table}"),
    output:
        csv=update("results/tables/{table}.csv"),
        tex=update("results/tables/{table}.tex"),
    log:
        "results/logs/table_{table}.log",
    benchmark:
        "results/benchmarks/table_{table}.tsv"
    conda:
        ENVIRONMENT
    message:
        "table {wildcards.table}"
    shell:
        "python -m paper.tables.{wildcards.table} {output.csv} {input.data} > {log} 2>&1"


rule numbers:
    input:
        "results/claims.csv",
        dataset("energy_error", "energy_drift", "cpu_time", "sensitivity", "spectral", "large_steps"),
        dataset("reference_agreement", "accuracy", "work_precision", "recommendation", "round_off", "long_times"),
        dataset("phase_portrait/softening_large", "phase_portrait/double_well"),
        dataset("structures", "reference/elastic_pendulum", *(f"structure_history/{name}" for name in HISTORIES)),
        dataset("stability/atlas", "stability/robustness", *(f"stability/{name}" for name in STABILITY)),
        sources=sources("paper.numbers.__main__"),
    output:
        update("results/numbers.json"),
    log:
        "results/logs/numbers.log",
    benchmark:
        "results/benchmarks/numbers.tsv"
    conda:
        ENVIRONMENT
    message:
        "numbers of the text"
    shell:
        "python -m paper.numbers results {output} > {log} 2>&1"


rule manuscript:
    input:
        "results/numbers.json",
        expand("results/figures/{figure}.pdf", figure=FIGURES),
        expand("results/tables/{table}.csv", table=TABLES),
        text=SOURCES / "paper" / "manuscript.typ",
        bibliography=SOURCES / "paper" / "references.bib",
        sources=sources("paper.compile"),
    output:
        update("results/manuscript.pdf"),
    log:
        "results/logs/manuscript.log",
    benchmark:
        "results/benchmarks/manuscript.tsv"
    conda:
        ENVIRONMENT
    message:
        "manuscript"
    shell:
        "python -m paper.compile results {output} > {log} 2>&1"
