"""Every scheme of the study: a file per family, and their names here."""

from study.registry import Registry
from study.schemes.alpha import HHTAlpha, hht_alpha
from study.schemes.compensated import Compensated
from study.schemes.houbolt import Houbolt, houbolt
from study.schemes.newmark import Newmark, average_acceleration, central_difference, newmark_dissipative
from study.schemes.runge_kutta import RungeKutta4, rk4
from study.schemes.scheme import OneStep, Scheme
from study.schemes.wilson import WilsonTheta, wilson_theta

__all__ = [
    "Compensated",
    "HHTAlpha",
    "Houbolt",
    "Newmark",
    "OneStep",
    "RungeKutta4",
    "Scheme",
    "WilsonTheta",
    "schemes",
]

#: Every scheme that can be called by name, in the order of the paper's tables.
schemes: Registry[Scheme] = Registry(
    "scheme",
    {
        "average_acceleration": average_acceleration,
        "central_difference": central_difference,
        "newmark_dissipative": newmark_dissipative,
        "wilson_theta": wilson_theta,
        "houbolt": houbolt,
        "hht_alpha": hht_alpha,
        "rk4": rk4,
    },
)
