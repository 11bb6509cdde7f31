"""Legitimate alternatives and common mistakes of codes: words and numbers that change a scheme."""

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from conformance.schemes import SOME

#: Families of schemes that carry no acceleration from step to step.
WITHOUT_ACCELERATION = ("rk4", "midpoint", "symplectic_euler")

ALPHA = ("hht", "hht_1996", "generalized_alpha")
_EXPLICIT = ("central_difference", "kr_alpha", "noh_bathe", "tchamwa_wielgosz")
CARRIED = ("newmark", *ALPHA, "wilson", "houbolt", "bathe", *_EXPLICIT)
ALL = (*CARRIED, *WITHOUT_ACCELERATION)
ITERATED = ("newmark", *ALPHA, "wilson", "houbolt", "bathe", "midpoint")


class Variant(NamedTuple):
    """A change of a scheme.

    Attributes
    ----------
    verdict
        ``differs`` for an alternative, ``fail`` for a mistake.
    text
        Description, for the report, of a code that gives the values of this variant.
    families
        Families of schemes to which the variant applies.
    words
        Words with which ``schemes.run`` makes the change.
    change
        Function of the parameters of the scheme that returns the changed parameters.
    """

    verdict: str
    text: str
    families: tuple[str, ...]
    words: tuple[str, ...] = ()
    change: Callable[[Mapping[str, str]], Mapping[str, str]] = lambda scheme: {}


def _alternative(text, families, *words, change=lambda scheme: {}):
    return Variant("differs", text, families, words, change)


def _mistake(text, families, *words, change=lambda scheme: {}):
    return Variant("fail", text, families, words, change)


def _with(**numbers: str) -> Callable[[Mapping[str, str]], Mapping[str, str]]:
    """Function of a scheme's parameters that returns the values given here, without those that it does not have."""
    return lambda scheme: {name: value for name, value in numbers.items() if name in scheme}


def _complement(value: str) -> str:
    return str(1 - Fraction(value)) if "/" in value else f"{1 - float(value):.17g}"


