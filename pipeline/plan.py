"""The plan of the pipeline: ``python -m pipeline.plan ROOT < CONFIGURATION`` prints it as JSON.

The plan contains the complete configuration, the products made by default, and the steps that make them and the site.
If the configuration cannot be run, the key ``refused`` has the reason instead.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from docs.plan import reads
from paper import products as paper_products
from pipeline import datasets, paper, site
from pipeline.configuration import check, datasets_of
from pipeline.sources import Sources
from study.declaration.experiment import discover


def plan(root: Path, values: Any) -> dict[str, Any]:
    """The plan for a configuration.

    Raises
    ------
    ValueError
        If an experiment cannot run to its end with the configuration, or a product needs a dataset or an option that
        the configuration lacks; the message is one sentence.
    """
    experiments, products = discover(), paper_products.discover()
    configuration = check(experiments, values)
    names = datasets_of(experiments, configuration)
    paper.check_places(products)
    for product in products:
        paper.check_datasets(product.label, product.files, names)
    paper.check_datasets("the site", reads(), names)
    paper_products.check(products, configuration)
    sources = Sources(root, "study", "reference", "pipeline", "paper", "docs")
    data = datasets.steps_of(experiments, configuration, sources)
    drawn = paper.steps_of(products, root, sources)
    lasting = [file for step in [*data, *drawn] if not step.temporary for file in step.products]
    return {
        "configuration": configuration,
        "products": lasting,
        "steps": [asdict(step) for step in [*data, *drawn, site.step(root, configuration, sources)]],
    }


if __name__ == "__main__":
    try:
        print(json.dumps(plan(Path(sys.argv[1]), json.load(sys.stdin))))
    except ValueError as error:
        print(json.dumps({"refused": str(error)}))
