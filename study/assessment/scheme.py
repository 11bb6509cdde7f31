"""``study.assess_scheme``: your own scheme, compared with schemes of the study."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from study import io
from study.analysis.linear_theory import LinearTheory
from study.assessment.assess import assess
from study.assessment.drawing import COLOURS, MARKERS, figure_of, svg_of
from study.assessment.report import judgement, provenance
from study.assessment.style import STYLE
from study.assessment.tables import table_of
from study.io import processor
from study.marching.arguments import resolve
from study.scheme.base import Scheme
from study.scheme.contract import check_attributes
from study.scheme.named import schemes
from study.words import document, number, up_to

#: Default schemes for comparison.
COMPARED = ("average_acceleration", "central_difference", "generalized_alpha", "rk4")

#: Default problems and durations in s; None means ten periods. Stiff problems run for a short time, because the
#: reference resolves the stiffest mode.
ON = {"hardening": None, "softening": None, "double_well": None, "stiff_soft_sine": 5.0, "fpu_chain": 12.6}

#: Ratios of step to period of linear theory. Its curves begin at a hundredth; its order needs finer steps.
PARTS = np.logspace(-3, 1, 161)


class SchemeAssessment(NamedTuple):
    """Linear theory over ``scheme`` and ``step_size_over_period``, and an assessment for each problem."""

    linear: xr.Dataset
    problems: dict[str, xr.Dataset]


def _linear(chosen: dict[str, Scheme]) -> xr.Dataset:
    linear = xr.concat([LinearTheory(scheme, PARTS).dataset() for scheme in chosen.values()], "scheme")
    coordinates = {
        "scheme": (list(chosen), {"long_name": "time integration scheme"}),
        "scheme_title": ([scheme.title for scheme in chosen.values()], {"long_name": "name of the scheme"}),
        "claimed_order": ([scheme.order for scheme in chosen.values()], {"long_name": "claimed order of accuracy"}),
    }
    return linear.assign_coords({name: ("scheme", *values) for name, values in coordinates.items()})


def assess_scheme(
    scheme: str | Scheme,
    *,
    compare_with: str | Sequence[str] = COMPARED,
    problems: Sequence[str] | Mapping[str, float | None] = ON,  # type: ignore[assignment]
    allowed_errors: Sequence[float] = (0.1, 0.01),
) -> SchemeAssessment:
    """Compare a scheme with schemes of the study, in linear theory and on problems of the study.

    Parameters
    ----------
    scheme
        Your own :class:`study.Scheme`, or the name of a scheme.
    compare_with
        Names of schemes to compare with.
    problems
        Names of problems, or a mapping from names to durations in s; the duration None means ten periods. The default
        is three springs and two stiff systems.
    allowed_errors
        Allowed errors.

    Returns
    -------
    SchemeAssessment
        ``linear``, a dataset of linear theory, and ``problems``, a mapping from the name of each problem to its dataset
        of :func:`study.assess`.

    Raises
    ------
    KeyError, TypeError, ValueError
        As :func:`study.assess`; also if an attribute of the scheme is invalid.
    """
    candidate = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    check_attributes(candidate)
    name = schemes.resolve(scheme) if isinstance(scheme, str) else candidate.title
    others = [compare_with] if isinstance(compare_with, str) else compare_with
    chosen = {name: candidate} | {other: schemes[other] for other in others if schemes[other] is not candidate}
    durations = problems if isinstance(problems, Mapping) else dict.fromkeys(problems)
    linear = _linear(chosen)
    linear.attrs = io.provenance(f"{candidate.title} compared with other schemes", "study.assess_scheme", io.now())
    linear.attrs["processor"] = processor()
    datasets = {
        problem: assess(problem, chosen, duration=duration, allowed_errors=allowed_errors).assign_attrs(asked_for=name)
        for problem, duration in durations.items()
    }
    return SchemeAssessment(linear, datasets)


def _curve(linear: xr.Dataset, variable: str, label: str, limits: tuple[float, float]) -> str:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4), layout="constrained")
    axes = figure.subplots()
    for s, name in enumerate(linear.scheme.values):
        selected = linear.sel(scheme=name)
        axes.plot(
            selected.step_size_over_period,
            selected[variable],
            color=COLOURS[s % len(COLOURS)],
            marker=MARKERS[s % len(MARKERS)],
            markevery=12,
            ms=5,
            mfc="none",
            lw=2 if s == 0 else 1,
            label=str(selected.scheme_title.values),
        )
    axes.set(xscale="log", xlim=(1e-2, 1e1), ylim=limits, xlabel="step size over period", ylabel=label)
    axes.grid(color="0.9")
    figure.legend(loc="outside right upper", fontsize="small", frameon=False)
    return svg_of(figure)


def scheme_page(assessed: SchemeAssessment) -> str:
    """The page of an assessment of a scheme as HTML."""
    linear = assessed.linear
    rows = [
        (
            str(row.scheme_title.values),
            f"{row.claimed_order.item():g}",
            f"{row.linear_order.item():.2f}",
            up_to(row.stability_limit.item()),
            number(row.infinite_frequency_radius.where(np.isinf(row.stability_limit)).item()),
        )
        for row in (linear.sel(scheme=name) for name in linear.scheme.values)
    ]
    head = ("scheme", "order claimed", "order found", "largest stable ωΔt", "ρ∞")
    parts = ["<h2>Linear theory</h2>", table_of(head, rows)]
    caption = "Spectral radius; a scheme is unstable where it exceeds one."
    parts.append(figure_of(_curve(linear, "spectral_radius", "spectral radius", (0.0, 1.5)), caption))
    curve = _curve(linear, "period_elongation", "relative elongation of the period", (-0.5, 1.0))
    parts.append(figure_of(curve, "Elongation of the period."))
    for dataset in assessed.problems.values():
        parts += [f"<h2>{dataset.attrs['problem']}</h2>", *judgement(dataset)]
    return document(linear.attrs["title"], [*parts, *provenance(linear.attrs)], STYLE)
