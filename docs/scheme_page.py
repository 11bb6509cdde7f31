"""The page of a named scheme or of a user's scheme."""

import dataclasses
import html
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import pandas as pd

import study
from docs import scheme_results, scheme_verdict
from docs.confirmed import names_in_codes, printed_limit
from docs.docstrings import parsed
from docs.scheme_curves import linear_theory
from docs.text import definitions, described, index_entries
from docs.theory import PARTS, STEPS, Theory, theory_of
from study.analysis.forces import forces_of
from study.words import number, up_to

#: Fields of a scheme that are labels, not parameters.
_LABELS = {"title", "source", "doi", "stability_limit"}


@dataclass
class Subject:
    """A scheme and the name of its page."""

    name: str
    scheme: study.Scheme

    @cached_property
    def theory(self) -> Theory:
        """Linear theory of the scheme."""
        return theory_of(self.scheme)

    @property
    def parameters(self) -> dict[str, Any]:
        """Names and values of the scheme's parameters."""
        fields = (field.name for field in dataclasses.fields(self.scheme))
        return {name: getattr(self.scheme, name) for name in fields if name not in _LABELS}


@dataclass
class Library:
    """All schemes that have pages, their other names, and the datasets that the pages show, each by name."""

    data: Mapping[str, Any]
    schemes: Mapping[str, study.Scheme]
    aliases: Mapping[str, list[str]]
    _known: dict[str, Subject] = field(default_factory=dict)

    @cached_property
    def needs(self) -> Mapping[str, Mapping[float, pd.DataFrame]]:
        """Steps and evaluations of the force that the schemes need in a period, by title of the problem and error."""
        return scheme_verdict.needs(self)

    @cached_property
    def tried(self) -> Mapping[str, set[str]]:
        """Names of the schemes that ran on each problem, by title of the problem."""
        return scheme_verdict.tried(self)

    def subject(self, name: str) -> Subject:
        """A scheme by its name. Each call returns the same object, so that linear theory is computed once."""
        if name not in self._known:
            self._known[name] = Subject(name, self.schemes[name])
        return self._known[name]


def _value(value: Any) -> str:
    if isinstance(value, tuple):
        return "(" + ", ".join(map(_value, value)) + ")"
    if isinstance(value, study.Scheme):
        return value.title
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _values(subject: Subject) -> str:
    return ", ".join(f"{name} = {_value(value)}" for name, value in subject.parameters.items())


def stability(theory: Theory) -> str:
    """Largest stable step size, in a phrase."""
    if math.isinf(theory.limit):
        return "unconditionally, for linear systems"
    if theory.limit == 0:
        return "at no step size without damping"
    limit = up_to(theory.limit / (2 * math.pi))
    return f"without damping for ωΔt ≤ {up_to(theory.limit, 4)}, which is Δt ≤ {limit} T"


def high_frequencies(theory: Theory) -> str:
    """Damping of modes that the step does not resolve, in a phrase."""
    if theory.limit == 0:
        return "unstable"
    if math.isnan(theory.at_infinity):
        return "unstable, as the scheme is only conditionally stable"
    return f"spectral radius ρ∞ = {number(theory.at_infinity)} at infinite frequency"


def overshoot(theory: Theory) -> str:
    """Exponents of growth in the first step, and the largest overshoot within 64 steps, in a phrase.

    It is not given for a scheme with a stability limit, near which it may be large, or without a stable step.
    """
    if theory.limit == 0:
        return "every step, as the scheme is unstable without damping"
    if not math.isinf(theory.limit):
        return "not given, as there is a stability limit; near the limit it may be large"
    linear = theory.linear
    u_from_u, v_from_u, u_from_v, v_from_v = (
        round(linear[f"growth_{name}"].item()) for name in ("u_from_u", "v_from_u", "u_from_v", "v_from_v")
    )
    powers = f"U{u_from_u}V{v_from_u} from u₀ and U{u_from_v}V{v_from_v} from u̇₀"
    largest = (linear[f"{quantity}_overshoot"].max().item() for quantity in ("displacement", "velocity"))
    displacement, velocity = (number(value, 2) for value in largest)
    return (
        f"{powers}: the powers of ωΔt with which displacement (U) and velocity (V) grow in a long first step. In 64 "
        f"steps from u₀ = 1 and u̇₀ = 0 they overshoot by at most {displacement} and {velocity}, at step sizes up to "
        f"{number(PARTS[-1])} periods."
    )


