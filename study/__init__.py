"""How time integration schemes behave on non-linear dynamic equations."""

from study import xla  # noqa: F401  (first: JAX reads its settings once)
from study.datasets import open
from study.observers import observers
from study.problem import Problem
from study.problems import problems
from study.recommendation import recommend
from study.runs import run
from study.schemes import Compensated, HHTAlpha, Houbolt, Newmark, OneStep, RungeKutta4, Scheme, WilsonTheta, schemes

__all__ = [
    "Compensated",
    "HHTAlpha",
    "Houbolt",
    "Newmark",
    "OneStep",
    "Problem",
    "RungeKutta4",
    "Scheme",
    "WilsonTheta",
    "observers",
    "open",
    "problems",
    "recommend",
    "run",
    "schemes",
]
