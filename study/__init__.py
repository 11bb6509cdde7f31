"""How time integration schemes behave on non-linear dynamic equations."""

from study import settings as xla  # noqa: F401  (first: JAX reads its settings once)
from study.analysis.recommendation import recommend
from study.datasets import open
from study.marching.run import run
from study.observer.motion import Quantity
from study.observer.named import observers
from study.problem.damping import Rayleigh
from study.problem.definition import Problem
from study.problem.named import problems
from study.problem.potential import StrainEnergy
from study.scheme.alpha import GeneralizedAlpha, HHTAlpha
from study.scheme.backward_differences import BackwardDifferences
from study.scheme.base import OneStep, Scheme
from study.scheme.bathe import Bathe
from study.scheme.compensated import Compensated
from study.scheme.conserving import AverageVectorField, EnergyMomentum, ImplicitMidpoint
from study.scheme.explicit_alpha import ExplicitAlpha
from study.scheme.extrapolation import Extrapolation
from study.scheme.houbolt import Houbolt
from study.scheme.kolay_ricles import KolayRicles
from study.scheme.named import schemes
from study.scheme.newmark import Newmark
from study.scheme.noh_bathe import NohBathe
from study.scheme.runge_kutta import Gauss4, Nystrom4, RungeKutta4
from study.scheme.splitting import Composition, Splitting
from study.scheme.tchamwa_wielgosz import TchamwaWielgosz
from study.scheme.wilson import WilsonTheta

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
    "Newmark",
    "NohBathe",
    "Nystrom4",
    "OneStep",
    "Problem",
    "Quantity",
    "Rayleigh",
    "RungeKutta4",
    "Scheme",
    "Splitting",
    "StrainEnergy",
    "TchamwaWielgosz",
    "WilsonTheta",
    "observers",
    "open",
    "problems",
    "recommend",
    "run",
    "schemes",
]
