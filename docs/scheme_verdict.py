"""The verdict on a scheme: suitable and unsuitable uses, the steps that it needs, and a better scheme."""

import html
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

import study
from docs.text import definitions, table
from docs.theory import PERIODS, ROUND_OFF, STEPS, TRIED, Theory
from paper.measures.orders import lost as loses_order
from paper.measures.outcomes import fewest_steps, most_steps
from paper.tables.decision import steps_of
from study.runs.needs import NO_VALUE, TIED, WHOLE_MOTION, cost, keeps_part
from study.sizes import unbroken
from study.words import listed, number, percent, up_to

if TYPE_CHECKING:
    from docs.scheme_page import Library, Subject

#: Title of the problem whose steps follow from linear theory.
LINEAR = "undamped linear oscillator"
#: Mark of a step that keeps the displacement, but not the whole motion.
PARTLY = "\u00a0*"
#: Allowed errors of the displacement, and the one at which schemes are compared.
ERRORS = (0.1, 0.01, 0.001)
COMPARED = 0.01
#: Largest error of a balance of energies that counts as kept.
LEVEL = 0.1
#: Relative change of amplitude per period at the rule of thumb above which a scheme is unsuitable for long motions.
DAMPS = 0.01
#: Spectral radius, at infinite frequency or close to the stability limit, below which modes count as damped.
RADIUS = 0.9
#: Difference of two spectral radii at infinite frequency below which they count as equal: several roots may meet there,
#: and are then known to a root of round-off only.
SAME_RADIUS = 1e-3
#: Share of the schemes above which the text speaks of most schemes.
MOST = 0.5
#: Fraction of the error of a scheme below which the error of another scheme counts as smaller.
BETTER = 0.9


def _in_theory(library: "Library", error: float) -> pd.DataFrame:
    rows = {}
    for subject in map(library.subject, library.schemes):
        if kept := unbroken(subject.theory.error <= error).sum():
            steps = int(TRIED[kept - 1])
            rows[subject.name] = [
                _kind(subject.scheme),
                f"{steps:,}",
                steps * subject.theory.forces,
                steps * subject.theory.forces,
                subject.theory.error[kept - 1],
            ]
    return pd.DataFrame.from_dict(rows, orient="index", columns=["kind", "steps", "forces", "cost", "error"])


def needs(library: "Library") -> dict[str, dict[float, pd.DataFrame]]:
    """Tables of steps and forces per period, by title of the problem and by error of the displacement.

    Each row is a scheme that keeps the error, with its ``kind``.
    """
    tables = {LINEAR: {error: _in_theory(library, error) for error in ERRORS}}
    for problem in _problems(library):
        tables[problem.problem_title.item()] = {
            error: _table_of_runs(problem.sel(allowed_error=error)) for error in problem.allowed_error.values
        }
    return tables


def _problems(library: "Library") -> Iterator[xr.Dataset]:
    """The needs of schemes for an error of the displacement, by problem."""
    data = library.data["needs"]
    if data.scheme.size:
        displacement = data.sel(quantity="displacement")
        for place in np.flatnonzero((displacement.verdict != NO_VALUE).any(["scheme", "allowed_error", "condition"])):
            yield displacement.isel(problem=place)


def _table_of_runs(needed: xr.Dataset) -> pd.DataFrame:
    needed = needed.assign(partly=keeps_part(needed)).sel(condition="practice")
    kept = needed.isel(scheme=np.flatnonzero(needed.step_size > 0))
    rows = [
        [
            "explicit" if row.explicit == 1 else "implicit",
            steps_of(row) + (PARTLY if row.partly else ""),
            row.force_evaluations / row.decided,
            cost(row),
            row.error,
        ]
        for row in (kept.isel(scheme=k) for k in range(kept.sizes["scheme"]))
    ]
    columns = ["kind", "steps", "forces", "cost", "error"]
    frame = pd.DataFrame(rows, kept.scheme.values, columns)
    return frame.astype({"forces": float, "cost": float, "error": float})


