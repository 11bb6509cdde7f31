"""Controlled steps: the cost of a trial step compared with the cost of an equal step of the same scheme."""

from collections.abc import Iterator
from functools import partial
from typing import Any

from case import Case, timed

import study
from study.problem.named import approximate_periods


def cases() -> Iterator[Case]:
    """All timed cases of controlled steps, with schemes whose error estimate needs no further force evaluation."""
    for problem, duration, tolerance in (
        ("hardening", 200 * approximate_periods["hardening"], 1e-6),
        ("fpu_chain", 60.0, 1e-6),
    ):
        for scheme in ("average_acceleration", "generalized_alpha", "dormand_prince6"):
            options: dict[str, Any] = {"observe": ["max_energy_error"], "on_failure": "ignore"}
            controlled = options | {"tolerance": tolerance, "duration": duration}
            ds = study.run(problem, scheme, **controlled)
            trials = int(ds.steps + ds.steps_rejected_by_estimate + ds.steps_rejected_by_solver)
            equal = options | {"dt": duration / trials, "steps": trials}
            yield Case(
                f"{scheme} on {problem} : controlled steps / equal steps",
                partial(timed, partial(study.run, problem, scheme, **controlled)),
                partial(timed, partial(study.run, problem, scheme, **equal)),
                1.3,
                trials,
            )
