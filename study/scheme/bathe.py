"""Bathe's composite methods: a sub-step by the trapezoidal rule, then a sub-step by a formula through three points."""

import abc
import math
from typing import ClassVar

import equinox as eqx

from study.keywords import keywords_only
from study.mechanics.balance import at, balance
from study.mechanics.state import Motion
from study.scheme.base import OneStep, check_range, check_ranges
from study.scheme.newmark import ROUND_OFF


class Composite(OneStep):
    """A sub-step to t₀ + γΔt by the trapezoidal rule, then a sub-step to t₁ with weights for all three points."""

    family: ClassVar[str] = "Multi-step and composite"
    explicit = False
    acceleration_offset = 0.0
    force_at_end = True

    @property
    @abc.abstractmethod
    def weights(self) -> tuple[float, float, float, float]:
        """γ, and the weights q₀, q₁ and q₂, whose sum is one."""

    def increment(self, problem, state, t, dt):
        u, v, a = state
        gamma, q0, q1, q2 = self.weights
        h, c = gamma * dt / 2, q2 * dt
        # the trapezoidal rule to t₀ + γΔt
        v_half, u_half = v + h * a, u + 2 * h * v + h**2 * a
        a_gamma, first = balance(*at(problem, t + 2 * h), u_half, v_half, h**2, h, guess=a)
        v_gamma = v_half + h * a_gamma
        problem = problem.at_time(t + 2 * h).committed(u_half + h**2 * a_gamma, v_gamma)
        dv = dt * (q0 * a + q1 * a_gamma)
        du = dt * (q0 * v + q1 * v_gamma) + c * (v + dv)
        a, second = balance(*at(problem, t + dt), u + du, v + dv, c**2, c, guess=a_gamma)
        return Motion(du + c**2 * a, dv + c * a, a), first.then(second, problem.history)


class Bathe(Composite):
    r"""The ρ∞-Bathe method: the trapezoidal rule to t₀ + γΔt, then a sub-step to t₁ with weights for all three points.

    .. math::

        y_\gamma &= y_0 + \tfrac12 \gamma\Delta t\,(\dot y_0 + \dot y_\gamma) \quad\text{for } y = u, \dot u \\
        y_1 &= y_0 + \Delta t\,(q_0 \dot y_0 + q_1 \dot y_\gamma + q_2 \dot y_1) \quad\text{for } y = u, \dot u \\
        q_1 &= \frac{1 + \rho_\infty}{2\gamma(\rho_\infty - 1) + 4}, \quad q_0 = (\gamma - 1)\,q_1 + \tfrac12,
            \quad q_2 = \tfrac12 - \gamma q_1 \\
        M \ddot u + C \dot u + p(u) &= f \quad\text{at } t_0 + \gamma\Delta t \text{ and at } t_1

    Second order, unconditionally stable for linear systems, with the spectral radius ρ∞ at infinite frequency. ρ∞ = 0
    is Bathe's method with γ = ½ and TR-BDF2 with γ = 2 − √2. With
    :math:`\gamma = (2 - \sqrt{2 + 2\rho_\infty})/(1 - \rho_\infty)`, as in TR-BDF2, both sub-steps have the same
    effective stiffness. ρ∞ = 1 with γ = ½ is the trapezoidal rule twice. Carries u, u̇ and ü; solves two balances per
    step, each with one force per Newton iteration. The history of a force is committed at t₀ + γΔt and at t₁.

    Parameters
    ----------
    gamma
        0.01 ≤ γ ≤ 0.99.
    rho_inf
        0 ≤ ρ∞ ≤ 1.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    K. J. Bathe, M. M. I. Baig, On a composite implicit time integration procedure for nonlinear dynamics, Comput.
    Struct. 83(31-32), 2005, 2513-2524.
    G. Noh, K. J. Bathe, The Bathe time integration method with controllable spectral radius: the ρ∞-Bathe method,
    Comput. Struct. 212, 2019, 299-310.
    R. E. Bank, W. M. Coughran, W. Fichtner, E. H. Grosse, D. J. Rose, R. K. Smith, Transient simulation of silicon
    devices and circuits, IEEE Trans. Electron Devices 32(10), 1985, 1992-2007.
    """

    gamma: float = 0.5
    rho_inf: float = 0.0
    title: str = eqx.field(default="Bathe", static=True)
    source: str = eqx.field(default="Bathe and Baig (2005)", static=True)
    doi: str = eqx.field(default="10.1016/j.compstruc.2005.08.001", static=True)

    order = 2
    stability_limit = math.inf

    def __check_init__(self):
        check_ranges(self, gamma=(0.01, 0.99), rho_inf=(0.0, 1.0))

    @classmethod
    @keywords_only
    def with_one_stiffness(cls, *, rho_inf: float, **labels: str) -> "Bathe":
        """The method whose γ gives both sub-steps the same effective stiffness, 0 ≤ ρ∞ < 1."""
        check_range("Bathe.with_one_stiffness", "rho_inf", rho_inf, 0.0, math.nextafter(1.0, 0.0))
        return cls(gamma=(2 - math.sqrt(2 + 2 * rho_inf)) / (1 - rho_inf), rho_inf=rho_inf, **labels)

    @property
    def weights(self) -> tuple[float, float, float, float]:
        q1 = (1 + self.rho_inf) / (2 * self.gamma * (self.rho_inf - 1) + 4)
        return self.gamma, (self.gamma - 1) * q1 + 0.5, q1, 0.5 - self.gamma * q1


