"""The parts of `parts.py` as jobs: `snakemake --snakefile examples/parts.smk --cores 2`."""

import sys

LANES, PARTS = config.get("lanes", 10_000_000), config.get("parts", 100)
DIGITS = len(str(PARTS - 1))
COMMAND = f"{sys.executable} {workflow.basedir}/parts.py runs {LANES} {PARTS}"


rule shares:
    input:
        [f"runs/part_{number:0{DIGITS}}.nc" for number in range(PARTS)],
    output:
        "shares.txt",
    shell:
        "{COMMAND} > {output}"


rule part:
    output:
        "runs/part_{number}.nc",
    shell:
        "OMP_NUM_THREADS={threads} {COMMAND} {wildcards.number}"
