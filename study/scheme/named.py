"""Every scheme that can be called by name.

A scheme has the name of the variable that holds it in a module of this package: ``bdf2 = BackwardDifferences(...)`` in
``backward_differences.py`` makes ``study.schemes["bdf2"]``.
"""

from study import scheme
from study.registry import Registry, variables_of_modules
from study.scheme.base import Scheme
from study.scheme.contract import check_attributes


def _checked_families(schemes: dict[str, Scheme]) -> dict[str, Scheme]:
    """The schemes, after a check that each of them has a ``family``."""
    for name, member in schemes.items():
        if not hasattr(member, "family"):
            raise ValueError(f"the scheme '{name}' needs a class variable 'family', by which figures group schemes.")
    return schemes


#: The schemes of Xie (1996), in the order of its tables.
SCHEMES_OF_1996 = (
    "average_acceleration",
    "central_difference",
    "newmark_dissipative",
    "wilson_theta",
    "houbolt",
    "hht_alpha_1996",
    "rk4",
)

#: Names of some schemes in other programs and in books, each with the name of the scheme here.
ALIASES = {
    "velocity_verlet": "central_difference",
    "verlet": "central_difference",
    "leapfrog": "central_difference",
    "cd": "central_difference",
    "newmark": "average_acceleration",
    "newmark_beta": "average_acceleration",
    "constant_average_acceleration": "average_acceleration",
    "trapezoidal": "average_acceleration",
    "trapezoidal_rule": "average_acceleration",
    "crank_nicolson": "average_acceleration",
    "wilson": "wilson_theta",
    "hht": "hht_alpha",
    "hilber_hughes_taylor": "hht_alpha",
    "chung_hulbert": "generalized_alpha",
    "runge_kutta": "rk4",
    "runge_kutta_4": "rk4",
}

#: All schemes by name: first the schemes of 1996, then the others, module by module.
schemes: Registry[Scheme] = Registry(
    "scheme",
    _checked_families(variables_of_modules(scheme, Scheme, first=SCHEMES_OF_1996)),  # type: ignore[type-abstract]
    aliases=ALIASES,
)


def register_scheme(name: str, scheme: Scheme) -> None:
    """Register your own scheme under a name, which experiments and all functions of the study then accept.

    Raises
    ------
    TypeError
        If ``scheme`` is not a :class:`study.Scheme`, or its title, orders or stability limit are invalid.
    ValueError
        If the name is taken or invalid, or the scheme has no class variable ``family``, by which figures group schemes.
    """
    if not isinstance(scheme, Scheme):
        raise TypeError(f"{scheme!r} is no scheme: give an instance of a study.Scheme.")
    check_attributes(scheme)
    _checked_families({name: scheme})
    schemes.add(name, scheme)