def forces(scheme: study.Scheme) -> str:
    """Numbers of forces that a step and a Newton iteration evaluate, in a phrase."""
    counted, single = forces_of(scheme), forces_of(scheme, several=False).per_iteration
    phrases = [f"{counted.per_step} per step"] if counted.per_step else []
    phrases += [f"{counted.per_iteration} per Newton iteration"] if counted.per_iteration else []
    phrases[-1] += f", {single} with one unknown" if counted.per_iteration != single else ""
    return " and ".join(phrases)


def _facts(subject: Subject, aliases: list[str]) -> str:
    scheme, theory = subject.scheme, subject.theory
    name = html.escape(scheme.doi)
    doi = f', <a href="https://doi.org/{name}">doi:{name}</a>' if name else ""
    least = scheme.order_with_damping
    damped = f", at least {least} with damping or load" if least < scheme.order else ""
    order = theory.linear.linear_order.item()
    measured = f"{number(order)} on the linear oscillator, {number(theory.order_with_damping)} with damping"
    if scheme.order < round(order):
        measured += (
            "; a motion has the order claimed, because its displacement and velocity have larger errors than the roots"
        )
    return definitions(
        {
            "names here": ", ".join(f"<code>{name}</code>" for name in [subject.name, *aliases]),
            "source": html.escape(scheme.source) + doi,
            **({"parameters": html.escape(_values(subject))} if subject.parameters else {}),
            "kind": f"{'explicit' if scheme.explicit else 'implicit'}, family “{html.escape(scheme.family)}”",
            "order claimed": f"{scheme.order}{damped}",
            "order of its roots": measured,
            "stable": stability(theory),
            **({"stable, as printed": printed} if (printed := printed_limit(subject.name)) else {}),
            "high frequencies": high_frequencies(theory),
            "overshoot": overshoot(theory),
            f"at {STEPS} steps per period": scheme_results.by_the_rule_of_thumb(theory) + ", in linear theory",
            "forces": forces(scheme),
            "memory": f"{theory.linear.memory.item()} vectors of the size of u from step to step",
        }
    )


def _rst(text: str) -> str:
    return f"```{{eval-rst}}\n{text.strip()}\n```"


def _use(subject: Subject) -> str:
    if subject.name not in study.schemes:
        return "`study.run` and `study.assess` take this scheme as an object; `study.register_scheme` gives it a name."
    kind = type(subject.scheme).__name__
    public = f"\n\nOther parameters: {{py:class}}`study.{kind}`." if hasattr(study, kind) else ""
    return (
        "```python\nimport study\n\n"
        'run = dict(dt=0.057, steps=2000, observe=["max_energy_error"])\n'
        f'ds = study.run("softening", "{subject.name}", **run)\n'
        f"print(ds.max_energy_error)\n```{public}"
    )


def scheme_page(subject: Subject, library: Library) -> str:
    """The page of a scheme as Markdown."""
    title = subject.scheme.title
    description = (
        f"{title}: numerical damping, period elongation, stability limit, order, cost and failures of the time "
        "integration scheme; equations, parameters, names in other codes."
    )
    docstring = parsed(type(subject.scheme))
    summary, docstring["Summary"] = _rst("\n".join(docstring["Summary"])), []
    sections = {
        "Equations, parameters and references": _rst(str(docstring)),
        "Names in other codes": names_in_codes(subject.name),
        "Run it": _use(subject),
        "Properties": _facts(subject, library.aliases.get(subject.name, [])),
        "Linear theory: stability, period elongation and numerical damping": linear_theory(subject, library),
        "Measured order": scheme_results.orders(subject, library.data),
        "Energy error at the step sizes of 1996": scheme_results.energy(subject, library.data),
        "Map of stability, and how it fails": scheme_results.maps(subject, library.data),
        "Work, precision and cost": scheme_results.work(subject, library.data),
    }
    parts = [
        f"# {title}: numerical damping, stability, order and cost",
        index_entries([subject.name, *library.aliases.get(subject.name, [])]),
        summary,
        scheme_verdict.verdict(subject, library),
        # sections without runs of the scheme are empty
        *(f"## {heading}\n\n{text}" for heading, text in sections.items() if text),
    ]
    return described(description, "\n\n".join(parts) + "\n")
