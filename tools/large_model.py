"""Time of ``study.assess`` for a model of many unknowns, in seconds and as a multiple of the time of one run.

python tools/large_model.py COLUMNS ROWS [SECONDS]

The model is a membrane of COLUMNS by ROWS unknowns on a unit square with twenty cubic stops, Rayleigh damping and a
harmonic load. Two implicit schemes are assessed for errors of 10 and 1 % over five seconds of motion. If
SECONDS is given, the assessment begins no run after this time. The time of one run is measured at a recommended step
size.
"""

import math
import sys
import time

import jax.numpy as jnp
import numpy as np
from scipy import sparse

import study

STOPS, STIFFNESS_OF_STOPS = 20, 2e5
SCHEMES, DURATION, ERRORS = ("average_acceleration", "bathe"), 5.0, (0.1, 0.01)


def membrane(columns: int, rows: int) -> study.Problem:
    """A membrane held at its edge, discretised by second differences."""

    def second_difference(n):
        return (n + 1) ** 2 * sparse.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])

    along, across = (
        sparse.kron(second_difference(columns), sparse.eye_array(rows)),
        sparse.kron(sparse.eye_array(columns), second_difference(rows)),
    )
    n = columns * rows
    x, y = (np.arange(1, count + 1) / (count + 1) for count in (columns, rows))
    shape = np.outer(np.sin(np.pi * x), np.sin(np.pi * y)).ravel()
    stops = np.linspace(0, n - 1, STOPS + 2).astype(int)[1:-1]
    return study.Problem(
        lambda u: jnp.zeros_like(u).at[stops].set(STIFFNESS_OF_STOPS * u[stops] ** 3),
        u0=np.zeros(n),
        v0=np.zeros(n),
        stiffness=sparse.csc_array(along + across),
        damping=study.Rayleigh(a=0.1, b=1e-4),
        load=lambda t: 20 * jnp.asarray(shape) * jnp.sin(4 * t),
        title=f"membrane of {n:,} unknowns",
    )


if __name__ == "__main__":
    model = membrane(*map(int, sys.argv[1:3]))
    start = time.perf_counter()
    ds = study.assess(
        model,
        SCHEMES,
        duration=DURATION,
        allowed_errors=ERRORS,
        seconds=float(sys.argv[3]) if sys.argv[3:] else math.inf,
    )
    seconds = time.perf_counter() - start
    print(
        f"{model.title}: {seconds:.0f} s; the reference: {ds.attrs['reference']}, compared with {ds.attrs['witness']}"
    )
    for quantity in ds.quantity.values:
        for error in ERRORS:
            for row in study.recommend(ds, allowed_error=error, quantity=quantity).itertuples():
                ratio = f", {seconds / row.seconds:.0f} times one run" if row.seconds > 0 else ""
                print(f"{error:.0%} of {quantity}, {row.Index}: Δt = {row.step_size:g} s, {row.verdict}{ratio}")
