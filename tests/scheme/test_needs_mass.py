"""Schemes that need a mass at every unknown: their declaration, compared with their roots at infinite frequency."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import study
from study.analysis.forces import forces_of
from study.analysis.linear_theory import LinearTheory
from study.scheme.houbolt import starts
from study.scheme.rederived import Rederived
from study.scheme.wrapper.compensated import Compensated
from study.scheme.wrapper.linearised import Linearised

# random parameters also make schemes that grow
pytestmark = pytest.mark.filterwarnings("ignore:.* has negative numerical damping:RuntimeWarning")

#: Tolerance of a spectral radius of one, because a triple root at −1 is known to a third of its digits only.
GROWTH = 1e-3

#: Smallest distance of tested parameters from the bound of a condition, unless they lie exactly on the bound.
EDGE = 0.02

theta = st.one_of(st.just(1.0), st.floats(1.0, 4.0))
beta = st.sampled_from([0.0, 1 / 12, 1 / 6, 0.25, 0.3025, 0.5]) | st.floats(0.05, 0.5)
gamma = st.sampled_from([0.0, 0.5, 0.6, 1.0]) | st.floats(0.0, 1.0)


def _grows(scheme) -> bool:
    """Whether the spectral radius at infinite frequency exceeds one, by linear theory of the scheme's step."""
    return LinearTheory(scheme, np.array([1.0])).infinite_frequency_radius() > 1 + GROWTH


def _off_the_edge(beta, gamma):
    """Reject parameters that are close to a bound of Newmark's condition 2β ≥ γ ≥ ½, but not on it."""
    assume(all(difference == 0 or abs(difference) > EDGE for difference in (2 * beta - gamma, gamma - 0.5)))


@settings(max_examples=60, deadline=None)
@given(beta=beta, gamma=gamma)
def test_newmark(beta, gamma):
    _off_the_edge(beta, gamma)
    scheme = study.Newmark(beta=np.float64(beta), gamma=np.float64(gamma))
    assert scheme.needs_mass == _grows(scheme)


@settings(max_examples=60, deadline=None)
@given(alpha=st.floats(-1 / 3, 0.0), beta=beta, gamma=gamma)
def test_the_alpha_method_of_1996(alpha, beta, gamma):
    _off_the_edge(beta, gamma)
    scheme = study.HHTAlpha1996(alpha=np.float64(alpha), beta=np.float64(beta), gamma=np.float64(gamma))
    assert scheme.needs_mass == _grows(scheme)


@settings(max_examples=60, deadline=None)
@given(
    alpha_m=st.floats(-1.0, 0.5), alpha_f=st.floats(0.0, 0.5), beta=beta | st.floats(0.5, 1.0),
    gamma=gamma | st.floats(1.0, 1.5),
)  # fmt: skip
def test_the_generalized_alpha_method(alpha_m, alpha_f, beta, gamma):
    _off_the_edge(beta, gamma)
    scheme = study.GeneralizedAlpha(
        alpha_m=np.float64(alpha_m), alpha_f=np.float64(alpha_f), beta=np.float64(beta), gamma=np.float64(gamma)
    )
    assert scheme.needs_mass == _grows(scheme)


@settings(max_examples=60, deadline=None)
@given(theta=theta, beta=beta, gamma=gamma)
def test_wilsons_method(theta, beta, gamma):
    scheme = study.WilsonTheta(theta=np.float64(theta), beta=np.float64(beta), gamma=np.float64(gamma))
    radius = LinearTheory(scheme, np.array([1.0])).infinite_frequency_radius()
    assume(abs(radius - 1) > GROWTH)
    assert scheme.needs_mass == (radius > 1)


@pytest.mark.parametrize("theta, needs", [(1.36, True), (1.366, True), (1.3661, False), (1.4, False), (10.0, False)])
def test_wilsons_condition_is_that_of_the_textbook(theta, needs):
    """With β = 1/6 and γ = ½ the limit is (1 + √3)/2 = 1.36603."""
    assert study.WilsonTheta(theta=theta).needs_mass == needs


@pytest.mark.parametrize(
    "beta, gamma", [(0.0, 0.5), (0.0, 0.0), (1 / 12, 0.5), (1 / 6, 0.5), (0.25, 0.5), (0.25, 0.4), (0.3025, 0.6)]
)
def test_wilsons_method_with_theta_one_needs_what_newmarks_needs(beta, gamma):
    assert (
        study.WilsonTheta(theta=1.0, beta=beta, gamma=gamma).needs_mass
        == study.Newmark(beta=beta, gamma=gamma).needs_mass
    )


@settings(max_examples=40, deadline=None)
@given(gamma=st.floats(0.01, 0.99), rho_inf=st.floats(0.0, 1.0))
def test_bathes_methods_need_none(gamma, rho_inf):
    scheme = study.Bathe(gamma=np.float64(gamma), rho_inf=np.float64(rho_inf))
    assert not scheme.needs_mass and not _grows(scheme)


