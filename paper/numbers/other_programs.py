"""Numbers of the text: the conformance of other programs."""

from collections import Counter

from paper.products import numbers
from paper.tables.other_programs import PROGRAMS, verdicts

#: Case that measures the order of the generalized-α method with damping and a load.
ORDER = "D-ORDER-GEN"


def _observed_order(file: str) -> str | None:
    """The observed order of the generalized-α method; None if it is the expected one."""
    (order,) = (case.get("order") for case in verdicts(file)["cases"] if case["name"] == ORDER)
    return None if order is None else f"{order:.2f}"


@numbers()
def other_program_numbers() -> dict:
    """Programs that fail a case, cases that OpenSees passes, and the order of its generalized-α."""
    opensees, from_zero = verdicts("opensees.json"), verdicts("opensees_from_zero.json")
    # sets of integrators of one program have names with an underscore, after the name of the program
    fails = Counter[str]()
    for file in PROGRAMS:
        fails[file.removesuffix(".json").partition("_")[0]] += verdicts(file)["counts"]["fail"]
    return {
        "kit_programs": len(fails),
        "kit_programs_failing": sum(number > 0 for number in fails.values()),
        "kit_cases": len(opensees["cases"]),
        "kit_opensees": f"{opensees['tool']} {opensees['version']}",
        "kit_opensees_passed": opensees["counts"]["pass"],
        "kit_opensees_cases": sum(opensees["counts"].values()) - opensees["counts"]["skip"],
        "kit_opensees_from_zero_passed": from_zero["counts"]["pass"],
        "kit_opensees_order": _observed_order("opensees.json"),
    }
