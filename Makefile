# make                installs everything and makes the study
# make CLUSTER=slurm  makes the study on a cluster
# make site           makes the pages of the site
# make test           installs everything and runs the quick tests of the code
# make test-pipeline  runs the tests that need Snakemake, a small study or a browser
# make test-rest      runs slow tests, those of every scheme, and those of the conformance kit
# make test-all       runs all these tests
# make coverage       measures the coverage of the tests
# make check          checks style, format and types
# make benchmark      measures speed
# make torture        kills the pipeline at random moments
# make cluster        runs the pipeline on a Slurm of this machine
# make archive        packs the finished study
# make conformance    builds the wheel of the conformance kit
# make wheel          builds the wheel of the package, checks it for package indexes, and renders the conda recipe
# make citation       validates CITATION.cff
# make lock           updates the pinned versions in requirements.txt

PYTHON ?= python3
CONFIG ?= config/study.yaml
BIN := .venv/bin
# `make CLUSTER=slurm` sends the jobs to the cluster that profiles/slurm describes
CLUSTER ?=
OPTIONS ?= $(if $(CLUSTER),--workflow-profile profiles/$(CLUSTER) $(WITHOUT_ACCOUNTING))
# if Slurm has no accounting of jobs, their state is read from its queue
WITHOUT_ACCOUNTING = $(shell sacct > /dev/null 2>&1 || echo --slurm-status-command squeue --slurm-no-account)

# every package has the version and a hash in requirements.txt
PINNED := --require-hashes --no-deps
# If Python is told to write no bytecode, uv writes it as pip does: otherwise every process compiles all packages again.
BYTECODE = $(if $(PYTHONDONTWRITEBYTECODE),--compile-bytecode)

KILLS ?= 100
# folder of the wheel of the conformance kit
CONFORMANCE ?= results

.PHONY: study site test test-pipeline test-rest test-all coverage benchmark check lock torture cluster archive conformance wheel \
  citation clean

# XLA compiles single operations with the options that marches have anyway, in half the time
study site test test-pipeline test-rest coverage: export XLA_FLAGS ?= --xla_cpu_use_fusion_emitters=false --xla_cpu_parallel_codegen_split_count=1

# the pages of the site, results/site/index.html, are made on request, with missing parts of the study
study site: .venv/ready
	$(BIN)/snakemake $(OPTIONS) $(filter site,$@) --configfile $(CONFIG)

test: .venv/ready
	$(BIN)/pytest -n auto -m "not pipeline and not exhaustive and not slow" tests study

test-pipeline: .venv/ready
	$(BIN)/pytest -n auto -m "pipeline and not exhaustive"

test-rest: .venv/ready
	$(BIN)/pytest -n auto -m "exhaustive or slow and not pipeline" tests study
	$(BIN)/pytest -n auto conformance/tests

test-all: test test-pipeline test-rest

# all tests with their coverage; pyproject.toml states the smallest coverage allowed
coverage: .venv/ready
	$(BIN)/pytest -n auto --cov=study --cov=reference --cov-report=term

# style, format and types
check: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check snakefile workflow
	$(BIN)/mypy

# times compared with C, OpenSees where it is installed, and other parts of the study
benchmark: .venv/ready
	PYTHONPATH=. $(BIN)/python tools/benchmarks/benchmark.py results/benchmark.nc

.venv/ready: requirements.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or later is needed; name one with 'make PYTHON=...'." >&2; exit 1; }
	@echo "installing the pinned packages into .venv"
	$(PYTHON) -m venv .venv
	awk '/^[^ ]/ { of_uv = /^uv==/ } of_uv' requirements.txt > .venv/uv.txt
	$(BIN)/pip install --quiet $(PINNED) -r .venv/uv.txt
	@index=$${PIP_INDEX_URL:-$$($(BIN)/pip config get global.index-url 2> /dev/null)}; \
	  $(BIN)/uv pip install --quiet --python $(BIN)/python $${index:+--default-index "$$index"} $(BYTECODE) \
	    $(PINNED) -r requirements.txt || \
	  { echo "uv cannot install them, so pip does, which takes a minute or two" >&2; \
	    $(BIN)/pip install --quiet $(PINNED) -r requirements.txt; }
	$(BIN)/pip install --quiet --no-deps --no-build-isolation --editable .
	touch $@

# update requirements.txt after a change of pyproject.toml; `make lock UPGRADE=--upgrade` also renews all other pins
lock: .venv/ready
	$(BIN)/uv pip compile --quiet --universal --generate-hashes --no-emit-index-url --no-annotate $(UPGRADE) \
	  --extra pipeline --extra test --python-version 3.11 pyproject.toml -o requirements.txt

# kill the pipeline at random moments, and compare its products with those of an undisturbed run
torture: .venv/ready
	$(BIN)/python tools/torture.py $(KILLS) results/torture.csv

# the pipeline on a Slurm of one node, for which Debian's slurm-wlm and munge must be installed
cluster: .venv/ready
	$(BIN)/pytest -n 0 tools/cluster

# the finished study for others: sources, configuration, results, and a description of the run
archive: study
	$(BIN)/python -m pipeline.archive . results/archive.zip

# the conformance kit for other codes, built from a copy, because building leaves files next to the sources
conformance: .venv/ready
	@rm -rf build/conformance && mkdir -p build && cp -r conformance build/
	$(BIN)/pip wheel --quiet --no-deps --no-build-isolation --wheel-dir $(CONFORMANCE) ./build/conformance

# the wheel of the package, also built from a copy
wheel: .venv/ready
	@rm -rf build/package && mkdir -p build/package && cp -r pyproject.toml setup.py README.md LICENSE study reference build/package
	$(BIN)/pip wheel --quiet --no-deps --no-build-isolation --wheel-dir build/wheel ./build/package
	$(BIN)/uv tool run twine check --strict build/wheel/*.whl
	$(BIN)/uv run --quiet --no-project --with py-rattler-build python -c \
	  "from rattler_build import Stage0Recipe; print(*Stage0Recipe.from_file('recipe/recipe.yaml').render())"

# validate CITATION.cff; a test compares it with codemeta.json and .zenodo.json
citation: .venv/ready
	$(BIN)/uv tool run cffconvert --validate

clean:
	rm -rf results .snakemake build report.html .coverage
