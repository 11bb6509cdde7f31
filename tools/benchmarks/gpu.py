"""Speed of ensembles on a CUDA device, compared with CUDA by hand.

    PYTHONPATH=. python tools/benchmarks/gpu.py

The time of a step of a lane is the difference of the times of two runs that differ in their number of steps, so that
it excludes the call and the compilation. The same formulas run in CUDA (``limit.cu``), which needs ``nvcc``.
"""

import logging
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
from case import example, timed

import study
from study.marching import kernel
from study.marching.march import PATIENCE

#: Number of lanes, and of steps of the CUDA programs. The steps take several times as long as the call.
LANES, STEPS = 2**20, 50_000

#: Number of runs of which the shortest counts.
REPEATS = 3

#: Step sizes of the springs in ``limit.cu``, in s.
STEP_SIZES = {"hardening": 0.0015, "softening": 0.0114}

SCHEMES = "central_difference", "rk4", "average_acceleration"


def by_hand() -> dict[tuple[str, str], tuple[float, float]]:
    """Lane-steps per second and result of the last lane of each CUDA program, by problem and scheme."""
    with tempfile.TemporaryDirectory() as folder:
        program, source = Path(folder) / "limit", Path(__file__).with_name("limit.cu")
        subprocess.run(["nvcc", "-O3", "-arch=native", "-std=c++17", "-o", program, source], check=True)
        run = subprocess.run([program, str(LANES), str(STEPS)], check=True, capture_output=True, text=True)
    rows = (line.split() for line in run.stdout.splitlines())
    return {(problem, scheme): (float(speed), float(result)) for problem, scheme, speed, result in rows}


def speed(run: Callable[[int], object], lanes: int, steps: int) -> tuple[float, float]:
    """Lane-steps per second, and seconds of a call without its steps; ``run`` takes the number of steps."""

    def least(count: int) -> float:
        return min(timed(partial(run, count)) for _ in range(1 + REPEATS))

    short, long = least(steps), least(4 * steps)
    return 3 * steps * lanes / (long - short), short - (long - short) / 3


def frame(scale: float) -> study.Problem:
    """Three storeys with cubic springs, full damping and a pulse of the ground."""
    mass, stiffness = np.full(3, 1e5), np.array([6e7, 5e7, 4e7])

    def force(u):
        drift = jnp.diff(u, prepend=jnp.zeros(1))
        shear = stiffness * drift * (1 + 20 * drift * drift)
        return shear - jnp.concatenate([shear[1:], jnp.zeros(1)])

    def load(t):
        return -3 * scale * jnp.asarray(mass) * jnp.sin(7 * t) * jnp.exp(-((t - 3) ** 2))

    return study.Problem(force, np.zeros(3), mass=mass, damping=1e4 + 1e5 * np.eye(3), load=load)


def lorenz(dtype: np.dtype) -> Callable[[int], jax.Array]:
    """Runge-Kutta on Lorenz' equations, as in ``limit.cu``, in the kernel of this package."""
    dt = np.asarray(0.001, dtype)

    def slope(p, rho):
        x, y, z = p
        return jnp.stack([10 * (y - x), x * (rho - z) - y, x * y - (8 / 3) * z])

    def step(_, p, rho):
        k1 = slope(p, rho)
        k2 = slope(p + dt / 2 * k1, rho)
        k3 = slope(p + dt / 2 * k2, rho)
        k4 = slope(p + dt * k3, rho)
        p = p + dt / 6 * (k1 + k4) + dt / 3 * (k2 + k3)
        return p, jnp.isfinite(p[0])

    rhos = jnp.linspace(0, 21, LANES, dtype=dtype)
    start = jnp.tile(jnp.asarray([1, 0, 0], dtype), (LANES, 1))
    march = jax.jit(lambda p, steps: kernel.advanced(step, p, rhos, 0, steps, PATIENCE, interpret=False))
    return lambda steps: march(start, steps).block_until_ready()


