"""Every scheme of the study: a file per family, and their names here."""

from study.registry import Registry
from study.schemes.alpha import (
    GeneralizedAlpha,
    HHTAlpha,
    generalized_alpha,
    hht_alpha,
    hht_alpha_one_force,
    wbz_alpha,
)
from study.schemes.backward_differences import BackwardDifferences, bdf2, park
from study.schemes.bathe import Bathe, bathe, rho_bathe, tr_bdf2
from study.schemes.compensated import Compensated
from study.schemes.conserving import (
    AverageVectorField,
    EnergyMomentum,
    ImplicitMidpoint,
    average_vector_field,
    energy_momentum,
    implicit_midpoint,
)
from study.schemes.explicit_alpha import ExplicitAlpha, chung_lee, hulbert_chung
from study.schemes.extrapolation import Extrapolation, extrapolation12
from study.schemes.houbolt import Houbolt, houbolt
from study.schemes.kolay_ricles import KolayRicles, kr_alpha
from study.schemes.linearised import Linearised
from study.schemes.newmark import (
    Newmark,
    average_acceleration,
    central_difference,
    fox_goodwin,
    linear_acceleration,
    newmark_dissipative,
)
from study.schemes.noh_bathe import NohBathe, noh_bathe
from study.schemes.runge_kutta import Gauss4, Nystrom4, RungeKutta4, gauss4, nystrom4, rk4
from study.schemes.scheme import OneStep, Scheme
from study.schemes.splitting import (
    Composition,
    Splitting,
    kahan_li8,
    mclachlan4,
    symplectic_euler,
    yoshida4,
    yoshida6,
)
from study.schemes.tchamwa_wielgosz import TchamwaWielgosz, tchamwa_wielgosz
from study.schemes.wilson import WilsonTheta, wilson_theta

#: Every scheme that can be called by name: first those of 1996 in the order of the paper's tables.
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
        "linear_acceleration": linear_acceleration,
        "fox_goodwin": fox_goodwin,
        "hht_alpha_one_force": hht_alpha_one_force,
        "wbz_alpha": wbz_alpha,
        "generalized_alpha": generalized_alpha,
        "bdf2": bdf2,
        "park": park,
        "bathe": bathe,
        "rho_bathe": rho_bathe,
        "tr_bdf2": tr_bdf2,
        "chung_lee": chung_lee,
        "hulbert_chung": hulbert_chung,
        "noh_bathe": noh_bathe,
        "tchamwa_wielgosz": tchamwa_wielgosz,
        "kr_alpha": kr_alpha,
        "implicit_midpoint": implicit_midpoint,
        "energy_momentum": energy_momentum,
        "average_vector_field": average_vector_field,
        "symplectic_euler": symplectic_euler,
        "mclachlan4": mclachlan4,
        "yoshida4": yoshida4,
        "yoshida6": yoshida6,
        "kahan_li8": kahan_li8,
        "nystrom4": nystrom4,
        "gauss4": gauss4,
        "extrapolation12": extrapolation12,
    },
    aliases={"velocity_verlet": "central_difference"},
)

__all__ = [
    "AverageVectorField",
    "BackwardDifferences",
    "Bathe",
    "Compensated",
    "Composition",
    "EnergyMomentum",
    "ExplicitAlpha",
    "Extrapolation",
    "Gauss4",
    "GeneralizedAlpha",
    "HHTAlpha",
    "Houbolt",
    "ImplicitMidpoint",
    "KolayRicles",
    "Linearised",
    "Newmark",
    "NohBathe",
    "Nystrom4",
    "OneStep",
    "RungeKutta4",
    "Scheme",
    "Splitting",
    "TchamwaWielgosz",
    "WilsonTheta",
    "schemes",
]