class BetaBathe(Composite):
    r"""The β₁/β₂-Bathe method: the trapezoidal rule to t₀ + γΔt, then a sub-step to t₁ with two weighted means.

    .. math::

        y_\gamma &= y_0 + \tfrac12 \gamma\Delta t\,(\dot y_0 + \dot y_\gamma) \quad\text{for } y = u, \dot u \\
        y_1 &= y_0 + \gamma\Delta t\,[(1 - \beta_1)\,\dot y_0 + \beta_1 \dot y_\gamma]
            \\ &\quad + (1 - \gamma)\Delta t\,[(1 - \beta_2)\,\dot y_\gamma + \beta_2 \dot y_1]
            \quad\text{for } y = u, \dot u \\
        M \ddot u + C \dot u + p(u) &= f \quad\text{at } t_0 + \gamma\Delta t \text{ and at } t_1

    With γ = ½ it is unconditionally stable for linear systems if β₁ + β₂ ≥ 1 and β₁ ≤ β₂. It is then of second order if
    β₁ + β₂ = 1, and of first order otherwise. With β₁ + β₂ = 1 and ⅓ ≤ β₁ ≤ ½ it is the ρ∞-Bathe method with
    :math:`\rho_\infty = (3\beta_1 - 1)/(1 - \beta_1)`. β₂ = 2β₁ makes ρ∞ zero. Carries u, u̇ and ü; solves two balances
    per step, each with one force per Newton iteration. The history of a force is committed at t₀ + γΔt and at t₁.

    Parameters
    ----------
    beta1, beta2
        0 ≤ β₁ ≤ 1, 0.01 ≤ β₂ ≤ 1.
    gamma
        0.01 ≤ γ ≤ 0.99.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    M. M. Malakiyeh, S. Shojaee, K. J. Bathe, The Bathe time integration method revisited for prescribing desired
    numerical dissipation, Comput. Struct. 212, 2019, 289-298.
    """

    beta1: float
    beta2: float
    gamma: float = 0.5
    title: str = eqx.field(default="β₁/β₂-Bathe", static=True)

    source: ClassVar[str] = "Malakiyeh et al. (2019)"
    doi: ClassVar[str] = "10.1016/j.compstruc.2018.10.008"

    def __check_init__(self):
        check_ranges(self, beta1=(0.0, 1.0), beta2=(0.01, 1.0), gamma=(0.01, 0.99))

    @property
    def weights(self) -> tuple[float, float, float, float]:
        first, second = self.gamma, 1 - self.gamma
        return first, first * (1 - self.beta1), first * self.beta1 + second * (1 - self.beta2), second * self.beta2

    @property
    def _excess(self) -> float:
        """γq₁ + q₂ − ½, zero if the method is of second order."""
        gamma, _, q1, q2 = self.weights
        return gamma * q1 + q2 - 0.5

    @property
    def order(self) -> int:
        return 2 if abs(self._excess) < ROUND_OFF else 1

    @property
    def stability_limit(self) -> float | None:
        # |λ| ≤ 1 at every ωΔt without damping: in |λ|², no coefficient of (ωΔt)² or (ωΔt)⁴ is larger above than below
        _, q0, q1, q2 = self.weights
        bounded = q2 >= abs(q1 - q0) - ROUND_OFF
        if self._excess < -ROUND_OFF or (self._excess < ROUND_OFF and not bounded):
            return 0.0
        return math.inf if bounded else None

    @property
    def needs_mass(self) -> bool:
        # at infinite frequency y₁ = (q₁ − q₀)/q₂ y₀
        _, q0, q1, q2 = self.weights
        return abs(q1 - q0) > q2 + ROUND_OFF


_noh = {"source": "Noh and Bathe (2019)", "doi": "10.1016/j.compstruc.2018.11.001"}
_bank = {"source": "Bank et al. (1985)", "doi": "10.1109/T-ED.1985.22232"}
bathe = Bathe()
rho_bathe = Bathe.with_one_stiffness(rho_inf=0.5, title="ρ∞-Bathe", **_noh)
tr_bdf2 = Bathe.with_one_stiffness(rho_inf=0.0, title="TR-BDF2", **_bank)
#: Parameters with β₂ = 2β₁, as the authors of the method advise for waves; the value of β₁ is chosen here.
beta_bathe = BetaBathe(beta1=0.39, beta2=0.78)