def springs(problem: str, scheme: str) -> Callable[[int], float]:
    """The largest energy error of the last lane, as in ``limit.cu``, by ``study.run``."""
    u0, dt = np.linspace(0.1, 1.5, LANES), STEP_SIZES[problem]

    def run(steps):
        return float(
            study.run(problem, scheme, u0=u0, dt=dt, steps=steps, observe="max_energy_error").max_energy_error[-1]
        )

    return run


def diffrax_tsit5(lanes: int) -> Callable[[int], jax.Array]:
    """Tsitouras' method in equal steps on the hardening spring, by ``jax.vmap`` of diffrax."""
    import diffrax

    dt, spring = STEP_SIZES["hardening"], study.problems["hardening"]
    term = diffrax.ODETerm(lambda t, y, _: jnp.stack([y[1], -spring.force(y[0])]))

    def end(u0, steps):
        y0, at = jnp.stack([u0, 0.0 * u0]), diffrax.SaveAt(t1=True)
        solver = diffrax.Tsit5()
        return diffrax.diffeqsolve(term, solver, 0.0, steps * dt, dt, y0, saveat=at, max_steps=None).ys

    march, u0 = jax.jit(jax.vmap(end, (0, None))), jnp.linspace(0.1, 1.5, lanes)
    return lambda steps: march(u0, jnp.asarray(steps, float)).block_until_ready()


def main() -> None:
    """Print the table."""
    if jax.default_backend() != "gpu" or not shutil.which("nvcc"):
        raise SystemExit("This benchmark needs a CUDA device, JAX for CUDA, and nvcc.")
    logging.basicConfig(format="%(message)s")
    kernel.LOG.setLevel(logging.INFO)
    print(jax.devices()[0].device_kind, "JAX", jax.__version__, flush=True)
    limits = by_hand()
    rows = []

    def add(name, run, lanes, steps, key=None):
        lane_steps, call = speed(run, lanes, steps)
        by_cuda, result = limits.get(key, (np.nan, np.nan))
        difference = abs(run(STEPS) / result - 1) if key and key[0] in STEP_SIZES else np.nan
        rows.append((name, lane_steps, by_cuda, lane_steps / by_cuda, difference, call))
        print(f"{name}: {lane_steps:.3g}", flush=True)

    for problem in STEP_SIZES:
        for scheme in SCHEMES:
            add(f"{problem}, {scheme}", springs(problem, scheme), LANES, STEPS, (problem, scheme))
    for scheme in (*SCHEMES, "hht_alpha", "bathe"):
        scale = np.linspace(0.1, 2, LANES // 4)

        def run(steps, scheme=scheme, scale=scale):
            return study.run(frame, scheme, over={"scale": scale}, dt=0.005, steps=steps, observe="peak")

        add(f"three storeys, {scheme}", run, len(scale), STEPS // 4)
    intensities = example("intensities")
    oscillators = np.exp(0.2 * np.random.default_rng(1).normal(size=(2, LANES)))
    over = {"period": 0.5 * oscillators[0], "strength": 0.15 * oscillators[1]}
    for scheme in ("central_difference", "average_acceleration"):

        def record(steps, scheme=scheme):
            arguments = intensities.RUN | {"steps": steps}
            return study.run(intensities.oscillator, scheme, over=over, **arguments)

        add(f"yielding under a record, {scheme}", record, LANES, STEPS // 2)
    for name in ("float32", "float64"):
        add(f"Lorenz, {name}", lorenz(np.dtype(name)), LANES, STEPS, ("lorenz", name))
    add("diffrax, hardening, Tsit5", diffrax_tsit5(LANES // 4), LANES // 4, 200)
    columns = ["", "lane-steps/s", "CUDA", "ratio", "difference", "call, s"]
    print(pd.DataFrame(rows, columns=columns).to_string(index=False))


if __name__ == "__main__":
    main()
