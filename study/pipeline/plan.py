"""The part of the pipeline that makes datasets, as JSON: ``python -m study.pipeline.plan ROOT 'YAML'``.

It prints the complete configuration, the names of all datasets, and the steps of the pipeline.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

import yaml

from study.pipeline.configuration import check, datasets_of
from study.pipeline.experiment import discover
from study.pipeline.sources import Sources
from study.pipeline.steps import pages_of, steps_of


def main(root: str, text: str) -> None:
    """Print the plan for a configuration, or end with one sentence that says what is wrong with it.

    Raises
    ------
    SystemExit
        If the configuration cannot be run to its end.
    """
    try:
        experiments = discover()
        configuration = check(experiments, yaml.safe_load(text))
    except ValueError as error:
        raise SystemExit(str(error)) from None
    steps = steps_of(experiments, configuration, Sources(Path(root), "study", "reference"))
    plan = {
        "configuration": configuration,
        "datasets": datasets_of(experiments, configuration),
        "pages": pages_of(experiments, configuration),
        "steps": [asdict(step) for step in steps],
    }
    print(json.dumps(plan))


if __name__ == "__main__":
    main(*sys.argv[1:])
