"""Every number that the text of the manuscript and the README quote, out of the datasets."""

import json
import re
import sys
from pathlib import Path

import pandas as pd

from paper.data import load
from paper.numbers.accuracy import of_accuracy, of_agreement, of_linear_theory, of_promises, of_round_off, of_work
from paper.numbers.reproduction import of_cells, of_double_well, of_drift, of_instability, of_times
from paper.numbers.stability import of_long_times, of_stability
from paper.numbers.structures import of_structures


def _of_claims(claims: pd.DataFrame) -> dict:
    def counted(part, prefix):
        count = part["verdict"].value_counts()
        return {
            prefix: len(part),
            f"{prefix}_reproduced": int(count.get("reproduced", 0)),
            f"{prefix}_qualified": int(count.get("reproduced with a qualification", 0)),
            f"{prefix}_not_reproduced": int(count.get("not reproduced", 0)),
        }

    ours = claims["section"].isin(["structures", "stability"])
    return counted(claims[~ours], "claims") | {
        name: number
        for section, prefix in (("structures", "structure_claims"), ("stability", "stability_claims"))
        for name, number in counted(claims[claims["section"] == section], prefix).items()
    }


def numbers(results: Path) -> dict:
    """All numbers by name, those with decimals formatted."""

    def dataset(name):
        return load(results / f"{name}.nc")

    claims = pd.read_csv(results / "claims.csv", dtype=str, keep_default_na=False)
    return {
        **of_cells(dataset("energy_error")),
        **of_drift(dataset("energy_drift")),
        **of_instability(dataset("phase_portrait/softening_large")),
        **of_double_well(dataset("phase_portrait/double_well"), dataset("sensitivity")),
        **of_times(dataset("cpu_time")),
        **of_agreement(dataset("reference_agreement")),
        **of_accuracy(dataset("accuracy")),
        **of_work(dataset("work_precision"), dataset("recommendation")),
        **of_linear_theory(dataset("spectral"), dataset("large_steps")),
        **of_promises(dataset("spectral"), dataset("accuracy")),
        **of_round_off(dataset("round_off")),
        **of_long_times(dataset("long_times")),
        **of_structures(
            dataset("structures"),
            dataset("reference/elastic_pendulum"),
            {
                name: dataset(f"structure_history/{name}")
                for name in ("stiff_soft", "long_times", "stiff_bar", "stiff_truss")
            },
        ),
        **of_stability(
            {
                name: dataset(f"stability/{name}")
                for name in ("atlas", "roots", "bifurcation", "robustness", "structures")
            }
        ),
        **_of_claims(claims),
    }


if __name__ == "__main__":
    results, output = map(Path, sys.argv[1:])
    # a minus before a number, and no hyphen of a name
    texts = {name: re.sub(r"(?<![^\W\de])-(?=\d)", "−", str(value)) for name, value in numbers(results).items()}
    output.write_text(json.dumps(texts, indent=1, ensure_ascii=False) + "\n")
