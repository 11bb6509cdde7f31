"""The schemes of the study: ``conform conformance.codes.time_integration_study:step``.

Cases with one unknown and a smooth force share the compiled program of a scheme.
"""

import json
from collections.abc import Callable
from functools import cache

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

import study
from study import materials
from study.scheme.splitting import symplectic_euler
from study.scheme.wrapper.with_history import WithHistory

_ARRAYS = ("u0", "v0", "mass", "damping")

#: Number of rows of the longest motion: the start and 320 steps.
_ROWS = 321

#: Zero load and ground at rest, so that problems with and without load or ground motion share a program.
_NO_LOAD, _NO_GROUND = {"frequency": 0, "phase": 0}, {"acceleration": [0] * 17, "dt": 1}

_STARTS = {"linear acceleration": "linear_acceleration", "taylor": "taylor"}


class _Smooth(eqx.Module):
    """K u for several unknowns, and the sum of the smooth springs of the kit for one unknown."""

    stiffness: np.ndarray
    S1: np.ndarray
    S2: np.ndarray
    S: np.ndarray
    g: np.ndarray

    def __call__(self, u):
        if u.size > 1:
            return self.stiffness @ u
        return self.stiffness[0] * u + self.S1 * u * (1 + self.S2 * u * u) + self.S * jnp.tanh(u) + self.g * jnp.sin(u)


class _Sine(eqx.Module):
    """A stiff spring and a soft sine spring in series."""

    k1: np.ndarray
    k2: np.ndarray

    def __call__(self, u):
        soft = self.k2 * jnp.sin(u[1] - u[0])
        return jnp.stack([self.k1 * u[0] - soft, soft])


class _Load(eqx.Module):
    """A harmonic load."""

    amplitude: np.ndarray
    frequency: np.ndarray
    phase: np.ndarray

    def __call__(self, t):
        return self.amplitude * jnp.cos(self.frequency * t - self.phase)


def _force(form, parameters, n):
    numbers = {name: np.array(value, float) for name, value in parameters.items()}
    if form == "elastoplastic":
        return materials.elastoplastic(
            stiffness=[numbers["k"]], yield_force=[numbers["yield_force"]], hardening=[numbers["hardening"]]
        )
    if form == "gap":
        return materials.gap(stiffness=[numbers["k"]], opening=[numbers["gap"]])
    if form == "stiff_sine":
        return _Sine(**numbers)
    zero = np.zeros(())
    arguments = {"stiffness": np.zeros((n, n)), "S1": zero, "S2": zero, "S": zero, "g": zero} | numbers
    return _Smooth(**arguments)


@cache
def problem_of(encoded):
    """The problem of a case, given as JSON, as a problem of the study."""
    text = json.loads(encoded)
    n, (u0, v0, mass, damping) = len(text["u0"]), (np.array(text[name], float) for name in _ARRAYS)
    load, ground = text.get("load", _NO_LOAD | {"amplitude": [0] * n}), text.get("ground", _NO_GROUND)
    harmonic = _Load(*(np.array(load[name], float) for name in ("amplitude", "frequency", "phase")))
    record = study.GroundMotion(np.array(ground["acceleration"], float), float(ground["dt"]))
    return study.Problem(
        _force(text["form"], text["parameters"], n),
        u0,
        v0,
        mass=mass,
        damping=damping,
        load=harmonic,
        ground=record,
        tangent="dense",
    )


def scheme_of(text):
    """The scheme of a case as a scheme of the study."""
    # NumPy numbers become arguments of the compiled program; Python numbers would become constants in it
    numbers = {name: np.float64(value) for name, value in text.items() if name not in ("family", "start")}
    makers: dict[str, Callable[..., study.Scheme]] = {
        "newmark": study.Newmark,
        "central_difference": lambda: study.Newmark(beta=0.0, gamma=0.5),
        "hht_1996": study.HHTAlpha1996,
        "hht": lambda alpha, beta, gamma: study.GeneralizedAlpha(alpha_m=0.0, alpha_f=-alpha, beta=beta, gamma=gamma),
        "generalized_alpha": study.GeneralizedAlpha,
        "wilson": study.WilsonTheta,
        "houbolt": lambda: study.Houbolt(start_by=_STARTS[text["start"]]),
        "bathe": study.Bathe,
        "rk4": study.RungeKutta4,
        "midpoint": study.ImplicitMidpoint,
        "symplectic_euler": lambda: symplectic_euler,
        "kr_alpha": study.KolayRicles,
        "noh_bathe": study.NohBathe,
        "tchamwa_wielgosz": study.TchamwaWielgosz,
    }
    return makers[text["family"]](**numbers)


@eqx.filter_jit
def _march(problem, scheme, times, sizes, steps):
    state, _ = scheme.start(problem, problem.u0, problem.v0, sizes[0])

    def read(state):
        inner = state
        while hasattr(inner, "inner"):
            inner = inner.inner
        return state.u, state.v, getattr(inner, "a", state.u)

    def advance(i, carry):
        state, rows = carry
        state, _ = scheme.step(problem, state, times[i], sizes[i])
        return state, jax.tree.map(lambda row, value: row.at[i + 1].set(value), rows, read(state))

    rows = jax.tree.map(lambda value: jnp.zeros((_ROWS, *value.shape)).at[0].set(value), read(state))
    return lax.fori_loop(0, steps, advance, (state, rows))[1]


def step(problem, scheme, dt, steps):
    """Displacement, velocity and, if the scheme carries it, acceleration at t = 0 and after each step."""
    method = scheme_of(scheme)
    sizes = np.full(_ROWS, dt if np.ndim(dt) == 0 else 0.0)
    times = np.arange(_ROWS) * sizes
    if np.ndim(dt):
        sizes[:steps], times[1 : steps + 1] = dt, np.cumsum(dt)
        method = study.UnequalSteps(scheme=method) if method.acceleration_offset else method
    modelled = problem_of(json.dumps(problem.text))
    if modelled.history is not None:
        method = WithHistory(scheme=method)
    rows = _march(modelled, method, times, sizes, np.int64(steps))
    carried = scheme["family"] not in ("rk4", "midpoint", "symplectic_euler")
    return [np.asarray(values)[: steps + 1] for values in rows[: 2 + carried]]
