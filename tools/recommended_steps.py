"""Number of random step sizes, below a step size that ``study.assess`` recommends, at which a run exceeds the error.

    python tools/recommended_steps.py [NAME ...]

The script draws 1,000 random step sizes between a twentieth of a recommended step size and the recommended step size,
with another seed than the assessment. It prints the number of step sizes at which the error exceeds the allowed error,
and the largest error divided by the allowed error.
"""

import sys
from pathlib import Path

import jax.numpy as jnp
import numpy as np

import study
from study.assessment import errors
from study.assessment.assess import assess
from study.assessment.certified import cases_of, certified
from study.assessment.steps import COARSEST, StepSearch
from study.mechanics.loads import excited
from study.sizes import TWENTIETH
from study.user_files import load

EXAMPLES, STEPS, SEED = Path(__file__).parents[1] / "examples", 1000, 20261124
SCHEMES = ("average_acceleration", "generalized_alpha", "bathe", "central_difference", "rk4")


def _example(name: str, variable: str, duration: float) -> tuple:
    place = EXAMPLES / f"{name}.py"
    return load(f"{place}:{variable}", (study.Problem,)), load(f"{place}:quantities", (dict,)), duration


def _named(name: str, duration: float) -> tuple:
    return study.problems[name], None, duration


PENDULUM = study.Problem(jnp.sin, u0=2.6, potential=lambda u: 1 - jnp.cos(u), title="pendulum from 150 degrees")
PROBLEMS = {
    "frame": lambda: _example("frame", "frame", 31.2),
    "yielding_frame": lambda: _example("yielding_frame", "frame", 12.0),
    "driven": lambda: _example("driven", "driven", 100.0),
    "shaken": lambda: _named("shaken", 31.2),
    "bouncing": lambda: _named("bouncing", 5.0),
    "yielding": lambda: _named("yielding", 20.0),
    "pendulum": lambda: (PENDULUM, None, 120.0),
}


def check(name: str) -> None:
    """Print a line for every scheme, quantity and allowed error of a problem."""
    problem, quantities, duration = PROBLEMS[name]()
    ds = assess(problem, SCHEMES, duration=duration, quantities=quantities, allowed_errors=(0.1, 0.01), maps=False)
    equation, selected = excited(problem, 1.0, displaced=True), errors.named(quantities)
    reference = certified(equation, ds.duration, selected, 0.01, duration / COARSEST, quantities is None)
    case = cases_of(equation, reference, selected, 0.01)[1.0]
    random = np.random.default_rng(SEED)
    for scheme in ds.scheme.values:
        runs = {}
        for (quantity, allowed), row in ds.sel(scheme=scheme).to_dataframe().groupby(["quantity", "allowed_error"]):
            step = row.recommended_step_size.iloc[0]
            if not step > 0:
                print(f"{name:15s} {scheme:22s} {quantity:13s} {allowed:5g}: no step", flush=True)
                continue
            if step not in runs:
                search = StepSearch(
                    study.schemes[scheme], {1.0: case}, ds.duration, step, step, "energy" in ds.quantity
                )
                search.run(step * random.uniform(TWENTIETH, 1.0, STEPS))
                runs[step] = search.runs
            error = runs[step][quantity].fillna(np.inf) / allowed
            first = row.iloc[0]
            print(
                f"{name:15s} {scheme:22s} {quantity:13s} {allowed:5g}: step {step:.4g}, "
                f"largest {first.largest_step_size:.4g}, {first.steps_tried:.0f} tried, "
                f"error up to {first.largest_error / allowed:.2f}; "
                f"fresh: {(error > 1).sum()} of {STEPS} exceed, up to {error.max():.3f}",
                flush=True,
            )


if __name__ == "__main__":
    for name in sys.argv[1:] or PROBLEMS:
        check(name)
