"""Curves of linear theory on the page of a scheme."""

from typing import TYPE_CHECKING

import numpy as np

from docs.drawing import ACCENT, INK, OTHER, figure_of, lines_legend, panel, svg
from docs.theory import PARTS, ROUND_OFF

if TYPE_CHECKING:
    from docs.scheme_page import Library, Subject

#: Schemes that every page shows for comparison, with their line styles.
COMPARED = {"average_acceleration": "--", "central_difference": ":"}


def linear_theory(subject: "Subject", library: "Library") -> str:
    """Curves over the step size for a page: spectral radius, period elongation and, if any, numerical damping."""
    drawn = [
        ("spectral_radius", "spectral radius", (1e-2, 1e2), (0.0, 1.5), "x"),
        ("period_elongation", "relative elongation of the period", (0.0, 0.4), (-0.4, 0.6), ""),
        ("algorithmic_damping", "numerical damping ratio", (0.0, 0.4), (-0.02, 0.25), ""),
    ]
    undamped = np.nanmax(np.abs(subject.theory.linear.algorithmic_damping), initial=0.0) < ROUND_OFF
    panels = []
    for name, label, horizontal, vertical, logarithmic in drawn[:-1] if undamped else drawn:
        figure, axes = panel(logarithmic)
        shown = (PARTS >= max(horizontal[0], 5e-3)) & (PARTS <= horizontal[1])
        for other, line in COMPARED.items():
            if other != subject.name and other in library.schemes:
                compared = library.subject(other)
                values = compared.theory.linear[name][shown]
                axes.plot(PARTS[shown], np.clip(values, -9, 9), color=OTHER, ls=line, lw=1.2)
        values = subject.theory.linear[name][shown]
        axes.plot(PARTS[shown], np.clip(values, -9, 9), color=ACCENT, lw=2)
        if name == "spectral_radius":
            axes.axhline(1.0, color=INK, lw=0.6)
        if name == "algorithmic_damping" and np.nanmin(values, initial=0.0) < vertical[0]:
            vertical = (-vertical[1], vertical[1])  # negative damping: the scheme adds energy
        axes.set(xlim=horizontal, ylim=vertical, xlabel="step size over period", ylabel=label)
        panels.append(svg(figure, f"{label} of {subject.scheme.title} over the step size"))
    caption = (
        "Linear theory, from the derivative of a step of the code. A run grows without bound where the spectral radius "
        f"exceeds one. {'Elongation ends' if undamped else 'Elongation and damping end'} where nothing oscillates."
        + (" The scheme has no numerical damping." if undamped else "")
    )
    lines = {COMPARED[name]: name for name in COMPARED if name != subject.name and name in library.schemes}
    legend = [("-", subject.scheme.title), *((line, library.schemes[name].title) for line, name in lines.items())]
    return figure_of([*panels, lines_legend(legend)], caption)
