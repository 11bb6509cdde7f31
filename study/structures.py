"""Problems beyond the paper's oscillators: stiff, chaotic and large ones, each with its parameters and its source."""

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from study.linear import shifted
from study.problem import Problem, Rayleigh, StrainEnergy


class HarmonicLoad(eqx.Module):
    """A load amplitude cos(ωt − phase), its amplitude of the shape of the displacement."""

    amplitude: float | np.ndarray = eqx.field(converter=np.asarray)
    frequency: float = eqx.field(converter=np.float64)
    phase: float = eqx.field(converter=np.float64)

    def __call__(self, t):
        """The load at the time t."""
        return self.amplitude * jnp.cos(self.frequency * t - self.phase)


class _Scaled(eqx.Module):
    """A load times a factor."""

    load: Callable
    factor: float = eqx.field(converter=np.float64)

    def __call__(self, t):
        return self.factor * self.load(t)


def excited(problem: Problem, factor: float) -> Problem:
    """The problem with ``factor`` times its initial velocity and its load, in the same compiled programs."""
    problem = eqx.tree_at(lambda p: p.v0, problem, factor * problem.v0)
    if problem.load is None:
        return problem
    return eqx.tree_at(lambda p: p.load, problem, _Scaled(problem.load, factor))


def stiff_soft(soft_energy=lambda stretch: stretch * stretch / 2, title: str = "stiff and soft springs") -> Problem:
    """Two masses behind a support that moves, the first held by a stiff spring, the second by a soft one.

    ü₂ + k₁ (u₂ − u₁) − k₂ (u₃ − u₂) = 0,    ü₃ + k₂ (u₃ − u₂) = 0,    u₁ = sin 1.2t,    u = (u₂, u₃) from rest

    with k₁ = 10⁷ and k₂ = 1. The support has no mass; what it is moved by enters as the load k₁ u₁. The first mass
    follows the support, and its spring's own mode, of period 0.002, is what a structure has in its rigid links.

    References
    ----------
    K. J. Bathe, G. Noh, Insight into an implicit time integration scheme for structural dynamics, Comput. Struct.
    98-99, 2012, 1-6.
    """
    stiffness = 1e7
    energy = StrainEnergy(
        strains=lambda u: jnp.stack([u[0], u[1] - u[0]]),
        density=lambda e: jnp.stack([stiffness * e[0] ** 2 / 2, soft_energy(e[1])]),
    )
    load = HarmonicLoad(np.array([stiffness, 0.0]), frequency=1.2, phase=np.pi / 2)
    return Problem(potential=energy, u0=np.zeros(2), v0=np.zeros(2), load=load, title=title)


def stiff_soft_sine() -> Problem:
    """The system of :func:`stiff_soft` with the soft spring k₂ sin δ, δ = u₃ − u₂."""
    return stiff_soft(lambda stretch: 1 - jnp.cos(stretch), title="stiff and sine springs")


#: ω of the stiff springs of the chain.
FPU_FREQUENCY = 50.0


