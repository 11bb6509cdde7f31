"""Pack a finished study into a zip file: ``python -m pipeline.archive PROJECT OUTPUT``.

The command runs in the folder that contains ``results``. The archive is a Workflow Run RO-Crate, see
https://w3id.org/ro/wfrun/workflow. It holds the sources, the configuration of the run, the files that this
configuration names, and the results. ``ro-crate-metadata.json`` describes the run: inputs, products, versions, machine
and time. Datasets do not contain the time of the run, and only timings and assessments name the processor.
"""

import io
import json
import os
import platform
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

import yaml
from rocrate.model import ContextEntity, SoftwareApplication
from rocrate.rocrate import ROCrate

from study.io import RESULTS, NotWritten, __version__, processor, write

#: Profiles of RO-Crate that the description of the run follows, by address.
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}
#: File with the complete configuration of the last run; a dry run does not write it.
CONFIGURATION = RESULTS / "configuration.json"
#: Names of folders that contain no sources.
_NO_SOURCES = {"results", "build", "__pycache__"}


def sources(project: Path) -> list[Path]:
    """Source files of the project, relative to its folder.

    In a Git checkout, the sources are the tracked files, and the untracked files that are neither ignored nor hidden.
    Outside a checkout, they are all files except products, caches, environments, and hidden files and folders at the
    top of the project.
    """
    if tracked := _listed(project, "--cached"):
        new = [file for file in _listed(project, "--others", "--exclude-standard") if not _is_hidden(file)]
        return [*tracked, *new]
    files = (file.relative_to(project) for file in project.rglob("*") if file.is_file())
    return [
        file
        for file in files
        if not any(part in _NO_SOURCES or part.startswith(".venv") for part in file.parts)
        and not file.parts[0].startswith(".")
    ]


def _listed(project: Path, *options: str) -> list[Path]:
    """The existing files that ``git ls-files`` lists with the options; an empty list outside a checkout."""
    listed = subprocess.run(["git", "ls-files", "-z", *options], cwd=project, capture_output=True, text=True)
    return [Path(name) for name in listed.stdout.split("\0") if name and (project / name).is_file()]


def products() -> list[Path]:
    """The files in ``results``, including logs and benchmarks, except hidden files and zip files."""
    files = sorted(file for file in RESULTS.rglob("*") if file.is_file())
    return [file for file in files if not _is_hidden(file) and file.suffix != ".zip"]


def _is_hidden(file: Path) -> bool:
    return any(part.startswith(".") for part in file.parts)


def configuration() -> dict:
    """The complete configuration of the run that made the study; empty if ``CONFIGURATION`` does not exist."""
    return json.loads(CONFIGURATION.read_text()) if CONFIGURATION.exists() else {}


def _files_of(part: Any) -> set[Path]:
    """The files that a configuration, or a part of it, names as ``FILE.py:NAME`` or by their folder."""
    if isinstance(part, str):
        if os.path.isdir(part):
            return {path for path in Path(part).iterdir() if path.is_file() and not path.name.startswith(".")}
        file = part.rpartition(":")[0]
        return {Path(file)} if file.endswith(".py") and Path(file).is_file() else set()
    parts = part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()
    return set().union(*map(_files_of, parts))


def own_files(configuration: dict) -> list[Path]:
    """The user's files of problems, schemes, quantities and records that a configuration names, in alphabetical order.

    Raises
    ------
    SystemExit
        If a file is outside the project, because the archive holds only files of the project.
    """
    files = sorted(_files_of(configuration))
    for file in files:
        if file.is_absolute() or ".." in file.parts:
            raise SystemExit(
                f"the configuration names '{file}', which an archive cannot hold: put the file into the project, "
                "name it by its path there, and make the study again."
            )
    return files


def _time(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")


def _machine() -> str:
    """Processor, number of cores, and system of this machine."""
    return f"{processor()}, {os.cpu_count()} cores, {platform.system()} {platform.release()}"


def described(project: Path) -> ROCrate:
    """The description of a finished study: sources, results, and the run that made them."""
    crate = ROCrate(version="1.1")  # the version of RO-Crate on which the profiles are based
    cited = yaml.safe_load((project / "CITATION.cff").read_text(encoding="utf-8"))
    crate.name, crate.license = cited["title"], f"https://spdx.org/licenses/{cited['license']}"
    crate.description = "Sources, configuration, datasets, figures, tables and manuscript of the study, with its run."
    crate.root_dataset["conformsTo"] = [
        crate.add(ContextEntity(crate, url, {"@type": "CreativeWork", "name": name, "version": url.rpartition("/")[2]}))
        for url, name in PROFILES.items()
    ]
    result_files = products()
    about = {"name": cited["title"], "version": __version__}
    workflow = crate.add_workflow(project / "snakefile", "snakefile", main=True, lang="snakemake", properties=about)
    inputs = [
        crate.add_file(project / file, file.as_posix(), properties={"name": file.name})
        for file in sources(project)
        if file.name != "snakefile"
    ]
    used = configuration()
    if used:
        text = io.StringIO(yaml.safe_dump(used, sort_keys=False, allow_unicode=True))
        about = {"name": "configuration that was used", "encodingFormat": "application/yaml"}
        inputs.append(crate.add_file(text, "configuration.yaml", properties=about))
    packed = {entry.id for entry in inputs}
    user_files = own_files(used)
    inputs += [
        crate.add_file(file, file.as_posix(), properties={"name": file.name})
        for file in user_files
        if file.as_posix() not in packed
    ]
    results = [crate.add_file(file, file.as_posix(), properties={"name": file.name}) for file in result_files]
    packages = [
        crate.add(
            SoftwareApplication(
                crate,
                f"#package-{package.metadata['Name']}",
                {"name": package.metadata["Name"], "softwareVersion": package.version, "version": package.version},
            )
        )
        for package in sorted(distributions(), key=lambda package: str(package.metadata["Name"]))
    ]
    workflow["softwareRequirements"] = packages
    times = [file.stat().st_mtime for file in result_files]
    run = crate.add(
        ContextEntity(
            crate,
            "#run",
            {
                "@type": "CreateAction",
                "name": f"Run of the study, version {__version__}",
                "startTime": _time(min(times)),
                "endTime": _time(max(times)),
                "description": f"Made with Python {platform.python_version()} on: {_machine()}",
                "actionStatus": "http://schema.org/CompletedActionStatus",
            },
        )
    )
    run["instrument"], run["result"] = workflow, results
    run["object"] = [entry for entry in inputs if _is_input(entry.id, user_files)]
    crate.root_dataset["mentions"] = run
    return crate


def _is_input(name: str, user_files: list[Path]) -> bool:
    """Whether a file of the archive is an input of the run: a configuration, a ground motion, or a user's file."""
    return (
        name == "configuration.yaml"
        or name.startswith(("config/", "study/mechanics/records/"))
        or Path(name) in user_files
    )


def main(project: Path, output: Path) -> None:
    """Write the archive of a finished study as a zip file.

    Raises
    ------
    SystemExit
        If the study is not finished, a file of the user is outside the project, or the archive cannot be written.
    """
    if not (RESULTS / "manuscript.pdf").is_file():
        raise SystemExit("there is no finished study in 'results'; `snakemake` makes it.")
    try:
        with tempfile.TemporaryDirectory() as folder:
            packed = Path(folder, "archive.zip")
            described(project).write_zip(packed)
            write(packed.read_bytes(), output)
    except NotWritten as error:
        raise SystemExit(str(error)) from None
    print(f"written: {output}")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
