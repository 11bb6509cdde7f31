"""Problems and schemes of the cases."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from mpmath import mp

with mp.workdps(40):
    _THIRD, _SIXTH, _TWELFTH = (mp.nstr(mp.mpf(1) / n, 30) for n in (3, 6, 12))
    _ROOT = mp.nstr(2 - mp.sqrt(2), 30)
    _ROOT_HALF = mp.nstr(2 * (2 - mp.sqrt(3)), 30)


def _alpha(alpha_m: str, alpha_f: str) -> dict[str, str]:
    """Generalized-α with given α_m and α_f; γ gives second order, and β the largest damping of high frequencies."""
    with mp.workdps(40):
        m, f = (mp.fraction(*map(int, text.split("/"))) for text in (alpha_m, alpha_f))
        numbers = {"alpha_m": m, "alpha_f": f, "beta": (1 - m + f) ** 2 / 4, "gamma": mp.mpf(1) / 2 - m + f}
        return {"family": "generalized_alpha", **{name: mp.nstr(+value, 30) for name, value in numbers.items()}}


#: Title and parameters of each scheme, by its code of three characters.
SCHEMES: dict[str, tuple[str, dict[str, str]]] = {
    "AVG": ("average acceleration", {"family": "newmark", "beta": "0.25", "gamma": "0.5"}),
    "LIN": ("linear acceleration", {"family": "newmark", "beta": _SIXTH, "gamma": "0.5"}),
    "FOX": ("Fox and Goodwin's method", {"family": "newmark", "beta": _TWELFTH, "gamma": "0.5"}),
    "DIS": ("Newmark's method with γ = 0.6", {"family": "newmark", "beta": "0.3025", "gamma": "0.6"}),
    "CDM": ("central difference", {"family": "central_difference"}),
    "WIL": ("Wilson's θ-method", {"family": "wilson", "theta": "1.4"}),
    "HOU": ("Houbolt's method", {"family": "houbolt", "start": "linear acceleration"}),
    "HHT": ("HHT-α", {"family": "hht", "alpha": "-0.1", "beta": "0.3025", "gamma": "0.6"}),
    "H96": ("the α-method of 1996", {"family": "hht_1996", "alpha": "-0.1", "beta": "0.3025", "gamma": "0.6"}),
    "WBZ": ("WBZ-α with ρ∞ = 0.8", _alpha("-1/9", "0/1")),
    "GEN": ("generalized-α with ρ∞ = 0.8", _alpha("1/3", "4/9")),
    "BAT": ("Bathe's method", {"family": "bathe", "gamma": "0.5", "rho_inf": "0"}),
    "RBA": ("ρ∞-Bathe with ρ∞ = 1/2", {"family": "bathe", "gamma": _ROOT_HALF, "rho_inf": "0.5"}),
    "TRB": ("TR-BDF2", {"family": "bathe", "gamma": _ROOT, "rho_inf": "0"}),
    "RK4": ("the classical Runge-Kutta method", {"family": "rk4"}),
    "MID": ("the implicit midpoint rule", {"family": "midpoint"}),
    "SYE": ("symplectic Euler", {"family": "symplectic_euler"}),
    "KRA": ("KR-α with ρ∞ = 0.8", {"family": "kr_alpha", "rho_inf": "0.8"}),
    "NBA": ("Noh and Bathe's explicit method", {"family": "noh_bathe", "p": "0.54"}),
    "TCH": ("Tchamwa and Wielgosz's method", {"family": "tchamwa_wielgosz", "phi": "1.033"}),
}

#: Codes of the schemes that are stable at any step size on linear problems.
STABLE = ("AVG", "DIS", "WIL", "HOU", "HHT", "H96", "WBZ", "GEN", "BAT", "RBA", "TRB", "MID", "KRA")


class Entry(NamedTuple):
    """A problem with its step sizes; together with each of its schemes it makes one case.

    Attributes
    ----------
    name, title, why
        Short name, whose first letter is the level; title of a few words; purpose in one sentence.
    problem, dt, steps, at
        Problem, step size and number of steps of the cases; numbers of the steps after which values are compared,
        with 0 for the start.
    schemes
        Codes of the schemes, which are keys of ``SCHEMES``; None for all schemes.
    kind
        Kind of expectation: ``identical``, ``bound`` or ``order``.
    tags
        Tags in addition to the level, the family of the scheme and the form of the problem.
    sizes
        Sizes of unequal steps, which replace ``dt`` and ``steps``; empty for equal steps.
    version
        First version of the kit that has the case.
    """

    name: str
    title: str
    why: str
    problem: dict[str, Any]
    dt: str = ""
    steps: int = 0
    at: tuple[int, ...] = ()
    schemes: tuple[str, ...] | None = None
    kind: str = "identical"
    tags: tuple[str, ...] = ()
    sizes: tuple[str, ...] = ()
    version: str = "2026.1"


def _problem(
    form: str, u0: str = "0", v0: str = "0", mass: str = "1", damping: str = "0", loads: Any = (), **parameters: str
) -> dict[str, Any]:
    """The part ``problem`` of a case; in the text of a matrix, semicolons separate the rows."""

    def matrix(text: str) -> list[list[str]]:
        return [row.split() for row in text.split(";")]

    numbers = {name: matrix(value) if name == "stiffness" else value for name, value in parameters.items()}
    matrices = {"mass": matrix(mass), "damping": matrix(damping), "u0": u0.split(), "v0": v0.split()}
    return {"form": form, "parameters": numbers, **matrices, **dict(loads)}


def _load(amplitude: str, frequency: str, phase: str = "0") -> dict[str, Any]:
    return {"load": {"amplitude": amplitude.split(), "frequency": frequency, "phase": phase}}


#: Invented samples of a ground acceleration with a pulse and a pause. The last sample is zero, because codes differ in
#: the load at and after a last sample that is not zero.
_RECORD = "0 0.9 2.1 1.4 -0.6 -2.8 -3.3 -1.2 1.7 2.9 0.4 -1.5 0 0 0.8 -0.3 0"
_GROUND = {"ground": {"dt": "0.05", "acceleration": _RECORD.split()}}

_HARDENING = _problem("cubic", u0="1.5", S1="100", S2="10")
_YIELD = {"form": "elastoplastic", "k": "40", "yield_force": "4", "hardening": "0.05", "damping": "0.2"}
_FRAME = {
    "mass": "2 0 0; 0 2 0; 0 0 1.5",
    "damping": "2 -0.8 0; -0.8 1.7 -0.6; 0 -0.6 0.9",
    "stiffness": "600 -280 0; -280 500 -220; 0 -220 220",
}
_COUPLED = {"mass": "2 0.5; 0.5 1", "damping": "0.3 0; 0 0.1", "stiffness": "8 -3; -3 5"}
_STIFF = {"mass": "1 0; 0 1", "damping": "0 0; 0 0", "k1": "1e4", "k2": "1"}

_OF_1996 = ("AVG", "CDM", "DIS", "WIL", "HOU", "H96", "RK4")
_MAIN = ("AVG", "DIS", "CDM", "WIL", "HOU", "HHT", "GEN", "BAT", "RK4")
_IMPLICIT = ("AVG", "DIS", "WIL", "HOU", "HHT", "WBZ", "GEN", "BAT", "TRB", "MID")
_FEW = ("AVG", "DIS", "WIL", "HHT", "GEN", "BAT")

#: The ten values of ωΔt of level B, each with the codes of its schemes; None for all schemes.
_STEPS: dict[str, tuple[str, ...] | None] = {
    "0.05": _MAIN,
    "0.1": ("AVG", "CDM"),
    "0.3": ("AVG", "CDM", "HHT", "BAT", "RK4"),
    "0.6": ("AVG", "CDM"),
    "1": None,
    "1.5": ("AVG", "CDM", "WIL", "RK4"),
    "1.9": ("AVG", "CDM", "FOX", "RK4"),
    "5": ("AVG", "DIS", "WIL", "HOU", "HHT", "GEN", "BAT"),
    "30": STABLE,
    "200": ("AVG", "WIL", "GEN", "BAT"),
}


def _level_a() -> Iterator[Entry]:
    why = "The first steps show a wrong start, a load at a wrong time and damping on a wrong velocity."
    problem = _problem("linear", "1", "-3", "2", "0.6", _load("5", "3", "0.5"), stiffness="50")
    yield Entry("A-LIN", "start and two steps, linear", why, problem, "0.05", 2, (0, 1, 2))
    problem = _problem("cubic", "0.5", "3", "1", "4", _load("20", "7"), S1="100", S2="10")
    schemes = (*_MAIN, "H96", "WBZ", "TRB", "MID", "NBA")
    yield Entry("A-CUB", "start and two steps, cubic", why, problem, "0.02", 2, (0, 1, 2), schemes)


def _level_b() -> Iterator[Entry]:
    # v₀ = 0.5 would hide mistakes, because the first step of average acceleration at ωΔt = 1 would end at u₀
    problem = _problem("linear", "1", "0.7", stiffness="1")
    for step, schemes in _STEPS.items():
        why = f"Every step of linear motion is the amplification matrix at ωΔt = {step}, which is the scheme itself."
        yield Entry(f"B-{step}", f"free motion at ωΔt = {step}", why, problem, step, 10, (1, 2, 5, 10), schemes)
    why, problem = "A scheme that is stable on paper must not grow.", _problem("linear", "1", stiffness="1")
    yield Entry("B-BOUND", "energy at ωΔt = 100", why, problem, "100", 100, schemes=STABLE, kind="bound")


def _level_c() -> Iterator[Entry]:
    why, at = "The springs of 1996 show whether the iteration ends at the balance that the scheme states.", (1, 5, 20)
    yield Entry("C-HARD", "hardening spring", why, _HARDENING, "0.0075", 20, at)
    schemes: tuple[str, ...] = (*_OF_1996, "HHT", "GEN", "BAT", "MID")
    yield Entry("C-SOFT", "softening spring", why, _problem("tanh", "4", S="100"), "0.057", 20, at, schemes)
    yield Entry("C-LARGE", "softening spring, large", why, _problem("tanh", "10", S="100"), "0.09", 20, at, _OF_1996)
    yield Entry("C-WELL", "double well", why, _problem("cubic", "0.5", S1="-0.5", S2="-1"), "0.365", 20, at, _OF_1996)
    why, schemes = "Large rotations with an initial velocity.", ("AVG", "HHT", "GEN", "BAT", "MID", "RK4")
    yield Entry(
        "C-PEND", "pendulum thrown near its top", why, _problem("pendulum", "0", "1.9", g="1"), "0.3", 20, at, schemes
    )
    why = "A scheme that is stable on paper must not grow."
    yield Entry(
        "C-BOUND", "energy on the hardening spring", why, _HARDENING, "0.0075", 200, schemes=_IMPLICIT, kind="bound"
    )


def _level_d() -> Iterator[Entry]:
    why = "Damping and load together show the time at which each is taken."
    problem = _problem("linear", damping="0.6", loads=_load("2", "6", "0.4"), stiffness="39")
    schemes: tuple[str, ...] = (*_MAIN, "H96", "TRB", "MID", "KRA", "NBA")
    yield Entry("D-HARM", "damped, harmonic load near resonance", why, problem, "0.08", 20, (1, 4, 20), schemes)
    why, schemes = "A record of the ground has kinks, and is zero after its end.", (*_MAIN, "KRA", "NBA")
    problem = _problem("linear", mass="3", damping="2", loads=_GROUND, stiffness="160")
    yield Entry("D-BASE", "damped, moving ground", why, problem, "0.05", 20, (1, 6, 20), schemes)
    why = "A force without symmetry about the start shows errors of sign."
    problem, title = (
        _problem("cubic", "1", damping="0.3", loads=_load("0.5", "1.2"), S1="-1", S2="-1"),
        "Duffing's oscillator",
    )
    yield Entry("D-DUF", f"{title} with two wells, damped and loaded", why, problem, "0.2", 20, (1, 6, 20), _MAIN)
    why = "The error must fall with the order of the scheme, with damping and load too."
    problem = _problem("cubic", "1", "0.3", damping="0.4", loads=_load("0.8", "1.3", "0.3"), S1="1", S2="0.5")
    # at these step sizes KR-α, which is of first order, does not yet converge with this order
    schemes = tuple(code for code in SCHEMES if code != "KRA")
    yield Entry("D-ORDER", "order with damping and load", why, problem, "0.05", 40, schemes=schemes, kind="order")


def _level_e() -> Iterator[Entry]:
    why = "A spring that yields and unloads shows when its history is committed."
    schemes = (*_MAIN, "WBZ", "TRB", "MID", "NBA")
    yield Entry("E-YIELD", "elastoplastic spring", why, _problem(**_YIELD, v0="2.5"), "0.05", 20, (1, 5, 20), schemes)
    why, problem = "Several cycles of yield.", _problem(**_YIELD, loads=_load("6", "5"))
    title = "elastoplastic spring under a load that alternates"
    yield Entry("E-CYCLE", title, why, problem, "0.06", 20, (1, 6, 20), _FEW)
    why, problem = (
        "Contact shows whether the iteration ends at a kink.",
        _problem("gap", "-0.02", loads=_load("9.81", "0"), k="1000", gap="0"),
    )
    yield Entry("E-GAP", "a mass that bounces on a stop", why, problem, "0.01", 20, (1, 8, 20), _MAIN)


def _level_f() -> Iterator[Entry]:
    why = "Several unknowns, a damping matrix and a moving ground."
    problem = _problem("linear", u0="0 0 0", v0="0 0 0", loads=_GROUND, **_FRAME)
    schemes: tuple[str, ...] = (*_MAIN, "KRA")
    title = "frame of three storeys on moving ground"
    yield Entry("F-FRAME", title, why, problem, "0.05", 20, (1, 6, 20), schemes, tags=("structure",))
    why = "A mass matrix with coupling must be factorised, not divided by."
    problem, schemes = _problem("linear", u0="1 0", v0="0 2", **_COUPLED), ("AVG", "CDM", "HHT", "GEN", "BAT", "RK4")
    title, tags = "two unknowns with a full mass matrix", ("structure", "full_mass")
    yield Entry("F-MASS", title, why, problem, "0.2", 20, (1, 5, 20), schemes, tags=tags)
    why, tags = "A stiff mode next to a soft one, at a step that only the soft one needs.", ("structure", "stiff")
    problem = _problem("stiff_sine", u0="0 0", v0="0 1", loads=_load("1e4 0", "1.2", "1.5"), **_STIFF)
    yield Entry("F-SINE", "stiff and sine spring in a row", why, problem, "0.2", 20, (1, 5, 20), _FEW, tags=tags)


def _level_g() -> Iterator[Entry]:
    why = "A code that changes its step shows which acceleration and which step it carries over."
    options: dict[str, Any] = {"tags": ("unequal_steps",), "version": "2026.2"}
    problem = _problem("linear", "1", "-3", "2", "0.6", stiffness="50")
    title, sizes = "linear, steps h and 2h in turn", ("0.05", "0.1") * 5
    yield Entry("G-LIN", title, why, problem, at=(2, 10), schemes=("AVG", "GEN"), sizes=sizes, **options)
    title, sizes = "hardening spring, steps h and 2h in turn", ("0.005", "0.01") * 5
    yield Entry(
        "G-CUB", title, why, _HARDENING, at=(2, 10), schemes=("AVG", "CDM", "HHT", "GEN"), sizes=sizes, **options
    )
    problem = _problem("linear", damping="0.6", loads=_load("2", "6", "0.4"), stiffness="39")
    options |= {"schemes": ("AVG", "CDM", "GEN"), "sizes": ("0.08", "0.05", "0.05", "0.11", "0.02", "0.09", "0.07")}
    yield Entry("G-HARM", "damped, harmonic load, irregular steps", why, problem, at=(2, 7), **options)


_LEVELS = (_level_a, _level_b, _level_c, _level_d, _level_e, _level_f, _level_g)

PROBLEMS = [entry for level in _LEVELS for entry in level()]

ORDERS = [entry for entry in PROBLEMS if entry.kind == "order"]