#: Variants, alternatives first. If two variants have the same values in a case, the first one is named.
VARIANTS = (
    _alternative("two internal forces are weighted", ("hht", "generalized_alpha", "kr_alpha"), "two forces"),
    _alternative("the loads of both ends of the step are weighted", (*ALPHA, "kr_alpha"), "mean of loads"),
    _alternative(
        "two internal forces and the loads of both ends are weighted",
        ("hht", "generalized_alpha", "kr_alpha"),
        "two forces",
        "mean of loads",
    ),
    _alternative(
        "the method of 1996: two weighted forces, damping and load of the end of the step",
        ("hht",),
        "two forces",
        "damping at end",
        "load at end",
    ),
    _alternative("the history is committed where the balance is", (*ALPHA, "wilson", "midpoint"), "commit at balance"),
    _alternative("the load is extrapolated from both ends of the step", ("wilson",), "mean of loads"),
    _alternative(
        "the load in between is interpolated from both ends of the step", ("bathe", "midpoint"), "mean of loads"
    ),
    _alternative(
        "the first two steps are those of average acceleration",
        ("houbolt",),
        change=_with(start="two steps of average acceleration"),
    ),
    _alternative(
        "the first two steps are those of central difference",
        ("houbolt",),
        change=_with(start="two steps of central difference"),
    ),
    _alternative(
        "the points before the start are those of Taylor's formula", ("houbolt",), change=_with(start="taylor")
    ),
    _alternative("each of the two sub-steps counts as a step", ("bathe",), "sub-steps"),
    _alternative("the damping acts on the velocity of the half step", ("central_difference",), "damping at half"),
    _alternative("the velocity is that of the half step before", ("central_difference",), "velocity at half"),
    _alternative("the displacement moves before the velocity", ("symplectic_euler",), "drift first"),
    _mistake("the acceleration at the start is zero", CARRIED, "a0 = 0"),
    _mistake("the acceleration at the start leaves out the damping", CARRIED, "a0 without damping"),
    _mistake("the acceleration at the start leaves out the load", CARRIED, "a0 without load"),
    _mistake("the velocity at the start is ignored", ALL, "no v0"),
    _mistake(
        "the velocity at the start is taken for that of half a step before", ("central_difference",), "start at half"
    ),
    _mistake("the load is that of the start of the step", ALL, "load at start"),
    _mistake(
        "the load is that of the end of the step",
        (*ALPHA, "wilson", "midpoint", "kr_alpha", "rk4", "symplectic_euler"),
        "load at end",
    ),
    _mistake("the load is that of the middle of the step", CARRIED, "load at half"),
    _mistake("the load is taken one step too late", ALL, "load early"),
    _mistake("the load is missing", ALL, "no load"),
    _mistake("the load has the opposite sign", ALL, "sign of load"),
    _mistake("the damping is missing", ALL, "no damping"),
    _mistake("the damping acts on the velocity at the start of the step", ALL, "damping at start"),
    _mistake("the damping acts on the velocity at the end of the step", ("hht", "generalized_alpha"), "damping at end"),
    _mistake("Newton's iteration stops after one iteration from the last displacement", ITERATED, "one iteration"),
    _mistake(
        "Newton's iteration stops after one iteration from a predicted displacement", ITERATED, "one iteration from a"
    ),
    _mistake("the acceleration is derived from the equation of motion after every step", ALPHA, "rederived"),
    _mistake("the displacement after yield is not remembered", ALL, "no commit"),
    _mistake("the displacement after yield is committed in every iteration", ITERATED, "commit in iterations"),
    _mistake("the velocity leaves out the new acceleration", ("newmark", *ALPHA), "no new a in v"),
    _mistake("it is average acceleration: β = 1/4 and γ = 1/2", ("newmark",), change=_with(beta="0.25", gamma="0.5")),
    _mistake(
        "it is linear acceleration: β = 1/6 and γ = 1/2",
        ("newmark",),
        change=lambda scheme: {"beta": f"{1 / 6:.17g}", "gamma": "0.5"},
    ),
    _mistake(
        "β and γ are exchanged",
        ("newmark", *ALPHA),
        change=lambda scheme: {"beta": scheme["gamma"], "gamma": scheme["beta"]},
    ),
    _mistake("γ is 1/2: the numerical damping is missing", ("newmark", *ALPHA), change=_with(gamma="0.5")),
    _mistake("β is 1/4", ALPHA, change=_with(beta="0.25")),
    _mistake("β is 1/4 and γ is 1/2", ALPHA, change=_with(beta="0.25", gamma="0.5")),
    _mistake("it is Newmark's method: α is missing", ("hht", "hht_1996"), change=_with(alpha="0")),
    _mistake(
        "α has the opposite sign", ("hht", "hht_1996"), change=lambda scheme: {"alpha": scheme["alpha"].lstrip("-")}
    ),
    _mistake(
        "α_m and α_f are exchanged",
        ("generalized_alpha",),
        change=lambda scheme: {"alpha_m": scheme["alpha_f"], "alpha_f": scheme["alpha_m"]},
    ),
    _mistake(
        "α_m and α_f weight the end of the step instead of its start",
        ("generalized_alpha",),
        change=lambda scheme: {name: _complement(scheme[name]) for name in ("alpha_m", "alpha_f")},
    ),
    _mistake("α_m is missing in the balance", ("generalized_alpha",), change=_with(alpha_m="0")),
    _mistake("α_f is missing in the balance", ("generalized_alpha",), change=_with(alpha_f="0")),
    _mistake(
        "α_m is missing in the balance, and β and γ are exchanged",
        ("generalized_alpha",),
        change=lambda scheme: {"alpha_m": "0", "beta": scheme["gamma"], "gamma": scheme["beta"]},
    ),
    _mistake("θ is 1: it is linear acceleration", ("wilson",), change=_with(theta="1")),
    _mistake("the acceleration is not interpolated back to the end of the step", ("wilson",), "no interpolation"),
    _mistake("the load of the first sub-step is that of the end of the step", ("bathe",), "first load at end"),
    _mistake("both sub-steps are those of the trapezoidal rule", ("bathe",), change=_with(gamma="0.5", rho_inf="1")),
    _mistake("the displacement leaves out γ in its coefficient ½ + γ", ("kr_alpha",), "no gamma in u"),
    _mistake("the four stages have equal weights", ("rk4",), "equal weights"),
)