def fpu_chain() -> Problem:
    """The chain of Fermi, Pasta and Ulam with stiff linear and soft non-linear springs in turn.

    V = ω²/2 Σ x₁ᵢ² + ¼ [(x₀₁ − x₁₁)⁴ + Σ (x₀,ᵢ₊₁ − x₁,ᵢ₊₁ − x₀ᵢ − x₁ᵢ)⁴ + (x₀₃ + x₁₃)⁴],    i = 1, 2, 3

    u = (x₀₁, x₀₂, x₀₃, x₁₁, x₁₂, x₁₃), of which x₁ᵢ are elongations of the stiff springs, ω = 50. Starts with
    x₀₁ = 1, ẋ₀₁ = 1, x₁₁ = 1/ω, ẋ₁₁ = 1 and zero elsewhere. The stiff springs exchange their oscillatory energies
    Iᵢ = (ẋ₁ᵢ² + ω² x₁ᵢ²)/2 over times of order ω, while the sum I of them is nearly constant over very long ones.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, sections I.5.1 and XIII.
    """

    def strains(u):
        slow, stiff = u[:3], u[3:]
        links = slow[1:] - stiff[1:] - slow[:-1] - stiff[:-1]
        return jnp.concatenate([stiff, (slow[0] - stiff[0])[None], links, (slow[2] + stiff[2])[None]])

    def density(e):
        return jnp.concatenate([FPU_FREQUENCY**2 * e[:3] ** 2 / 2, e[3:] ** 4 / 4])

    return Problem(
        potential=StrainEnergy(strains, density),
        u0=[1.0, 0.0, 0.0, 1 / FPU_FREQUENCY, 0.0, 0.0],
        v0=[1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        title="Fermi-Pasta-Ulam chain",
    )


def oscillatory_energy(spring: int, u, v):
    """Iᵢ of the stiff spring i = 0, 1, 2 of :func:`fpu_chain`."""
    return (v[3 + spring] ** 2 + FPU_FREQUENCY**2 * u[3 + spring] ** 2) / 2


def elastic_pendulum() -> Problem:
    """A mass that circles about a point on a stiff elastic bar.

    V = EA/(8 L³) (x² + y² − L²)²,    u = (x, y) from (L, 0) with the velocity (0, v₀)

    L = 3.0443, m = 10, EA = 10¹⁰, v₀ = 7.72: a turn takes 2.48, the bar's own mode 3.5e-4.

    References
    ----------
    D. Kuhl, M. A. Crisfield, Energy-conserving and decaying algorithms in non-linear structural dynamics, Int. J.
    Numer. Methods Eng. 45, 1999, 569-599.
    """
    length, mass, rigidity = 3.0443, 10.0, 1e10
    energy = StrainEnergy(
        strains=lambda u: (jnp.vdot(u, u) - length**2)[None],
        density=lambda e: rigidity / (8 * length**3) * e**2,
    )
    return Problem(
        potential=energy,
        u0=[length, 0.0],
        v0=[0.0, 7.72],
        mass=mass,
        positions=np.zeros((1, 2)),
        title="elastic pendulum",
    )


def pendulum() -> Problem:
    """The plane pendulum ü + sin u = 0 that almost reaches its upper rest: u₀ = 0, u̇₀ = 1.999999238456499.

    Its period is 4K(u̇₀/2) = 33.7210, five times that of small oscillations.

    References
    ----------
    K. J. Bathe, Conserving energy and momentum in nonlinear dynamics: a simple implicit time integration scheme,
    Comput. Struct. 85, 2007, 437-445.
    """
    return Problem(
        jnp.sin, 0.0, 1.999999238456499, potential=lambda u: 2 * jnp.sin(u / 2) ** 2, title="pendulum near its top"
    )


def duffing(amplitude: float, title: str) -> Problem:
    """Duffing's oscillator with two wells, damped and forced: ü + 0.3 u̇ − u + u³ = γ cos 1.2t from (1, 0).

    γ = 0.2 settles to the period of the load, γ = 0.5 is chaotic.

    References
    ----------
    D. W. Jordan, P. Smith, Nonlinear ordinary differential equations, 4th ed., Oxford University Press, 2007, ch. 13.
    """
    return Problem(
        force=lambda u: u * u * u - u,
        u0=1.0,
        potential=lambda u: u * u * (u * u / 4 - 1 / 2),
        damping=0.3,
        load=HarmonicLoad(amplitude, frequency=1.2, phase=0.0),
        title=title,
    )


def toda_soliton(n: int, t: float, kappa: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity (n,) of a soliton in an endless Toda chain that is at mass n/4 at t = 0.

    q_j = ln cosh(x − κ) − ln cosh x,    x = κ (j − n/4) − t sinh κ
    """
    x = kappa * (np.arange(1, n + 1) - n / 4) - t * np.sinh(kappa)

    def log_cosh(y):
        return np.logaddexp(y, -y) - np.log(2)

    return log_cosh(x - kappa) - log_cosh(x), np.sinh(kappa) * (np.tanh(x) - np.tanh(x - kappa))


def toda_chain(n: int = 200) -> Problem:
    """Toda's chain with fixed ends and a soliton in it: V = Σ exp(−r_j) + r_j − 1 of the elongations r_j, n masses.

    The soliton of :func:`toda_soliton` with κ = 1 keeps its form until it comes to the end.

    References
    ----------
    M. Toda, Vibration of a chain with nonlinear interaction, J. Phys. Soc. Jpn. 22, 1967, 431-436.
    """
    kappa = 1.0
    u0, v0 = toda_soliton(n, 0.0, kappa)

    def strains(u):
        return jnp.pad(u, (0, 1), constant_values=-kappa) - jnp.pad(u, (1, 0), constant_values=kappa)

    energy = StrainEnergy(strains, lambda r: jnp.expm1(-r) + r)
    return Problem(potential=energy, u0=u0, v0=v0, tangent="tridiagonal", title="Toda chain")


class _Pulse(eqx.Module):
    """Half a sine of a force on the first unknown, then none."""

    n: int = eqx.field(static=True)
    amplitude: float = eqx.field(converter=np.float64)
    duration: float = eqx.field(converter=np.float64)

    def __call__(self, t):
        pulse = jnp.where(t < self.duration, self.amplitude * jnp.sin(jnp.pi * t / self.duration), 0.0)
        return jnp.zeros(self.n).at[0].set(pulse)


def impact_bar(n: int = 200) -> Problem:
    """An elastic bar of n finite elements that hardens, fixed at one end and struck at the other by half a sine.

    V = Σ h (ε²/2 + κ ε⁴/4),    ε = Δu/h,    h = 1/n,    κ = 10

    Young's modulus, density, length and cross section are one, so that slow waves cross it in unit time and large ones
    steepen; the mass is lumped. The pulse has the amplitude ½ and takes a time of 0.2.

    References
    ----------
    T. Belytschko, W. K. Liu, B. Moran, Nonlinear finite elements for continua and structures, Wiley, 2000, ch. 2.
    """
    h, hardening = 1 / n, 10.0

    def strains(u):
        return (shifted(u, 1) - u) / h

    energy = StrainEnergy(strains, lambda e: h * (e * e / 2 + hardening * e**4 / 4))
    mass = np.full(n, h)
    mass[0] = h / 2
    pulse = _Pulse(n, amplitude=0.5, duration=0.2)
    zero = np.zeros(n)
    return Problem(
        potential=energy, u0=zero, v0=zero, mass=mass, load=pulse, tangent="tridiagonal", title="bar under impact"
    )


def _mesh(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Joints (joints, 2) of a mesh of unit cells, numbered along the short side, and bars (bars, 2)."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    pairs = [
        (number[:-1], number[1:]),
        (number[:, :-1], number[:, 1:]),
        (number[:-1, :-1], number[1:, 1:]),
        (number[:-1, 1:], number[1:, :-1]),
    ]
    return np.stack([x.ravel(), y.ravel()], 1), np.concatenate([np.stack([a.ravel(), b.ravel()], 1) for a, b in pairs])


def _bars(joints: np.ndarray, bars: np.ndarray, rigidity: float, free: np.ndarray) -> StrainEnergy:
    """Energy EA L/2 ε² of every bar with Green's strain ε = (l² − L²)/(2L²), of the free joints' displacements."""
    first, second = bars.T
    edges = joints[second] - joints[first]
    squared = (edges**2).sum(axis=1)

    def strains(u):
        moved = jnp.zeros(joints.shape).at[free].set(u.reshape(-1, 2))
        change = moved[second] - moved[first]
        # (l² − L²) without the difference of large numbers
        return jnp.sum(change * (2 * edges + change), axis=1) / (2 * squared)

    return StrainEnergy(strains, lambda e: rigidity * np.sqrt(squared) / 2 * e * e)


#: Cells of the trusses along and across.
TRUSS = (24, 5)


def spinning_truss() -> Problem:
    """A truss of 24 by 5 cells that spins freely in its plane: 150 joints, 509 bars, 300 unknowns.

    Unit cells with both diagonals, unit mass at every joint, EA = 10⁴ of every bar with Green's strain, assembled from
    the energies of the bars by automatic differentiation. Starts undeformed with the velocity of a rigid rotation by
    one radian in unit time. Energy, linear and angular momentum are conserved.

    References
    ----------
    J. C. Simo, N. Tarnow, K. K. Wong, Exact energy-momentum conserving algorithms and symplectic schemes for nonlinear
    dynamics, Comput. Methods Appl. Mech. Eng. 100, 1992, 63-116 (the method and its test by a body that spins).
    """
    joints, bars = _mesh(*TRUSS)
    joints = joints - joints.mean(axis=0)
    velocity = np.stack([-joints[:, 1], joints[:, 0]], 1)
    return Problem(
        potential=_bars(joints, bars, 1e4, np.arange(len(joints))),
        u0=np.zeros(joints.size),
        v0=velocity.ravel(),
        tangent=2 * (TRUSS[1] + 2) + 1,
        positions=joints,
        title="spinning truss",
    )


def cantilever_truss() -> Problem:
    """The truss of :func:`spinning_truss` clamped at one end, with a load across the other that stays, and damping.

    288 unknowns. Rayleigh damping C = 0.02 M + 0.0005 K; a load of 0.5 at every joint of the free end, from rest.
    """
    joints, bars = _mesh(*TRUSS)
    free = np.flatnonzero(joints[:, 0] > 0)
    load = np.zeros((len(free), 2))
    load[joints[free, 0] == TRUSS[0], 1] = -0.5
    flat = load.ravel()
    zero = np.zeros(2 * len(free))
    return Problem(
        potential=_bars(joints, bars, 1e4, free),
        u0=zero,
        v0=zero,
        damping=Rayleigh(0.02, 0.0005),
        load=lambda t: jnp.asarray(flat),
        tangent=2 * (TRUSS[1] + 2) + 1,
        title="cantilever truss",
    )
