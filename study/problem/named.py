"""All problems that can be used by name.

A problem has the name of a variable in a module of this package: the function ``pendulum`` in ``oscillators.py``,
decorated with :func:`study.problem.naming.named`, makes ``study.problems["pendulum"]``.
"""

from study import problem
from study.mechanics.definition import Problem
from study.problem.naming import NamedProblem
from study.registry import Registry, variables_of_modules

_ENTRIES = variables_of_modules(
    problem, NamedProblem, first=("hardening", "softening", "softening_large", "double_well")
)

#: Problems by name. Each problem is made and checked on first use.
problems: Registry[Problem] = Registry("problem", {}, makers=_ENTRIES)

#: The functions that make the problems; their docstrings have equations, parameters and sources.
makers = {name: getattr(entry.make, "func", entry.make) for name, entry in _ENTRIES.items()}

#: Time scale by which the step sizes of a problem are measured, for each problem that has one.
time_scales = {name: entry.time_scale for name, entry in _ENTRIES.items() if entry.time_scale is not None}

#: What the time is by which the step sizes of a problem are measured, in words.
time_scale_names = {name: entry.time_scale_name for name, entry in _ENTRIES.items()}

#: Approximate period of each spring.
approximate_periods = {name: entry.period for name, entry in _ENTRIES.items() if entry.period is not None}

#: Periods that Xie (1996) prints (sections 3.1, 3.2 and 4).
printed_periods = {name: period for name, period in approximate_periods.items() if _ENTRIES[name].printed}

#: Known displacement, printed by a source or exact, for each problem that has one.
known = {name: entry.known for name, entry in _ENTRIES.items() if entry.known is not None}