def _uncoupled(problem: Mapping[str, Any]) -> dict[str, Any]:
    mass = [[entry if i == j else "0" for j, entry in enumerate(row)] for i, row in enumerate(problem["mass"])]
    return {**problem, "mass": mass}


def _loaded(change: Callable[[float, float], tuple[float, float]]) -> Callable[[Mapping[str, Any]], dict[str, Any]]:
    """Function that returns a problem with another frequency and phase of its load, computed by ``change``."""

    def changed(problem: Mapping[str, Any]) -> dict[str, Any]:
        if "load" not in problem:
            return {**problem}
        names = ("frequency", "phase")
        values = change(*(float(problem["load"][name]) for name in names))
        return {**problem, "load": {**problem["load"], **dict(zip(names, map(repr, values), strict=True))}}

    return changed


def _cubic_alone(problem: Mapping[str, Any]) -> dict[str, Any]:
    parameters = problem["parameters"]
    if problem["form"] != "cubic":
        return {**problem}
    return {**problem, "parameters": {**parameters, "S2": repr(float(parameters["S2"]) / float(parameters["S1"]))}}


def _without_cubic(problem: Mapping[str, Any]) -> dict[str, Any]:
    if problem["form"] != "cubic":
        return {**problem}
    return {**problem, "parameters": {**problem["parameters"], "S2": "0"}}


class Later(NamedTuple):
    """A mistake that was found after the cases were made, so that the cases hold no values of it.

    Attributes
    ----------
    text, words, families
        As those of a ``Variant``.
    problem
        Function that changes the problem.
    """

    text: str
    words: tuple[str, ...] = ()
    problem: Callable[[Mapping[str, Any]], Mapping[str, Any]] = dict
    families: tuple[str, ...] = ALL


LATER = (
    Later("the internal force is that of the end of the step", ("force at end",)),
    Later("the masses that couple unknowns are missing", problem=_uncoupled),
    Later("the phase of the load is missing", problem=_loaded(lambda w, phase: (w, 0.0))),
    Later("the phase of the load has the opposite sign", problem=_loaded(lambda w, phase: (w, -phase))),
    Later("the load is a sine instead of a cosine", problem=_loaded(lambda w, phase: (w, phase + math.pi / 2))),
    Later("the frequency of the load is taken in cycles", problem=_loaded(lambda w, phase: (2 * math.pi * w, phase))),
    Later("the cubic term of the force leaves out S1", problem=_cubic_alone),
    Later("the cubic term of the force is missing", problem=_without_cubic),
    Later("the velocity is (3 u₁ − 4 u₀ + u₋₁) / (2 Δt)", ("three displacements",), families=("central_difference",)),
    Later(
        "the displacement before the start is taken for that of the start",
        ("three displacements", "start forgotten"),
        families=("central_difference",),
    ),
    Later(
        "the damping acts on the velocity v₀ + Δt a₀, and the displacement takes the load of the end of the step",
        ("predicted damping",),
        families=("central_difference",),
    ),
    Later(
        "the load is taken one step too late, and the velocity, also that of the damping, is one step late",
        ("late leapfrog",),
        families=("central_difference",),
    ),
    Later(
        "the acceleration at the start is twice the one that two half steps of backward Euler give",
        ("start by backward Euler",),
        families=("newmark", "hht", "generalized_alpha"),
    ),
    Later(
        "the first step leaves out the forces of the start, v₀ in the acceleration and a₀ in the velocity",
        ("start forgotten", "two forces", "mean of loads"),
        families=("hht", "generalized_alpha"),
    ),
    *(
        Later(f"Newton's iteration stops after {number} iterations", (f"{SOME}{number}",), families=ITERATED)
        for number in (2, 3)
    ),
)

#: Variants of schemes with unequal steps. A case with unequal steps holds the values of these variants only.
UNEQUAL = (
    _alternative(
        "the carried acceleration is moved to the new step", ("hht", "generalized_alpha"), "corrected for step"
    ),
    _alternative(
        "the carried acceleration is scaled to the new step about that of the equation of motion",
        ("hht", "generalized_alpha"),
        "scaled for step",
    ),
    _mistake("the acceleration is derived from the equation of motion after every step", ALPHA, "rederived"),
    _mistake("each step has the size of the one before", ALL, "late sizes"),
)
