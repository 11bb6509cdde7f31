"""Warnings of runs whose step exceeds the stability limit for small motions about the start."""

import warnings

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy
from jax.experimental.sparse import BCOO

import study
from study.marching import stability
from study.marching.failure import likely_cause
from study.marching.result import NOT_FINITE
from study.marching.run import sweep

#: Positive solution z of z⁴/24 − z³/6 + z²/2 − z + 1 = 1: rk4 is stable on u̇ = −c u up to cΔt = z.
HEAVY = 2.785293563405282

#: Number of masses of a chain with unit springs and masses between two walls.
MASSES = 50

#: Angles θ of the modes of this chain: ω² = 2 − 2 cos θ, and the eigenvalue of its consistent mass is (4 + 2 cos θ)/6.
ANGLES = np.arange(1, MASSES + 1) * np.pi / (MASSES + 1)

STIFFNESS = scipy.sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(MASSES, MASSES))
CONSISTENT = scipy.sparse.diags_array([1 / 6, 4 / 6, 1 / 6], offsets=[-1, 0, 1], shape=(MASSES, MASSES))


def warned(problem, scheme, **arguments):
    """The text of the warning of a run; empty without a warning."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        study.run(problem, scheme, **({"steps": 3, "observe": "peak"} | arguments))
    assert len(caught) <= 1 and all(warning.category is RuntimeWarning for warning in caught)
    return str(caught[0].message) if caught else ""


def oscillator(k=4.0, **more):
    return study.Problem(stiffness=k, u0=1.0, **more)


@pytest.mark.slow
@pytest.mark.parametrize(
    "scheme, limit",
    [
        ("central_difference", 2.0),
        ("linear_acceleration", 2 * np.sqrt(3)),
        ("fox_goodwin", np.sqrt(6)),
        ("rk4", 2 * np.sqrt(2)),
        ("average_acceleration", np.inf),
    ],
)
def test_a_step_beyond_the_limit_is_said_and_a_step_at_the_limit_is_not(scheme, limit):
    at = min(limit, 100.0) / 2  # ω = 2
    assert not warned(oscillator(), scheme, dt=0.5 * at)
    assert not warned(oscillator(), scheme, dt=at)
    assert not warned(oscillator(), scheme, dt=np.nextafter(at, 9.0))
    text = warned(oscillator(), scheme, dt=1.001 * at)
    assert bool(text) == np.isfinite(limit)
    assert not text or (
        text.startswith(f"ωΔt = {1.001 * limit:.4g} at the start exceeds {limit:.4g}, the stability limit of ")
        and 0.999 * at < float(text.partition("allows steps up to ")[2].partition(";")[0]) < at * (1 + 1e-9)
    )


@pytest.mark.slow
def test_the_limit_of_heavy_damping_is_that_of_the_damping():
    heavy = oscillator(1e-6, damping=100.0)
    damper = study.Problem(lambda u, v: 100.0 * v, 1.0, 1.0)
    for problem in (heavy, damper):
        assert not warned(problem, "rk4", dt=0.9999 * HEAVY / 100)
        text = warned(problem, "rk4", dt=1.01 * HEAVY / 100)
        assert f"cΔt/m = {1.01 * HEAVY:.4g} at the start exceeds {HEAVY:.4g}, the stability limit of" in text
        # central difference takes the velocity at the end of the step, which damping does not limit
        assert not warned(problem, "central_difference", dt=1.0)


def test_the_limit_with_damping_is_that_of_the_damping_ratio():
    def growth(omega, ratio=0.1):
        z = omega * complex(-ratio, np.sqrt(1 - ratio**2))
        return abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24) - 1

    limit = scipy.optimize.brentq(growth, 2.0, 4.0)
    problem = oscillator(1.0, damping=0.2)
    assert abs(limit - 2 * np.sqrt(2)) > 0.1 and not warned(problem, "rk4", dt=0.999 * limit)
    assert f"exceeds {limit:.4g}, the stability limit of 'Runge-Kutta' with the damping ratio 0.1" in warned(
        problem, "rk4", dt=1.001 * limit
    )


def test_gyroscopic_motion_has_a_limit():
    proton = study.Problem(lambda u, v: 10.0 * jnp.stack([-v[1], v[0], 0 * v[2]]), np.zeros(3), [1.0, 0.0, 1.0])
    assert not warned(proton, "rk4", dt=0.1 * 2.82) and "ωΔt = 2.83 " in warned(proton, "rk4", dt=0.283)


def test_a_stiff_mode_that_is_not_excited_counts():
    problem = study.Problem(stiffness=np.array([[101.0, -100.0], [-100.0, 101.0]]), u0=[1.0, 1.0])
    limit = 2 / np.sqrt(201)
    assert not warned(problem, "central_difference", dt=0.999 * limit)
    assert "ωΔt = 2.002" in warned(problem, "central_difference", dt=1.001 * limit)


def _chains():
    full = STIFFNESS.toarray()
    shared = {"u0": np.sin(np.arange(MASSES))}

    def force(u):
        return 2 * u - jnp.pad(u[1:], (0, 1)) - jnp.pad(u[:-1], (1, 0))

    rayleigh = study.Rayleigh(a=0.0, b=1e-9)
    return {
        "dense": lambda: study.Problem(stiffness=full, tangent="dense", **shared),
        "band": lambda: study.Problem(force, **shared),
        "sparse": lambda: study.Problem(stiffness=scipy.sparse.csr_array(STIFFNESS), **shared),
        "BCOO": lambda: study.Problem(stiffness=BCOO.fromdense(full), **shared),
        "matrix-free": lambda: study.Problem(force, tangent="matrix_free", damping=rayleigh, **shared),
        "consistent": lambda: study.Problem(stiffness=full, mass=CONSISTENT.toarray(), **shared),
        "consistent, sparse": lambda: study.Problem(stiffness=STIFFNESS, mass=CONSISTENT, **shared),
    }


@pytest.mark.parametrize("form", _chains())
def test_the_limit_of_many_unknowns_in_every_form(form):
    """A form of mass or stiffness whose stability limit is not found, or found too low."""
    mass = (4 + 2 * np.cos(ANGLES)) / 6 if form.startswith("consistent") else 1.0
    limit = 2 / np.sqrt(np.max((2 - 2 * np.cos(ANGLES)) / mass))
    problem = _chains()[form]()
    assert not warned(problem, "central_difference", dt=0.9999 * limit)
    assert "exceeds 2, the stability limit" in warned(problem, "central_difference", dt=1.005 * limit)


@pytest.mark.slow
def test_the_worst_lane_is_named():
    text = warned(oscillator(1.0), "central_difference", dt=[0.1, 2.1, 2.5, 0.2])
    assert text.startswith("ωΔt = 2.5 at the start in lane 2 exceeds 2,")
    text = warned(oscillator, "central_difference", over={"k": [1.0, 9.0, 4.0]}, dt=1.1)
    assert text.startswith("ωΔt = 3.3 at the start in lane 1 exceeds 2,") and "up to 0.6666;" in text
    assert not warned(oscillator, "central_difference", over={"k": [1.0, 3.0]}, dt=1.1)


def test_no_mode_exceeds_the_bound_that_saves_its_computation():
    """Modes of random structures, from SciPy."""
    random = np.random.default_rng(3)
    for n in (2, 3, 5):
        roots = random.normal(size=(3, n, n))
        stiffness, damping, mass = roots[0] @ roots[0].T, roots[1] @ roots[1].T, np.eye(n) + 0.1 * roots[2] @ roots[2].T
        omega = np.sqrt(scipy.linalg.eigh(stiffness, mass, eigvals_only=True)[-1])
        heaviest = scipy.linalg.eigh(damping, mass, eigvals_only=True)[-1]
        motion = stability.SmallMotion(*(x[None] for x in (mass, stiffness, damping)))
        assert stability._highest_bound(motion) >= omega + heaviest
        dt = np.array([1e-3, 0.9, 1.1]) * 2 / omega  # without damping, central difference is stable up to ωΔt = 2
        lanes = stability.SmallMotion(*(np.broadcast_to(x, (3, 1, n, n)) for x in (mass, stiffness)))
        excess = stability.excess(study.schemes["central_difference"], lanes, dt, 10)
        np.testing.assert_allclose(excess, [0.0, 0.0, 2.2], rtol=1e-10)


def test_the_vector_of_the_largest_eigenvalue_of_a_tridiagonal_matrix():
    random = np.random.default_rng(5)
    for n in (2, 7, 24):
        a, b = random.normal(size=n), np.abs(random.normal(size=n - 1))
        values, vectors = scipy.linalg.eigh_tridiagonal(a, b)
        vector = np.asarray(stability._highest_of_tridiagonal(jnp.asarray(a), jnp.asarray(b)))
        np.testing.assert_allclose(np.abs(vector @ vectors[:, -1]), 1.0, rtol=1e-12)
        assert vector @ (np.diag(a) + np.diag(b, 1) + np.diag(b, -1)) @ vector == pytest.approx(values[-1], rel=1e-12)


def test_a_force_that_is_bounded_bounds_the_run_but_not_its_error():
    softening = warned("softening", "central_difference", dt=0.9, steps=1000)
    # about u = 0 the spring 100 tanh(u) has ω = 10
    assert softening.startswith("ωΔt = 9 about u = 0 exceeds 2,") and "up to 0.2;" in softening
    spring = study.materials.elastoplastic(stiffness=53.0**2, yield_force=30.0, hardening=0.02)
    frame = study.Problem(spring, 0.0, load=lambda t: 20 * jnp.sin(5 * t), title="yielding frame")
    assert warned(frame, "central_difference", dt=0.2, steps=20).startswith("ωΔt = 10.6 at the start exceeds 2,")
    assert not warned(frame, "central_difference", dt=0.037, steps=20)


def test_what_ends_a_run_that_grows_is_the_limit():
    with pytest.raises(RuntimeError, match=r"Likely cause: cΔt/m = 3 at the start exceeds 2\.785, the stability limit"):
        study.run(oscillator(1e-6, damping=100.0), "rk4", dt=0.03, steps=9999, on_failure="raise")
    with pytest.raises(RuntimeError, match=r"Likely cause: ωΔt = 3 at the start exceeds 2, the stability limit"):
        study.run(oscillator(), "central_difference", dt=1.5, steps=9999, on_failure="raise")


def test_a_step_just_beyond_the_limit_is_told_from_it():
    text = warned(oscillator(1.0), "central_difference", dt=2 * (1 + 2e-5), steps=20)
    assert text.startswith("ωΔt = 2.00004 at the start exceeds 2, the stability limit of 'Central difference'")


@pytest.mark.parametrize("ratio", [1.0, 1.5])
def test_moderate_damping_is_stated_with_the_limit_of_the_frequency(ratio):
    """The faster root of the mode is (ζ + √(ζ² − 1)) ω, and the Runge-Kutta method is stable up to 2.7853 in Δt."""
    root = ratio + np.sqrt(ratio**2 - 1)
    text = warned(oscillator(1.0, damping=2 * ratio), "rk4", dt=3.5 / root, steps=9)
    assert text.startswith(f"ωΔt = {3.5 / root:.4g} at the start exceeds {2.7853 / root:.4g}, the stability limit of")
    assert f"with the damping ratio {ratio:.3g}, which" in text


def test_a_failed_run_is_reported_once():
    with pytest.warns(study.RunFailedWarning, match="exceeds 2, the stability limit") as caught:
        study.run(oscillator(), "central_difference", dt=1.5, steps=9999, observe="peak")
    assert len(caught) == 1


def test_an_unstable_scheme_is_reported_if_it_amplifies_the_motion():
    # the roots of the scheme have the size 1 + Ω⁶/288 or less, so that 1000 steps with Ω = 0.1 change nothing
    assert not warned(oscillator(1.0), "dormand_prince6", dt=0.1, steps=1000)
    assert "at every step" in warned(oscillator(1.0), "dormand_prince6", dt=2.0, steps=1000)


@pytest.mark.parametrize(
    "name, remedy",
    [
        ("dormand_prince6", "take another scheme, or steps of little growth."),
        ("central_difference", "take smaller steps or an implicit scheme."),
    ],
)
def test_smaller_steps_are_no_remedy_if_no_step_is_stable(name, remedy):
    assert likely_cause(oscillator(1.0), study.schemes[name], NOT_FINITE, 3.0).endswith(remedy)


def test_in_single_precision_a_step_at_the_limit_holds():
    with jax.enable_x64(False):
        assert not warned(oscillator(), "central_difference", dt=np.float32(1.0))
        assert warned(oscillator(), "central_difference", dt=np.float32(1.01))


@pytest.mark.slow
def test_the_force_of_now_counts():
    held = {"k": 1.0}
    spring = study.Problem(lambda u: held["k"] * u, 1.0)
    assert not warned(spring, "central_difference", dt=1.0)
    held["k"] = 9.0
    assert warned(spring, "central_difference", dt=1.0).startswith("ωΔt = 3 at the start exceeds 2,")
    softer_later = study.Problem(lambda u, v, t: (9.0 - t) * u + v, 1.0)
    assert warned(softer_later, "central_difference", dt=1.0).startswith("ωΔt = 3 at the start exceeds 2,")


def test_no_other_run_warns():
    """A warning of an unstable step where linear theory at the start says nothing."""
    hardening = study.Problem(lambda u: u + 1e4 * u**3, 0.0, 0.01)
    assert not warned(hardening, "central_difference", dt=0.5)
    assert not warned("double_well", "central_difference", dt=0.1)
    assert not warned(study.Problem(lambda u: -u, 0.1), "central_difference", dt=3.0)
    python_problem = study.Problem(lambda u: jax.pure_callback(np.sin, u, u), 1.0)
    assert not warned(python_problem, "central_difference", dt=3.0)
    assert not warned(study.Problem(stiffness=np.eye(2), mass=[1.0, 0.0], u0=[1.0, 0.0]), "bathe", dt=3.0)
    controlled = {"tolerance": 1e-3, "duration": 9.0, "steps": None, "observe": "trajectory"}
    assert not warned(oscillator(), "rk4", **controlled)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sweep(oscillator(), "central_difference", dt=1.5, steps=3)
    assert warned(oscillator(), "central_difference", dt=1.5, on_failure="ignore")
