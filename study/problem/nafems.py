"""Two benchmarks of NAFEMS for transient vibration, in the modes of a simply supported beam and plate."""

import numpy as np

from study.mechanics.definition import Problem
from study.mechanics.terms import Rayleigh
from study.problem.naming import Known, named

YOUNG, POISSON, DENSITY, LENGTH = 200e9, 0.3, 8000.0, 10.0

#: Numbers of half waves, up to seven, of the modes that a uniform load excites.
ODD = np.arange(1.0, 8.0, 2.0)

#: Value at x = L/2 of each mode sin(nπx/L) with n in ODD, and coefficient of this mode in a uniform load of size 1.
_MIDDLE, _SHARE = np.sin(ODD * np.pi / 2), 4 / (ODD * np.pi)


def _suddenly_loaded(title: str, stiffness: np.ndarray, mass: np.ndarray, load: np.ndarray, a: float, b: float):
    """A linear structure at rest under a load that appears at t = 0, with the damping a M + b K."""
    return Problem(
        u0=np.zeros(len(load)),
        stiffness=stiffness,
        mass=mass,
        load=lambda t: load,
        damping=Rayleigh(a=a, b=b),
        title=title,
    )


@named(
    time_scale=1 / 42.649,  # period of the first mode
    known=Known(0.0117, "NAFEMS 5T", np.array([1.043e-3]), np.append(_MIDDLE, 0 * _MIDDLE)[None]),
)
def deep_beam() -> Problem:
    r"""A deep beam under a step load: test 5T of NAFEMS, in N, m and s.

    .. math::

        \rho A \ddot w - \kappa G A (w' - \varphi)' = q, \quad
        \rho I \ddot\varphi - E I \varphi'' - \kappa G A (w' - \varphi) = 0

    Timoshenko's beam is simply supported, 10 m long and 2 m by 2 m across, E = 200 GPa, ν = 0.3, ρ = 8000 kg/m³,
    κ = 0.85, with the Rayleigh damping of 5.36 M + 7.46e-5 K and the load q = 10⁶ N/m. The unknowns are the amplitudes
    of sin(nπx/L) in w and then of cos(nπx/L) in φ, for n = 1, 3, 5, 7. The printed peak of the deflection in the
    middle is 1.043 mm at 0.0117 s.

    References
    ----------
    J. Maguire, D. J. Dawswell, L. Gould, Selected benchmarks for forced vibration, Report R0016, NAFEMS, 1989.
    """
    side, wave = 2.0, ODD * np.pi / LENGTH
    area, inertia = side**2, side**4 / 12
    shear, bending = 0.85 * YOUNG / (2 * (1 + POISSON)) * area, YOUNG * inertia
    coupling = np.diag(-shear * wave)
    stiffness = np.block(
        [[np.diag(shear * wave**2), coupling], [coupling, np.diag(bending * wave**2 + shear)]],
    )
    mass = DENSITY * np.repeat([area, inertia], len(ODD))
    return _suddenly_loaded("deep beam", stiffness, mass, np.append(1e6 * _SHARE, 0 * _SHARE), 5.36, 7.46e-5)


@named(
    time_scale=1 / 2.377,  # period of the first mode
    known=Known(0.210, "NAFEMS 13T", np.array([3.523e-3]), np.outer(_MIDDLE, _MIDDLE).reshape(1, -1)),
)
def thin_plate() -> Problem:
    r"""A thin plate under a step load: test 13T of NAFEMS, in N, m and s.

    .. math::

        \rho h \ddot w + \frac{E h^3}{12 (1 - \nu^2)} \Delta \Delta w = q

    The square plate is simply supported, 10 m wide and h = 0.05 m thick, E = 200 GPa, ν = 0.3, ρ = 8000 kg/m³, with the
    Rayleigh damping of 0.299 M + 1.339e-3 K and the load q = 100 N/m². The unknowns are the amplitudes of
    sin(mπx/L) sin(nπy/L) for m, n = 1, 3, 5, 7. The printed peak of the deflection in the middle, 3.523 mm at
    0.210 s, is that of the first mode alone. All modes give 1.8 % less.

    References
    ----------
    J. Maguire, D. J. Dawswell, L. Gould, Selected benchmarks for forced vibration, Report R0016, NAFEMS, 1989.
    """
    thickness, squares = 0.05, np.add.outer(ODD**2, ODD**2).ravel() * (np.pi / LENGTH) ** 2
    stiffness = YOUNG * thickness**3 / (12 * (1 - POISSON**2)) * squares**2
    mass = np.full(len(squares), DENSITY * thickness)
    return _suddenly_loaded("thin plate", stiffness, mass, 100 * np.outer(_SHARE, _SHARE).ravel(), 0.299, 1.339e-3)
