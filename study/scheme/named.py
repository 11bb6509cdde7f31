"""Every scheme that can be called by name.

A scheme is named by a variable of a module of this package: ``bdf2 = BackwardDifferences(...)`` in
``backward_differences.py`` makes ``study.schemes["bdf2"]``.
"""

from study import scheme
from study.registry import Registry, variables_of_modules
from study.scheme.base import Scheme


def _of_families(found: dict[str, Scheme]) -> dict[str, Scheme]:
    """The schemes, if each of them names its family."""
    for name, one in found.items():
        if not hasattr(one, "family"):
            raise ValueError(f"the scheme '{name}' needs a class variable 'family', by which figures group schemes.")
    return found


#: The schemes of Xie (1996), in the order of its tables.
OF_1996 = (
    "average_acceleration",
    "central_difference",
    "newmark_dissipative",
    "wilson_theta",
    "houbolt",
    "hht_alpha",
    "rk4",
)

#: The schemes of 1996 first, then the others, module by module.
schemes: Registry[Scheme] = Registry(
    "scheme",
    _of_families(variables_of_modules(scheme, Scheme, first=OF_1996)),  # type: ignore[type-abstract]
    aliases={"velocity_verlet": "central_difference"},
)