@settings(max_examples=40, deadline=None)
@given(beta1=st.floats(0.0, 1.0), beta2=st.floats(0.1, 1.0), gamma=st.floats(0.1, 0.9))
def test_bathes_method_with_two_weights(beta1, beta2, gamma):
    scheme = study.BetaBathe(beta1=np.float64(beta1), beta2=np.float64(beta2), gamma=np.float64(gamma))
    assume(abs(LinearTheory(scheme, np.array([1.0])).infinite_frequency_radius() - 1) > GROWTH)
    assert scheme.needs_mass == _grows(scheme)


@pytest.mark.parametrize(
    "make, least, most",
    [
        (study.GeneralizedAlpha.chung_hulbert, 0.0, 1.0),
        (study.GeneralizedAlpha.wbz, 0.0, 1.0),
        (study.GeneralizedAlpha.hht, 0.5, 1.0),
        (study.Bathe.with_one_stiffness, 0.0, 0.99),
    ],
)
def test_methods_of_given_radius_need_none(make, least, most):
    """At ρ∞ = 1 the α-methods are on the bound of the condition; round-off of their parameters must not violate it."""
    assert not any(make(rho_inf=rho_inf).needs_mass for rho_inf in np.linspace(least, most, 101).tolist())


#: Implicit schemes that the tests above do not cover, with several of their parameters.
OTHERS = [
    study.schemes["park"],
    study.Houbolt(),
    study.ImplicitMidpoint(),
    study.EnergyMomentum(),
    *(study.AverageVectorField(points=points) for points in (1, 2, 5)),
    study.Gauss4(),
    study.DiagonallyImplicit(sub_steps=3, rho_inf=0.0),
    study.TwoStep(rho_inf=0.8),
    study.DiagonallyImplicit(sub_steps=4, rho_inf=1.0),
]


@pytest.mark.slow
@pytest.mark.parametrize("scheme", OTHERS, ids=lambda scheme: scheme.title)
def test_the_other_implicit_schemes_need_none(scheme):
    assert not scheme.needs_mass and not _grows(scheme)


@pytest.mark.slow
@pytest.mark.parametrize(
    "weights", [(1.0, -1.0), (3 / 2, -2.0, 1 / 2), (11 / 6, -3.0, 3 / 2, -1 / 3), (25 / 12, -4.0, 3.0, -4 / 3, 1 / 4)]
)
def test_backward_differences_need_none(weights):
    test_the_other_implicit_schemes_need_none(study.BackwardDifferences(weights=weights))


def _massless():
    """A mass on two linear springs in series; the joint between the springs has no mass, and starts in balance."""
    springs = study.StrainEnergy(lambda u: jnp.stack([u[0], u[1] - u[0]]), lambda e: np.array([3.0, 1.5]) * e * e)
    return study.Problem(potential=springs, u0=[0.3, 0.9], v0=[0.2, 0.6], mass=[0.0, 2.0], title="joint")


@pytest.mark.parametrize(
    "scheme",
    [
        study.HHTAlpha1996(alpha=-0.1, beta=0.2, gamma=0.6),
        study.HHTAlpha1996(alpha=0.0, beta=1 / 6, gamma=0.5),
        study.GeneralizedAlpha(alpha_m=0.0, alpha_f=0.1, beta=0.2, gamma=0.6),
        study.WilsonTheta(theta=1.4, beta=0.0),
        Rederived(scheme=study.schemes["generalized_alpha"]),
        Compensated(scheme=study.schemes["linear_acceleration"]),
        Linearised(scheme=study.schemes["central_difference"]),
        *(study.Houbolt(start_by=start) for start in starts if start != "linear_acceleration"),
    ],
    ids=lambda scheme: f"{scheme.title} {getattr(scheme, 'start_by', '')}",
)
def test_a_mass_is_required_before_the_run(scheme):
    with pytest.raises(ValueError, match="needs a mass at every unknown, and the mass of 'joint' is singular"):
        study.run(_massless(), scheme, dt=0.1, steps=1)


def test_wrappers_refuse_what_the_scheme_within_refuses():
    problem = study.Problem(lambda u: u, u0=1.0, title="without potential")
    for wrapper in (Compensated, Linearised, Rederived):
        reason = wrapper(scheme=study.EnergyMomentum()).refusal(problem)
        assert reason == "'Energy-momentum' needs the potential of 'without potential': give Problem(potential=...)."


def test_a_scheme_that_fits_refuses_nothing(scheme):
    assert scheme.refusal(study.problems["hardening"]) is None


def test_a_rederived_acceleration_costs_a_force():
    scheme = study.schemes["hht_alpha_1996"]
    assert forces_of(Rederived(scheme=scheme)).per_step == forces_of(scheme).per_step + 1 == 2
