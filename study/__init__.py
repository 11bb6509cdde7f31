"""Time integration schemes on non-linear dynamic equations, M ü + C u̇ + p(u) = f(t).

``run`` marches a scheme on a problem and returns what was observed, as an :class:`xarray.Dataset`::

    import study

    ds = study.run("softening", "rk4", dt=0.057, steps=2000, observe=["trajectory", "energy_error"])
    ds.u.plot()
    print(ds.status)

Arrays for ``dt``, ``u0``, ``v0`` or ``steps`` run an ensemble, and ``over`` one over anything that a problem is made
of. ``evolve`` is a run as a pure function, which JAX differentiates. A run that fails warns with ``RunFailed``.
``help(study.run)`` describes all arguments, and each of the names below has such a help of its own.

What can be run
    ``problems``, ``schemes`` and ``observers`` hold everything that has a name: ``list(study.schemes)``,
    ``study.schemes["houbolt"]``.

Which scheme and which step
    ``assess`` finds them for any problem, by runs against a certified reference, ``recommend`` lists the schemes that
    keep an error, the cheapest first, and ``report`` writes a page::

        ds = study.assess(pendulum, duration=60.0, quantities={"angle": study.Quantity(lambda u: u, reduce="peak")})
        study.recommend(ds, error=0.01, quantity="angle")
        study.report(ds, "pendulum.html")

What the study knows
    ``open`` opens a dataset of the study; ``recommend`` takes the name of its problems too.

Analysis
    ``LinearTheory`` derives spectral radius, period elongation, damping and order of a scheme from its code.
    ``outcomes`` classifies how the runs of an ensemble ended, as places in ``OUTCOMES``, if ``Fate`` was observed.

A problem of your own
    ``Problem``, with ``Rayleigh`` damping, ``StrainEnergy`` for structures and ``GroundMotion`` for those on moving
    ground::

        pendulum = study.Problem(force=jnp.sin, potential=lambda u: 1 - jnp.cos(u), u0=3.0)

    The force may take the velocity, ``force(u, v)``, or a history too. ``materials`` has those that yield, slip, damp
    or touch.

An observer of your own
    ``Quantity`` observes a function of t, u, u̇ and ü, along time or as its peak, its final value or its root mean
    square. ``Reduction`` and ``Record`` are the base classes of every ``Observer``: one value a run, or values along
    time.

A scheme with other parameters
    ``Newmark``, ``WilsonTheta``, ``Houbolt``, ``HHTAlpha``, ``GeneralizedAlpha``, ``ExplicitAlpha``, ``KolayRicles``,
    ``Bathe``, ``NohBathe``, ``TchamwaWielgosz``, ``BackwardDifferences``, ``RungeKutta4``, ``Nystrom4``, ``Gauss4``,
    ``Splitting``, ``Composition``, ``Extrapolation``, ``EnergyMomentum``, ``AverageVectorField``,
    ``ImplicitMidpoint``, ``Compensated``.

A scheme of your own
    ``Scheme``, or ``OneStep`` for one-step schemes, is the base class. A state is a ``Phase`` (u, u̇), a ``Motion``
    (u, u̇, ü) or your own named tuple with ``u`` and ``v``. ``acceleration`` solves the equation of motion for ü,
    ``balance`` the one of an implicit step, by Newton's iteration; ``load`` is f(t). The ``Effort`` of a step counts
    Newton's iterations. ``assess_scheme`` puts one beside those of
    the study, and ``register`` gives it a name, under which experiments take it too.

Importing ``study`` switches JAX to double precision, among other settings; see ``help(study.settings)``.
"""

import gc as _gc

# Each name is imported as itself, which marks it as public for type checkers. There is no ``__all__``: help(study)
# prints every method of every class that it lists, four thousand lines.
from study import settings as settings  # isort: skip  (first, because JAX reads its settings once)

# a collection of garbage during these imports would visit every object of JAX, and take a third of their time
_collects = _gc.isenabled()
_gc.disable()
try:
    from study import datasets as datasets
    from study.analysis.linear_theory import LinearTheory as LinearTheory
    from study.analysis.outcomes import OUTCOMES as OUTCOMES
    from study.analysis.outcomes import outcomes as outcomes
    from study.analysis.recommendation import recommend as recommend
    from study.assessment.assess import assess as assess
    from study.assessment.report import report as report
    from study.assessment.scheme import assess_scheme as assess_scheme
    from study.datasets import open as open
    from study.equilibrium.balance import acceleration as acceleration
    from study.equilibrium.balance import balance as balance
    from study.equilibrium.balance import load as load
    from study.equilibrium.state import Effort as Effort
    from study.equilibrium.state import Motion as Motion
    from study.equilibrium.state import Phase as Phase
    from study.marching.failure import RunFailed as RunFailed
    from study.marching.pure import evolve as evolve
    from study.marching.run import run as run
    from study.observer.base import Observer as Observer
    from study.observer.base import Record as Record
    from study.observer.base import Reduction as Reduction
    from study.observer.fate import Fate as Fate
    from study.observer.motion import Quantity as Quantity
    from study.observer.named import observers as observers
    from study.problem import materials as materials
    from study.problem.damping import Rayleigh as Rayleigh
    from study.problem.definition import Problem as Problem
    from study.problem.ground import GroundMotion as GroundMotion
    from study.problem.named import problems as problems
    from study.problem.potential import StrainEnergy as StrainEnergy
    from study.scheme.alpha import GeneralizedAlpha as GeneralizedAlpha
    from study.scheme.alpha import HHTAlpha as HHTAlpha
    from study.scheme.backward_differences import BackwardDifferences as BackwardDifferences
    from study.scheme.base import OneStep as OneStep
    from study.scheme.base import Scheme as Scheme
    from study.scheme.bathe import Bathe as Bathe
    from study.scheme.compensated import Compensated as Compensated
    from study.scheme.conserving import AverageVectorField as AverageVectorField
    from study.scheme.conserving import EnergyMomentum as EnergyMomentum
    from study.scheme.conserving import ImplicitMidpoint as ImplicitMidpoint
    from study.scheme.explicit_alpha import ExplicitAlpha as ExplicitAlpha
    from study.scheme.extrapolation import Extrapolation as Extrapolation
    from study.scheme.houbolt import Houbolt as Houbolt
    from study.scheme.kolay_ricles import KolayRicles as KolayRicles
    from study.scheme.named import register as register
    from study.scheme.named import schemes as schemes
    from study.scheme.newmark import Newmark as Newmark
    from study.scheme.noh_bathe import NohBathe as NohBathe
    from study.scheme.runge_kutta import Gauss4 as Gauss4
    from study.scheme.runge_kutta import Nystrom4 as Nystrom4
    from study.scheme.runge_kutta import RungeKutta4 as RungeKutta4
    from study.scheme.splitting import Composition as Composition
    from study.scheme.splitting import Splitting as Splitting
    from study.scheme.tchamwa_wielgosz import TchamwaWielgosz as TchamwaWielgosz
    from study.scheme.wilson import WilsonTheta as WilsonTheta
finally:
    if _collects:
        _gc.enable()

__version__ = datasets.VERSION
