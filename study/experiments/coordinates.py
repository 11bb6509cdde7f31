"""Coordinates and attributes that experiments share: problems, schemes, estimators and controllers, with properties."""

from collections.abc import Iterable, Sequence

from study import io
from study.analysis.forces import forces_of
from study.control.controllers import Reversible
from study.control.named import controllers, estimators
from study.problem.named import approximate_periods, problems
from study.scheme.named import schemes


def problem_coordinates(names: Sequence[str]) -> dict:
    """Names of problems along ``problem``, with their titles."""
    return {
        "problem": ("problem", list(names), {"long_name": "problem"}),
        "problem_title": ("problem", [problems[name].title for name in names], {"long_name": "title of the problem"}),
    }


def scheme_coordinates(names: Sequence[str]) -> dict:
    """Names of schemes along ``scheme``, with their properties.

    The properties are title, family, place in the family, order of accuracy, whether the energy is kept, kind (explicit
    or implicit), and source.
    """
    families = [[name for name, s in schemes.items() if s.family == schemes[member].family] for member in names]
    chosen = [schemes[name] for name in names]
    return {
        "scheme": ("scheme", list(names), {"long_name": "time integration scheme"}),
        "scheme_title": ("scheme", [s.title for s in chosen], {"long_name": "title of the scheme"}),
        "family": ("scheme", [s.family for s in chosen], {"long_name": "family of the scheme"}),
        "place_in_family": (
            "scheme",
            [family.index(schemes.resolve(name)) for family, name in zip(families, names, strict=True)],
            {"long_name": "place among all schemes of the family", "units": "1"},
        ),
        "order": ("scheme", [s.order for s in chosen], {"long_name": "order of accuracy", "units": "1"}),
        "order_with_damping": (
            "scheme",
            [s.order_with_damping for s in chosen],
            {"long_name": "least order of accuracy with damping or a load", "units": "1"},
        ),
        "order_of_loss": (
            "scheme",
            [s.order_of_loss for s in chosen],
            {"long_name": "order of the loss of energy in free vibration, infinite if there is none", "units": "1"},
        ),
        "explicit": ("scheme", [int(s.explicit) for s in chosen], {"long_name": "1 where explicit", "units": "1"}),
        "scheme_source": ("scheme", [s.source for s in chosen], {"long_name": "source of the scheme"}),
        "doi": ("scheme", [s.doi for s in chosen], {"long_name": "digital object identifier of the source"}),
    }


def forces_coordinates(names: Sequence[str], several: bool) -> dict:
    """Numbers of forces along ``scheme``, with one or several unknowns, without a velocity-dependent force."""
    counted = [forces_of(schemes[name], several) for name in names]
    return {
        "force_evaluations_per_step": (
            "scheme",
            [forces.per_step for forces in counted],
            {"long_name": "forces that a step evaluates in addition to Newton's iterations", "units": "1"},
        ),
        "force_evaluations_per_iteration": (
            "scheme",
            [forces.per_iteration for forces in counted],
            {"long_name": "forces that one Newton iteration evaluates", "units": "1"},
        ),
    }


def estimator_coordinates(names: Sequence[str]) -> dict:
    """Names of estimators along ``estimator``, with their titles."""
    return {
        "estimator": ("estimator", list(names), {"long_name": "estimator of the error of a step"}),
        "estimator_title": ("estimator", [estimators[name].title for name in names], {"long_name": "title"}),
    }


def control_coordinates(names: Sequence[str]) -> dict:
    """Names of controllers along ``controller``, with their titles."""
    titles = [controllers[name].title if name in controllers else Reversible.title for name in names]
    return {
        "controller": ("controller", list(names), {"long_name": "controller of the step"}),
        "controller_title": ("controller", titles, {"long_name": "title of the controller"}),
    }


def steps_per_period_coordinate(values: Iterable[float]) -> dict:
    """Steps per period along ``steps_per_period``."""
    attributes = {"long_name": "steps per period", "units": "1"}
    return {"steps_per_period": ("steps_per_period", list(values), attributes)}


def energy_attributes(periods: int) -> dict[str, str]:
    """Attributes of the largest energy error over a number of periods."""
    long_name = f"largest relative error of the total energy over {periods} periods, eq. (17) of Xie (1996)"
    return {"long_name": long_name, "units": "1"}


def periods(problem: str) -> dict[str, float]:
    """Periods of a spring: ``printed``, rounded as in the paper of 1996, and ``exact``, from its reference."""
    problems.resolve(problem)  # the message on an unknown name is clearer than a message on a missing dataset
    exact = io.open_dataset(f"reference/{problem}").period.item()
    return {"printed": approximate_periods[problem], "exact": exact}
