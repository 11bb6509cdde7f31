"""Chains of masses: Fermi, Pasta and Ulam's chain, Toda's chain, and bars under impact and under a step load."""

import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import Scalar, Vector
from study.algebra.matrices import shifted
from study.mechanics.definition import Problem
from study.mechanics.loads import HalfSine
from study.mechanics.terms import StrainEnergy
from study.problem.naming import Known, named

#: Circular frequency ω of the stiff springs.
FPU_FREQUENCY = 50.0


@named(time_scale=2 * np.pi)  # about the period of the soft springs
def fpu_chain(separate: bool = False) -> Problem:
    r"""The chain of Fermi, Pasta and Ulam: stiff linear and soft non-linear springs alternate.

    .. math::

        V = \tfrac12 \omega^2 \sum_{i=1}^3 x_{1,i}^2 + \tfrac14 [(x_{0,1} - x_{1,1})^4
            + \sum_{i=1}^2 (x_{0,i+1} - x_{1,i+1} - x_{0,i} - x_{1,i})^4 + (x_{0,3} + x_{1,3})^4]

    u = (x₀₁, x₀₂, x₀₃, x₁₁, x₁₂, x₁₃), where x₁ᵢ are elongations of the stiff springs, and ω = 50. The motion starts
    with x₀₁ = 1, ẋ₀₁ = 1, x₁₁ = 1/ω, ẋ₁₁ = 1 and zero elsewhere. The stiff springs exchange their oscillatory energies
    :math:`I_i = (\dot x_{1,i}^2 + \omega^2 x_{1,i}^2)/2` over times of order ω. The sum I of these energies is nearly
    constant over very long times. With ``separate`` the stiff springs are the stiffness of the problem, and the soft
    springs are its force.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, sections I.5.1 and XIII.
    """

    def soft(u):
        slow, stiff = u[:3], u[3:]
        links = slow[1:] - stiff[1:] - slow[:-1] - stiff[:-1]
        return jnp.concatenate([(slow[0] - stiff[0])[None], links, (slow[2] + stiff[2])[None]])

    def all_springs(u):
        return jnp.concatenate([u[3:], soft(u)])

    def density(e):
        return jnp.concatenate([FPU_FREQUENCY**2 * e[:3] ** 2 / 2, e[3:] ** 4 / 4])

    return Problem(
        potential=StrainEnergy(soft, lambda e: e**4 / 4) if separate else StrainEnergy(all_springs, density),
        stiffness=np.array([0.0] * 3 + [FPU_FREQUENCY**2] * 3) if separate else None,
        u0=[1.0, 0.0, 0.0, 1 / FPU_FREQUENCY, 0.0, 0.0],
        v0=[1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        title="Fermi-Pasta-Ulam chain",
    )


def oscillatory_energy(spring: int, u: Vector, v: Vector) -> Scalar:
    """Energy I₁, I₂ or I₃ of a stiff spring of :func:`fpu_chain`, for ``spring`` = 0, 1 or 2."""
    return (v[3 + spring] ** 2 + FPU_FREQUENCY**2 * u[3 + spring] ** 2) / 2


def toda_soliton(n: int, t: float, kappa: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    r"""Displacement and velocity (n,) of a soliton in an endless Toda chain; it is near mass n/4 at t = 0.

    .. math::

        q_j = \ln\cosh(x - \kappa) - \ln\cosh x, \quad x = \kappa\,(j - n/4) - t \sinh\kappa
    """
    x = kappa * (np.arange(1, n + 1) - n / 4) - t * np.sinh(kappa)

    def log_cosh(y):
        return np.logaddexp(y, -y) - np.log(2)

    return log_cosh(x - kappa) - log_cosh(x), np.sinh(kappa) * (np.tanh(x) - np.tanh(x - kappa))


@named(time_scale=np.pi)  # the shortest period of a linear chain
def toda_chain(n: int = 200) -> Problem:
    r"""Toda's chain of n masses between fixed ends; its springs have the elongations r_j.

    .. math::

        V = \sum_j (\exp(-r_j) + r_j - 1)

    The motion starts as the soliton of ``toda_soliton`` with κ = 1, which keeps its form until it reaches the end.

    References
    ----------
    M. Toda, Vibration of a chain with nonlinear interaction, J. Phys. Soc. Jpn. 22(2), 1967, 431-436.
    """
    kappa = 1.0
    u0, v0 = toda_soliton(n, 0.0, kappa)

    def strains(u):
        return jnp.pad(u, (0, 1), constant_values=-kappa) - jnp.pad(u, (1, 0), constant_values=kappa)

    energy = StrainEnergy(strains, lambda r: jnp.expm1(-r) + r)
    return Problem(potential=energy, u0=u0, v0=v0, tangent="tridiagonal", title="Toda chain")


@named(time_scale=1.0, time_scale_name="passage of a small wave")
def impact_bar(n: int = 200) -> Problem:
    r"""A hardening elastic bar of n finite elements, fixed at one end and struck at the other by half a sine.

    .. math::

        V = \sum h\,(\varepsilon^2/2 + \kappa\,\varepsilon^4/4), \quad \varepsilon = \Delta u/h, \quad h = 1/n,
            \quad \kappa = 10

    Young's modulus, density, length and cross section are one. Small waves cross the bar in unit time; large waves
    steepen. The mass is lumped. The pulse has an amplitude of ½ and a duration of 0.2.

    References
    ----------
    T. Belytschko, W. K. Liu, B. Moran, Nonlinear finite elements for continua and structures, Wiley, 2000, chapter 2.
    """
    h, hardening = 1 / n, 10.0

    def strains(u):
        return (shifted(u, 1) - u) / h

    energy = StrainEnergy(strains, lambda e: h * (e * e / 2 + hardening * e**4 / 4))
    mass = np.full(n, h)
    mass[0] = h / 2
    zero, impact = np.zeros(n), np.zeros(n)
    impact[0] = 0.5
    return Problem(
        potential=energy,
        u0=zero,
        v0=zero,
        mass=mass,
        load=HalfSine(impact, duration=0.2),
        tangent="tridiagonal",
        title="bar under impact",
    )


#: Number of elements of the bar under a step load.
_ELEMENTS = 64


@named(
    time_scale=4.0,  # period of the first mode
    known=Known(2.0, "d'Alembert", u=2 * (1 - np.arange(_ELEMENTS) / _ELEMENTS)),
)
def loaded_bar() -> Problem:
    r"""A linear elastic bar of 64 finite elements, fixed at one end, with a unit force at the other from t = 0.

    Young's modulus, density, length and cross section are one, and the mass is lumped. By d'Alembert's solution of the
    wave equation a strain of one travels to the fixed end and comes back doubled, so that at t = 2 the displacement at
    the distance x from the loaded end is 2 (1 − x), twice the static one. Central difference gives this exactly at the
    step size 1/64, the time in which a wave crosses an element. At smaller step sizes an error of the elements remains.

    References
    ----------
    T. Belytschko, W. K. Liu, B. Moran, Nonlinear finite elements for continua and structures, Wiley, 2000, chapter 2.
    """
    n = _ELEMENTS
    mass = np.full(n, 1 / n)
    mass[0] = 1 / (2 * n)
    energy = StrainEnergy(lambda u: n * (shifted(u, 1) - u), lambda e: e * e / (2 * n))
    end = np.zeros(n)
    end[0] = 1.0
    return Problem(
        potential=energy,
        u0=np.zeros(n),
        mass=mass,
        load=lambda t: jnp.asarray(end),
        tangent="tridiagonal",
        title="bar under a step load",
    )
