"""Steps of the pipeline, which become rules of Snakemake, and the commands of their jobs."""

import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Job:
    """A module with its arguments, as ``python -m`` takes them, and the files that the job needs."""

    command: str
    inputs: tuple[str, ...]


def job(arguments: Iterable[Any], inputs: Iterable[Any]) -> Job:
    """A job that runs a module with arguments; each input is listed once."""
    return Job(shlex.join(map(str, arguments)), tuple(dict.fromkeys(map(str, inputs))))


@dataclass(frozen=True)
class Step:
    """Jobs of one kind.

    Attributes
    ----------
    name, message
        Name of the rule, and its message when it starts.
    outputs
        Files that the step makes, with ``{job}`` for the name of the job if its jobs have names.
    jobs
        The jobs by name. A step that always has one job gives it an empty name.
    temporary
        Whether the outputs are removed after their last use.
    alone
        Whether the jobs measure times, so that no other job may run at the same time.
    quick
        Whether the jobs take only seconds and run on the login node of a cluster.
    group
        Name of a group of jobs that a cluster runs as one job.
    report
        Heading and label in the report of Snakemake, by output and name of the job.
    """

    name: str
    message: str
    outputs: tuple[str, ...]
    jobs: Mapping[str, Job]
    temporary: bool = False
    alone: bool = False
    quick: bool = False
    group: str | None = None
    report: Mapping[str, Mapping[str, tuple[str, str]]] = field(default_factory=dict)

    @property
    def products(self) -> list[str]:
        """The output files of all jobs."""
        return [output.replace("{job}", name) for output in self.outputs for name in self.jobs]
