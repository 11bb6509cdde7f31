"""How time integration schemes behave on non-linear dynamic equations."""

from study import xla  # noqa: F401  (first: JAX reads its settings once)
from study.datasets import open
from study.observers import Quantity, observers
from study.problem import Problem, Rayleigh, StrainEnergy
from study.problems import problems
from study.recommendation import recommend
from study.runs import run
from study.schemes import (
    AverageVectorField,
    BackwardDifferences,
    Bathe,
    Compensated,
    Composition,
    EnergyMomentum,
    ExplicitAlpha,
    Extrapolation,
    Gauss4,
    GeneralizedAlpha,
    HHTAlpha,
    Houbolt,
    ImplicitMidpoint,
    KolayRicles,
    Newmark,
    NohBathe,
    Nystrom4,
    OneStep,
    RungeKutta4,
    Scheme,
    Splitting,
    TchamwaWielgosz,
    WilsonTheta,
    schemes,
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
