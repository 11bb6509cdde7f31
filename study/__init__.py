"""Time integration schemes on non-linear dynamic equations, M ü + C u̇ + p(u) = f(t).

``run`` marches a scheme on a problem and returns the observed quantities as an :class:`xarray.Dataset`::

    import study

    ds = study.run("softening", "rk4", dt=0.057, steps=2000, observe=["trajectory", "energy_error"])
    ds.u.plot()
    print(ds.status)

Arrays for ``dt``, ``u0``, ``v0`` or ``steps`` run an ensemble. ``over`` runs an ensemble of problems: it maps
the arguments of a function that makes a problem to arrays. The argument ``save`` writes an ensemble in parts, which may
exceed the memory; ``Parts`` is their folder and number. ``final_state`` returns the state at the end of a run. It is a
pure function, so that JAX can differentiate it. ``run`` warns with ``RunFailedWarning`` if a run fails.
``help(study.run)`` describes all arguments, and ``help()`` describes each of the names below.

Steps of controlled size
    ``run`` takes a ``tolerance`` and a ``duration`` in place of ``dt`` and ``steps``. ``estimators`` and
    ``controllers`` hold the error estimators and step-size controllers by name. ``Estimator`` and ``Controller`` are
    the base classes for your own. ``DeadBand``, ``Reversible`` and ``Prescribed`` are controllers with parameters, and
    ``UnequalSteps`` adapts an α-method to steps of different sizes::

        ds = study.run("hardening", "hht_alpha", tolerance=1e-4, duration=15.0, estimator="three_point")

What can be run
    ``problems``, ``schemes`` and ``observers`` hold problems, schemes and observers by name: ``list(study.schemes)``,
    ``study.schemes["houbolt"]``.

Which scheme and which step size
    ``assess`` runs schemes on any problem and compares them with a certified reference. ``recommend`` lists the schemes
    that keep an allowed error, the cheapest first, and ``report`` writes a page of HTML::

        ds = study.assess(pendulum, duration=60.0, quantities={"angle": study.Quantity(lambda u: u, reduce="peak")})
        study.recommend(ds, allowed_error=0.01, quantity="angle")
        study.report(ds, "pendulum.html")

    ``step_bound`` computes the steps that keep energy, period and displacement of a free oscillator, without a run.
    ``record_error`` predicts the error of a step under a record of ground motion, without a run.
    ``work_precision`` returns the errors and computing times of runs, and draws them if a file for the figure is given.
    ``cite`` lists, as BibTeX, the works on which a dataset is based.

A model in another program
    ``assess`` also takes a ``Program``: any function that runs a model with a scheme and a step size. ``command`` makes
    a program from an executable, and ``opensees`` makes one from a model of OpenSees::

        program = study.command("./mycode {dt} {scheme} {output}", ["newmark", "hht"], duration=10.0)
        study.recommend(study.assess(program), allowed_error=0.01)

Datasets of the study
    ``open_dataset`` opens a dataset of the study. ``recommend`` also takes the name of an assessment of the study.

Analysis
    ``LinearTheory`` derives spectral radius, period elongation, damping and order of a scheme from its code.
    ``outcomes`` classifies how the runs of an ensemble ended, as values of ``Outcome``, from the events that an
    ``OutcomeObserver`` has found.

A problem of your own
    ``Problem`` describes it. ``Rayleigh`` gives its damping, ``StrainEnergy`` the potential of a structure, and
    ``GroundMotion`` the acceleration of the ground::

        pendulum = study.Problem(force=jnp.sin, potential=lambda u: 1 - jnp.cos(u), u0=3.0)

    The force may also take the velocity, ``force(u, v)``, and a history. ``materials`` has forces of springs that
    yield, slip or touch, and of dampers.

An observer of your own
    ``Quantity`` observes a function of t, u, u̇ and ü, along time or as its peak, its final value or its root mean
    square. An ``Observer`` is a ``Reduction``, which gives one value per run, or a ``Record``, which gives values along
    time.

A scheme with other parameters
    ``Newmark``, ``WilsonTheta``, ``Houbolt``, ``HHTAlpha1996``, ``GeneralizedAlpha``, ``ExplicitAlpha``,
    ``SingleSolve``, ``KolayRicles``, ``ChenRicles``, ``Chang``, ``Bathe``, ``BetaBathe``, ``NohBathe``,
    ``WangAdamsTamma``, ``TchamwaWielgosz``, ``BackwardDifferences``, ``TwoStep``, ``AuxiliaryVariable``,
    ``DiagonallyImplicit``, ``RungeKutta4``, ``Nystrom4``, ``EmbeddedNystrom``, ``Gauss4``, ``Splitting``,
    ``KickDriftKick``, ``Composition``, ``Extrapolation``, ``Trigonometric``, ``MixedPade``,
    ``EnergyMomentum``, ``AverageVectorField``, ``ImplicitMidpoint``, ``Compensated``, ``Relaxed``. All parameters are
    given by name.

A scheme of your own
    ``Scheme``, or ``OneStep`` for one-step schemes, is the base class. ``building`` states what a scheme must return,
    and provides its parts: states, the equation of motion and the balance of an implicit step.
    ``assess_scheme`` compares your scheme with schemes of the study. ``register_scheme`` gives it a name, by which
    experiments can use it too.

Importing ``study`` switches JAX to double precision, among other settings; see ``help(study.settings)``.
"""

import ast
import gc
from importlib import import_module
from pathlib import Path

from study import settings as settings

_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
#: Module of each public name. JAX and xarray take a second to import, so each name is imported when it is first used.
#: The stub file lists the names with their modules; type checkers read it too.
_MODULES = {name.name: node.module for node in _STUB.body if isinstance(node, ast.ImportFrom) for name in node.names}


def __getattr__(name: str):
    if name not in _MODULES:
        raise AttributeError(f"module 'study' has no attribute '{name}'")
    if _MODULES[name] == "study":
        return import_module(f"study.{name}")
    collects = gc.isenabled()
    gc.disable()  # imported objects stay, and searching them for garbage takes a sixth of the time of the imports
    try:
        globals()[name] = value = getattr(import_module(_MODULES[name]), name)
    finally:
        if collects:
            gc.enable()
    return value


def __dir__() -> list[str]:
    return list(_MODULES)