def tried(library: "Library") -> dict[str, set[str]]:
    """Names of the schemes that ran on each problem, by title."""
    schemes = {LINEAR: {*library.schemes}}
    for problem in _problems(library):
        ran = (problem.verdict != NO_VALUE).any(["allowed_error", "condition"]).values
        schemes[problem.problem_title.item()] = {*problem.scheme.values[ran]}
    return schemes


def _lost(structures: xr.Dataset) -> xr.DataArray:
    """Whether the run fails or its energies are out of balance at one or more step sizes, over (problem, scheme)."""
    if not structures.scheme.size:
        return xr.DataArray(np.empty((0, 0), bool), dims=("problem", "scheme"))
    return ((structures.status != 0) | ~(structures.max_energy_imbalance <= LEVEL)).any("steps_per_period")


def _best(rows: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Rows of the schemes of a kind that tie for the least cost, in the order of the table of decisions."""
    rows = rows[rows.kind == kind]
    return rows[rows.cost <= TIED * rows.cost.min()].sort_values("error", kind="stable")


def _link(name: str, library: "Library") -> str:
    return f'<a href="{name}.html">{html.escape(library.schemes[name].title)}</a>'


def _kind(scheme: study.Scheme) -> str:
    return "explicit" if scheme.explicit else "implicit"


def _steps(subject: "Subject", library: "Library") -> str:
    """Table of steps by problem and error, and of the cheapest scheme of the same kind."""
    rows, name = [], subject.name
    for title, tables in library.needs.items():
        if name not in library.tried[title]:
            continue
        cells = [
            f"{frame.steps[name]} ({frame.forces[name]:,.0f})" if name in frame.index else "–"
            for frame in (tables[error] for error in ERRORS)
        ]
        best = _best(tables[COMPARED], _kind(subject.scheme))
        least = "–" if best.empty else "this one"
        if not best.empty and name != best.index[0]:
            first = best.iloc[0]
            least = f"[{library.schemes[best.index[0]].title}]({best.index[0]}.md): {first.steps} ({first.forces:,.0f})"
        rows.append([title, *cells, least])
    head = ["problem", *(f"{100 * error:g} %" for error in ERRORS), f"cheapest for {100 * COMPARED:g} %"]
    bounds = [f"{100 * bound:g}\u00a0% ({name})" for name, bound in WHOLE_MOTION.items() if name != "displacement"]
    runs = (
        "The other rows are results of runs. On the hardening and the softening spring the error is the largest over a "
        "hundred periods, in which the phase error grows. ≤ marks the coarsest step that was tried, and † marks the "
        f"finest. {PARTLY.strip()} marks a step that keeps the displacement, while at it or at a finer step "
        f"another error exceeds its bound: {listed(bounds)}."
    )
    return (
        "Steps per period, and in brackets forces per period, for an error of the displacement:\n\n"
        + table(head, rows, numbers_from=len(head))
        + f"\n\nThe first row is linear theory over {PERIODS} periods, for the worse of two starts, at rest and "
        "through zero. Steps finer than these keep the error too. The last column names the "
        f"{_kind(subject.scheme)} scheme of the least cost, in forces or, with 100 and more unknowns, in computing "
        "time; of schemes that cost at most a tenth more, the one with the smallest error. A dash means that no step "
        "tried keeps the error. "
        f"{runs if len(rows) > 1 else _not_run(subject)} {{doc}}`/decisions` compares all schemes."
    )


def _good(subject: "Subject", library: "Library") -> Iterator[str]:
    scheme, theory, structures = subject.scheme, subject.theory, library.data["structures"]
    fewest = [
        title for title, tables in library.needs.items() if subject.name in _best(tables[COMPARED], _kind(scheme)).index
    ]
    if fewest:
        yield (
            f"displacements within {percent(COMPARED)} on the {listed(fewest)}, where no {_kind(scheme)} scheme "
            f"compared costs less by more than {percent(TIED - 1)}"
        )
    if math.isinf(theory.limit):
        without = " without iterations" if scheme.explicit else ""
        stiffer = " as long as they do not become stiffer than its model" if scheme.explicit else ""
        yield f"stiff structures{without}: stability limits no step in linear theory{stiffer}"
        if theory.at_infinity < RADIUS:
            yield f"modes that the step does not resolve, which it damps (ρ∞ = {number(theory.at_infinity)})"
    if theory.least_radius < RADIUS:
        least = number(theory.least_radius, 2)
        yield f"modes close to its stability limit, which it damps (spectral radius down to {least})"
    if subject.name in structures.scheme.values:
        lost = _lost(structures)
        rare = ~lost.sel(scheme=subject.name) & (lost.mean("scheme") > MOST)
        if rare.any():
            yield (
                f"coarse steps on the {listed(structures.problem_title.values[rare.values].tolist())}: it keeps the "
                f"balance of energies to {percent(LEVEL)} with all steps tried, and most schemes do not"
            )
    if theory.limit > 0 and abs(theory.decay_of_rule) < ROUND_OFF:
        yield "long motions, whose amplitude it keeps in linear theory"
    if min(scheme.order, scheme.order_with_damping) >= 4:
        yield f"small errors, as its order is {min(scheme.order, scheme.order_with_damping)}"
    elif scheme.order >= 4:
        yield f"small errors without damping, where its order is {scheme.order}"


def _stable_again(theory: Theory) -> bool:
    """Whether a scheme with a stability limit is stable at steps above it."""
    radius = theory.linear.spectral_radius
    above = 2 * np.pi * radius.step_size_over_period > theory.limit * (1 + 1e-3)
    return bool((above & (radius <= 1 + ROUND_OFF)).any())


def _bad(subject: "Subject", library: "Library") -> Iterator[str]:
    scheme, theory, data = subject.scheme, subject.theory, library.data
    if theory.limit == 0:
        growth = number(-100 * theory.decay_of_rule, 2)
        yield f"long undamped motions, which grow at any step: at {STEPS} per period by {growth}\u00a0% per period"
    elif math.isfinite(theory.limit):
        unstable = f"unstable without damping{', except in parts' if _stable_again(theory) else ''}"
        yield f"structures with ωΔt above {up_to(theory.limit)} in any mode, where it is {unstable}"
    elif theory.at_infinity > 1 - ROUND_OFF:
        yield "modes that are excited and that the step does not resolve, which it does not damp (ρ∞ = 1)"
    if abs(theory.decay_of_rule) > DAMPS and theory.limit > 0:
        change = "falls" if theory.decay_of_rule > 0 else "grows"
        yield (
            f"long motions with few steps: at {STEPS} per period the amplitude {change} by "
            f"{percent(abs(theory.decay_of_rule))} per period"
        )
    if scheme.order == 1:
        yield "small errors, as its order is 1"
    elif scheme.order_with_damping == 1:
        yield "small errors with damping or load, where its order is 1"
    partly = [
        title
        for title, tables in library.needs.items()
        if any(subject.name in frame.index and PARTLY in frame.steps[subject.name] for frame in tables.values())
    ]
    if partly:
        yield f"velocity, acceleration or energy on the {listed(partly)} at the steps marked {PARTLY.strip()} below"
    atlas, kinks, structures = data["stability/atlas"], data["kinks"], data["structures"]
    circumstances = data["order_under_reality"]
    if subject.name in circumstances.scheme.values:
        motion = loses_order(circumstances.sel(scheme=subject.name, quantity=["displacement", "velocity"]))
        titles = circumstances.circumstance_title.values[motion.any("quantity").values].tolist()
        if titles:
            yield (
                f"small errors in these circumstances, where displacement or velocity lose the order {scheme.order} "
                f"or do not converge: {listed(titles)}"
            )
    if subject.name in atlas.scheme.values:
        needed = fewest_steps(atlas, LEVEL).sel(scheme=subject.name)
        lost = atlas.problem_title.values[np.isnan(needed.values)].tolist()
        if lost:
            yield (
                f"all amplitudes of the {listed(lost)}, where {most_steps(atlas)} steps per period are needed to keep "
                f"the energy within {percent(LEVEL)}"
            )
    if subject.name in kinks.scheme.values and scheme.order >= 2:
        orders = zip(kinks.problem_title.values, kinks.observed_order.sel(scheme=subject.name).values, strict=True)
        low = [f"{title} (observed order {number(order, 2)})" for title, order in orders if order < 1.5]
        if low:
            yield f"small errors on the {listed(low)}"
    if subject.name in structures.scheme.values:
        lost = _lost(structures)
        faults = lost.sel(scheme=subject.name) & ~lost.all("scheme")
        titles = structures.problem_title.values[faults.values].tolist()
        if titles:
            yield (
                f"coarse steps on the {listed(titles)}: with some of them the run fails or the energies are out of "
                f"balance by more than {percent(LEVEL)}, while another scheme keeps the balance with all steps tried"
            )


def _dominates(other: "Subject", subject: "Subject") -> bool:
    """Whether ``other`` is a scheme of the same kind as ``subject`` and better.

    A better scheme has a smaller error, no worse order, stability and damping, and no higher cost.
    """
    a, b, s, t = other.theory, subject.theory, other.scheme, subject.scheme
    return bool(
        s.explicit == t.explicit
        and a.forces <= b.forces
        and s.order >= t.order
        and s.order_with_damping >= t.order_with_damping
        and a.limit >= b.limit
        and (not math.isinf(b.limit) or a.at_infinity <= b.at_infinity + SAME_RADIUS)
        # only a scheme that also keeps the amplitude can dominate a scheme that keeps it
        and (abs(b.decay_of_rule) > ROUND_OFF or abs(a.decay_of_rule) <= ROUND_OFF)
        and a.error_of_rule < BETTER * b.error_of_rule
    )


def _alternative(subject: "Subject", library: "Library") -> str:
    """A phrase on a better scheme, or on the lack of a better scheme.

    Of several better schemes it names the one with the nearest ρ∞. If the scheme has a stability limit, it names the
    one with the smallest error.
    """
    theory, structures, better = subject.theory, library.data["structures"], []
    lost = {row.scheme.item(): {*row.problem.values[row.values]} for row in _lost(structures).transpose("scheme", ...)}
    for name in library.schemes:
        other = library.subject(name)
        loses_more = subject.name in lost and not lost.get(name, set()) <= lost[subject.name]
        if not loses_more and _dominates(other, subject):
            distance = abs(other.theory.at_infinity - theory.at_infinity) if math.isinf(theory.limit) else 0.0
            better.append((distance, other.theory.error_of_rule, name))
    if not better:
        reasons = [
            f"has more than {percent(BETTER)} of its error of the displacement over a period of {STEPS} steps",
            "is worse in order, stability, damping of high frequencies or conservation of the amplitude",
        ]
        if subject.name in lost:
            reasons.append("loses the balance of energies on a structure where this one keeps it")
        others = f"every {_kind(subject.scheme)} scheme here that needs as few forces a step"
        return f"none in linear theory: {others} {', '.join(reasons[:-1])} or {reasons[-1]}"
    best = library.subject(min(better)[2])
    return (
        f"{_link(best.name, library)}: in linear theory, for as few forces, the error of the displacement over a "
        f"period of {STEPS} steps is {percent(best.theory.error_of_rule)} of its amplitude instead of "
        f"{percent(theory.error_of_rule)}. Order, stability and damping of high frequencies are no worse."
    )


def _items(reasons: Iterator[str], none: str) -> str:
    items = "".join(f"<li>{html.escape(reason)}</li>" for reason in reasons)
    return f"<ul>{items}</ul>" if items else none


def _not_run(subject: "Subject") -> str:
    """Sentences on the missing runs of a scheme."""
    missing = "This study ran the scheme on none of the other problems, so sections without data are omitted"
    if subject.name in study.schemes:
        return f"{missing}. The full study runs all named schemes."
    return f"{missing}. The key `own_schemes` of the configuration adds the scheme to the datasets."


def verdict(subject: "Subject", library: "Library") -> str:
    """The first screen of the page: uses, limits, the nearest better scheme, and steps by problem and error."""
    facts = {
        "use it for": _items(_good(subject, library), "no case that the data of this page show"),
        "not for": _items(_bad(subject, library), "no case that the data of this page exclude"),
        "nearest better scheme": _alternative(subject, library),
    }
    return f"{definitions(facts)}\n\n{_steps(subject, library)}"
