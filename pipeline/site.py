"""The step that makes the site."""

from collections.abc import Mapping
from pathlib import Path

from docs.plan import TABLES, reads, shown
from pipeline.sources import Sources
from pipeline.step import Step, job


def step(root: Path, configuration: Mapping, sources: Sources) -> Step:
    """The step that makes the site, with pages of a user's own schemes."""
    schemes = configuration["own_schemes"]
    files = [*(f"results/{file}" for file in reads()), *shown(root), *(place.rpartition(":")[0] for place in schemes)]
    files += sources.of(["docs.build", *(table.module for table in TABLES)])
    task = job(["docs.build", "results", "results/site", *schemes], files)
    return Step("site", "Site", ("results/site/index.html",), {"": task})
