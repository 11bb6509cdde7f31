"""Tests of what authors claim of their later schemes, mostly beyond linear theory, on problems like theirs."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jax.flatten_util import ravel_pytree
from scipy.integrate import solve_ivp

from study.algebra.jit import short_runs
from study.analysis.eigenvalues import eigenvalues
from study.analysis.forces import forces_of
from study.analysis.linear_theory import LinearTheory
from study.declaration.experiment import experiment, progress
from study.declaration.options import Counts, Length, RisingCounts, Sizes
from study.experiments.circumstances import DURATION, QUANTITIES, TOLERANCES, circumstances_with
from study.marching.run import run, sweep
from study.mechanics.definition import Problem
from study.mechanics.loads import HarmonicLoad
from study.observer.motion import Quantity
from study.scheme.auxiliary_variable import AuxiliaryVariable
from study.scheme.base import Scheme
from study.scheme.bathe import beta_bathe, rho_bathe
from study.scheme.kick_drift_kick import blanes_moan4
from study.scheme.kolay_ricles import KolayRicles, kr_alpha, mkr_alpha
from study.scheme.mixed_pade import MixedPade
from study.scheme.model_based import chang, chen_ricles
from study.scheme.newmark import average_acceleration, central_difference
from study.scheme.noh_bathe import noh_bathe
from study.scheme.runge_kutta import nystrom4
from study.scheme.splitting import mclachlan4, yoshida4
from study.scheme.trigonometric import Trigonometric, filters

#: Schemes with a model of the structure in their coefficients; the α-methods have ρ∞ = 1 here, except the last one.
WITH_MODEL: dict[str, Scheme] = {
    "chen_ricles": chen_ricles,
    "chang": chang,
    "kr_alpha": KolayRicles(rho_inf=1.0),
    "mkr_alpha": KolayRicles(rho_inf=1.0, modified=True),
    "kr_alpha_dissipative": kr_alpha,
}
#: Ratios of tangent to model stiffness that are tried. Largest excess of a spectral radius above 1 that counts as
#: round-off.
RATIOS, GROWTH = np.geomspace(1.0001, 1e4, 20_000), 1e-7

#: Schemes for the wave along a bar.
OF_WAVES: dict[str, Scheme] = {
    "rho_bathe": rho_bathe,
    "beta_bathe": beta_bathe,
    "average_acceleration": average_acceleration,
    "noh_bathe": noh_bathe,
    "central_difference": central_difference,
}
#: Schemes of fourth order that are compared at equal numbers of force evaluations.
FOURTH_ORDER: dict[str, Scheme] = {
    "blanes_moan4": blanes_moan4,
    "mclachlan4": mclachlan4,
    "yoshida4": yoshida4,
    "nystrom4": nystrom4,
}

#: ωΔt of the stiff unknown in the test of trigonometric methods; π and 2π are resonances. Duration of these runs.
PHASES, OSCILLATES = np.pi * np.array([0.5, 1.0, 2.0]), 2.0

#: Orders M of the mixed Padé methods, their spectral radius ρ∞ at infinite frequency, and numbers of steps of their
#: runs.
TERMS, RHO_INF, LONG = (1, 2, 3, 4), 0.5, (8, 16, 32)

#: Schemes whose carried velocity lags, from where their velocity starts, and numbers of steps of their runs.
LAGGING: dict[str, Any] = {"chen_ricles": chen_ricles, "kr_alpha": kr_alpha, "mkr_alpha": mkr_alpha}
STARTS, MANY = ("initial velocity", "lagged velocity"), (200, 400, 800)

#: Distance of the wave front from the pushed end at the end of a run; the bar has unit length.
REACHED = 0.7


def _offset(stiffness):
    """A force whose tangent is 1 at u = 0 and ``stiffness`` at the equilibrium u = 10."""
    return lambda u: stiffness * (u - 10) + (1 - stiffness) * u * jnp.exp(-u * u)


def _largest_stiffening(scheme: Scheme, dt: float) -> float:
    """Largest tried ratio of tangent to model stiffness up to which undamped steps are stable; 1 if there is none."""

    def matrix(ratio):
        problem = Problem(_offset(ratio), 10.0)
        state, _ = scheme.start(problem, jnp.asarray(10.0), jnp.zeros(()), dt)
        flat, unflatten = ravel_pytree(state)
        return jax.jacfwd(lambda flat: ravel_pytree(scheme.step(problem, unflatten(flat), 0.0, dt)[0])[0])(flat)

    roots = eigenvalues(np.asarray(jax.jit(jax.vmap(matrix))(RATIOS)))
    unstable = np.abs(roots).max(axis=1) > 1 + GROWTH
    first = int(np.argmax(unstable)) if unstable.any() else len(RATIOS)
    return float(RATIOS[first - 1]) if first else 1.0


def _coupled(u):
    return (u[0] - u[1]) ** 4 / 4 + u[0] ** 2 / 2


def _oscillatory(omega) -> Problem:
    """A soft and a stiff unknown; the initial energy of the stiff one does not depend on its circular frequency ω."""
    return Problem(
        potential=_coupled, stiffness=jnp.stack([0.0 * omega, omega**2]), u0=jnp.stack([1 + 0 * omega, 1 / omega]),
        v0=jnp.ones(2), tangent="dense",
    )  # fmt: skip


def _exact_oscillatory(omega: float) -> np.ndarray:
    def rates(t, y):
        force = (y[0] - y[1]) ** 3
        return [y[2], y[3], -force - y[0], force - omega**2 * y[1]]

    start = [1.0, 1 / omega, 1.0, 1.0]
    return solve_ivp(rates, (0.0, OSCILLATES), start, "DOP853", **TOLERANCES).y[:2, -1]


def _errors_of_trigonometric(steps: list[int]) -> np.ndarray:
    """Largest error of the displacements over all ωΔt, for each method and number of steps, (member, steps)."""
    final = Quantity(lambda u: u, name="end", reduce="final")
    errors = np.empty((len(filters), len(steps)))
    for k, count in enumerate(steps):
        progress(f"error of trigonometric methods with {count} steps")
        frequencies = PHASES * count / OSCILLATES
        exact = np.array([_exact_oscillatory(omega) for omega in frequencies])
        for m, member in enumerate(filters):
            ds = sweep(
                _oscillatory,
                Trigonometric(member=member),
                over={"omega": frequencies},
                dt=OSCILLATES / count,
                steps=count,
                observe=[final],
            )
            errors[m, k] = np.abs(ds.end.values - exact).max()
    return errors


class _Push(eqx.Module):
    """A unit force on the first unknown from t = 0 on."""

    n: int = eqx.field(static=True)

    def __call__(self, t):
        return jnp.zeros(self.n).at[0].set(1.0)


def _error_of_wave(scheme: Scheme, courant: float, elements: int) -> float:
    """Root mean square error of the velocity along a bar that is pushed at one end, at the end of a run.

    The bar has lumped masses, and its wave speed and impedance are 1. The exact velocity is 1 behind the front and 0
    ahead of it.
    """
    h = 1 / elements
    stiffness = (np.diag(np.full(elements, 2.0)) - np.eye(elements, k=1) - np.eye(elements, k=-1)) / h
    stiffness[0, 0] = 1 / h
    mass = np.full(elements, h)
    mass[0] = h / 2
    bar = Problem(stiffness=stiffness, u0=np.zeros(elements), mass=mass, load=_Push(elements), title="pushed bar")
    steps = round(REACHED / (courant * h))
    v = sweep(bar, scheme, dt=REACHED / steps, steps=steps, every=steps).v.values[-1]
    return float(np.sqrt(np.mean((v - (np.arange(elements) * h < REACHED)) ** 2)))


def _errors_of_mixed_pade() -> np.ndarray:
    """Errors of mixed Padé methods at the end of a run, (terms, steps).

    An error is the norm of the errors of u and u̇. The oscillator ü + 0.2u̇ + u = cos(1.5t − 0.7) starts from u = 1 at
    rest.
    """
    problem = Problem(
        stiffness=1.0, damping=0.2, u0=1.0, load=HarmonicLoad(1.0, frequency=1.5, phase=0.7), title="linear oscillator"
    )

    def rates(t, y):
        return [y[1], np.cos(1.5 * t - 0.7) - 0.2 * y[1] - y[0]]

    exact = solve_ivp(rates, (0.0, DURATION), [1.0, 0.0], "DOP853", **TOLERANCES).y[:, -1]
    errors = np.empty((len(TERMS), len(LONG)))
    for (m, k), _ in np.ndenumerate(errors):
        ds = run(
            problem, MixedPade(terms=TERMS[m], rho_inf=RHO_INF), dt=DURATION / LONG[k], steps=LONG[k], every=LONG[k]
        )
        errors[m, k] = np.linalg.norm([ds.u.values[-1] - exact[0], ds.v.values[-1] - exact[1]])
    return errors


def _errors_of_lagging() -> np.ndarray:
    """Errors of schemes whose velocity lags, at the end of a run, (lagging, start, steps).

    The oscillator ü + 0.2u̇ + u + u³ = cos(1.5t − 0.7) starts from u₀ = 2 with u̇₀ = 0, or with −γΔt ü₀, the velocity at
    the time −γΔt.
    """
    problem = Problem(
        force=lambda u: u + u * u * u, damping=0.2, u0=2.0, load=HarmonicLoad(1.0, frequency=1.5, phase=0.7),
        title="hardening oscillator",
    )  # fmt: skip

    def rates(t, y):
        return [y[1], np.cos(1.5 * t - 0.7) - 0.2 * y[1] - y[0] - y[0] ** 3]

    exact = solve_ivp(rates, (0.0, DURATION), [2.0, 0.0], "DOP853", **TOLERANCES).y[0, -1]
    dt, acceleration = DURATION / np.array(MANY), rates(0.0, [2.0, 0.0])[1]
    errors = np.empty((len(LAGGING), 2, len(MANY)))
    for s, scheme in enumerate(LAGGING.values()):
        starts = np.outer([0.0, -scheme.velocity_lag * acceleration], dt)
        ends = sweep(
            problem,
            scheme,
            dt=np.tile(dt, 2),
            steps=np.tile(MANY, 2),
            v0=starts.ravel(),
            observe=[Quantity(lambda u: u, name="end", reduce="final")],
        )
        errors[s] = np.abs(ends.end.values - exact).reshape(starts.shape)
    return errors


def _radius_of_mixed_pade(terms: int) -> float:
    """Spectral radius of a mixed Padé method without damping at ωΔt = 10⁶."""
    return LinearTheory(MixedPade(terms=terms, rho_inf=RHO_INF), [1e6 / (2 * np.pi)]).spectral_radius.item()


@experiment("later_schemes")
@short_runs()
def later_schemes(
    omega_steps: Sizes, steps: RisingCounts, courant: Sizes, elements: Length, long_steps: Sizes, forces: Counts
) -> xr.Dataset:
    """Test claims of the authors of later schemes that go beyond linear theory.

    Parameters
    ----------
    omega_steps
        ωΔt of the model. For each value, the largest ratio of tangent to model stiffness with stable steps is found.
    steps
        Numbers of steps of two kinds of runs: trigonometric methods on a soft and a stiff unknown, and BDF2 with a
        scalar auxiliary variable next to average acceleration on the hardening oscillator.
    courant, elements
        Courant numbers (Δt divided by the time in which a wave crosses an element), and number of elements of the bar.
    long_steps
        Step sizes of runs of a thousand steps of BDF2 with the auxiliary variable on the oscillator ü + u + u³ = 0.
    forces
        Numbers of force evaluations that each scheme of fourth order spends on the same motion.
    """
    plain = circumstances_with([])["plain"]
    auxiliary: dict[str, Scheme] = {
        "auxiliary_variable": AuxiliaryVariable(),
        "average_acceleration": average_acceleration,
    }
    displacement = QUANTITIES.index("displacement")
    peaks = [
        float(sweep(plain.problem, AuxiliaryVariable(), dt=dt, steps=1000, observe="peak").peak) for dt in long_steps
    ]
    fourth = [
        plain.errors(scheme, [count // forces_of(scheme).per_step for count in forces])
        for scheme in FOURTH_ORDER.values()
    ]
    error = {"long_name": "error of the displacement over the motion", "units": "1"}
    return xr.Dataset(
        {
            "largest_stiffening": (
                ("with_model", "omega_step"),
                [[_largest_stiffening(scheme, dt) for dt in omega_steps] for scheme in WITH_MODEL.values()],
                {"long_name": "largest ratio of the tangent to the model up to which a step is stable", "units": "1"},
            ),
            "trigonometric_end_error": (
                ("member", "steps"),
                _errors_of_trigonometric(steps),
                {"long_name": "largest error of the displacements over all ωΔt", "units": "1"},
            ),
            "wave_error": (
                ("wave_scheme", "courant"),
                [[_error_of_wave(scheme, number, elements) for number in courant] for scheme in OF_WAVES.values()],
                {"long_name": "root mean square error of the velocity along a bar over its size", "units": "1"},
            ),
            "auxiliary_error": (
                ("auxiliary", "steps"),
                [plain.errors(scheme, steps)[displacement] for scheme in auxiliary.values()],
                error,
            ),
            "auxiliary_peak": (
                "step_size",
                peaks,
                {"long_name": "largest displacement of a thousand steps of the auxiliary variable", "units": "1"},
            ),
            "pade_error": (
                ("terms", "long_steps"),
                _errors_of_mixed_pade(),
                {"long_name": "error of a linear oscillator by mixed Padé methods", "units": "1"},
            ),
            "lag_error": (
                ("lagging", "lagged_start", "many_steps"),
                _errors_of_lagging(),
                {
                    "long_name": "error of the displacement at the end of a run of a scheme whose velocity lags",
                    "units": "1",
                },
            ),
            "pade_radius": (
                "terms",
                [_radius_of_mixed_pade(terms) for terms in TERMS],
                {"long_name": "spectral radius of mixed Padé methods at ωΔt = 10⁶", "units": "1"},
            ),
            "fourth_order_error": (
                ("fourth_order_scheme", "force_evaluations"),
                [errors[displacement] for errors in fourth],
                error,
            ),
        },
        coords={
            "with_model": ("with_model", list(WITH_MODEL), {"long_name": "scheme with a model of the structure"}),
            "omega_step": ("omega_step", list(omega_steps), {"long_name": "ωΔt of the model", "units": "1"}),
            "member": ("member", list(filters), {"long_name": "trigonometric method"}),
            "steps": ("steps", list(steps), {"long_name": "number of steps", "units": "1"}),
            "wave_scheme": ("wave_scheme", list(OF_WAVES), {"long_name": "scheme for the wave"}),
            "courant": ("courant", list(courant), {"long_name": "Courant number", "units": "1"}),
            "auxiliary": ("auxiliary", list(auxiliary), {"long_name": "scheme to compare with the auxiliary variable"}),
            "step_size": ("step_size", list(long_steps), {"long_name": "step", "units": "s"}),
            "terms": ("terms", list(TERMS), {"long_name": "order of the Padé expansions", "units": "1"}),
            "long_steps": ("long_steps", list(LONG), {"long_name": "number of steps", "units": "1"}),
            "lagging": ("lagging", list(LAGGING), {"long_name": "scheme whose carried velocity lags"}),
            "lagged_start": ("lagged_start", list(STARTS), {"long_name": "velocity from which a run starts"}),
            "many_steps": ("many_steps", list(MANY), {"long_name": "number of steps", "units": "1"}),
            "fourth_order_scheme": ("fourth_order_scheme", list(FOURTH_ORDER), {"long_name": "scheme of fourth order"}),
            "force_evaluations": ("force_evaluations", list(forces), {"long_name": "forces evaluated", "units": "1"}),
        },
        attrs={
            "title": "Claims of the authors of later schemes that go beyond linear theory",
            "duration": DURATION,
            "rho_inf": RHO_INF,
        },
    )
