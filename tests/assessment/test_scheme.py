"""A user's scheme: its name, the contract of its methods, and its page."""

import re
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest

import study
from reference.experiments.amplitudes import amplitudes
from study.__main__ import main
from study.assessment.arguments import remarks_on_own
from study.assessment.small import order_of_errors
from study.building import Effort, Motion, Phase, acceleration
from study.experiments.atlas import atlas
from study.user_files import load

EXAMPLE = Path(__file__).parents[2] / "examples" / "scheme.py"


@pytest.fixture
def heun(monkeypatch):
    """The scheme of the examples, registered for one test."""
    monkeypatch.setattr(study.schemes, "_entries", dict(study.schemes._entries))
    monkeypatch.setattr(study.schemes, "_names", list(study.schemes._names))
    scheme = load(f"{EXAMPLE}:heun", (study.Scheme,))
    study.register_scheme("heun", scheme)
    return scheme


def test_a_registered_scheme_goes_where_a_name_goes(heun, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert study.schemes["heun"] is heun and "heun" in list(study.schemes)
    exact = amplitudes(["hardening"], {"first": -0.5, "last": 0.0, "count": 3})
    study.io.write(exact.assign_attrs(source=study.io.SOURCE), "results/reference/amplitudes.nc")
    options = {"step_size_over_period": {"first": -2.0, "last": -1.0, "count": 3}, "periods": 5, "tile": 0, "tiles": 1}
    maps = atlas("heun", ["hardening"], **options)
    assert maps.scheme_title.item() == "Heun" and maps.outcome.size == 9


def test_what_linear_theory_contradicts_is_remarked(heun):
    """Attributes that steer extrapolation to longer durations."""
    assert remarks_on_own([heun]) == ["Heun is unstable without damping at every step"]

    class Boastful(type(heun)):
        order, keeps_energy = 4, True

    words = "; ".join(remarks_on_own([Boastful(title="Boastful")]))
    assert "Boastful has the order 2.0 in linear theory, and states 4" in words
    assert "Boastful does not keep the energy in linear theory, and states keeps_energy" in words
    Boastful.keeps_energy = "maybe"  # type: ignore[assignment]
    with pytest.raises(TypeError, match="keeps_energy of Boastful must be True or False, not 'maybe'"):
        study.assess("hardening", Boastful())


def test_the_order_of_errors_is_that_of_the_finest_steps_above_the_uncertainty():
    dt = np.logspace(-3, 0, 61)
    errors = np.maximum(0.1 * dt + dt**2, 2e-4)
    runs = pd.DataFrame({"start": 1.0, "dt": dt, "u": errors})
    failed = runs.assign(start=0.99, u=np.nan)
    order = order_of_errors(pd.concat([runs, failed]), "u", 2.1e-6)
    assert order == pytest.approx(1.0, abs=0.1)
    assert np.isnan(order_of_errors(runs, "u", 1e-3))


@pytest.mark.slow
def test_errors_that_fall_more_slowly_than_stated_are_remarked(heun):
    """A scheme that reads the load one step late has its order in linear theory, which has no load."""

    class Late(type(heun)):
        def increment(self, problem, state, t, dt):
            u, v = state
            slope = acceleration(problem, t, u, v)
            ahead = acceleration(problem, t, u + dt * v, v + dt * slope)
            return Phase(dt * v + dt**2 / 2 * slope, dt / 2 * (slope + ahead)), Effort()

    driven = study.Problem(lambda u: u + 0.3 * u**3, 1.0, damping=0.1, load=lambda t: 0.5 * jnp.cos(1.3 * t))
    schemes = {"heun": heun, "late": Late(title="Late")}
    ds = study.assess(driven, schemes, duration=10.0, allowed_errors=(0.1, 0.01), maps=False)
    assert re.search(r"errors of displacement of Late fall with the order (0\.9|1\.[01]), and it states 2", ds.remarks)
    assert "errors of displacement of Heun" not in ds.remarks


def test_unfit_names_are_refused(heun):
    with pytest.raises(ValueError, match="there is a scheme 'heun' already"):
        study.register_scheme("heun", heun)
    with pytest.raises(ValueError, match="there is a scheme 'newmark' already"):
        study.register_scheme("newmark", heun)
    with pytest.raises(ValueError, match="small letters, digits and underscores, not 'My Scheme'"):
        study.register_scheme("My Scheme", heun)
    with pytest.raises(TypeError, match="is no scheme"):
        study.register_scheme("other", "rk4")


class _Plain(study.OneStep):
    """A valid scheme that has a title, and an empty source and DOI."""

    title: str = "plain"
    source = doi = ""
    order, explicit = 1, True
    family = "Runge-Kutta and conserving"

    def start(self, problem, u0, v0, dt):
        return Phase(u0, v0), Effort()

    def increment(self, problem, state, t, dt):
        return Phase(dt * state.v, dt * acceleration(problem, t, *state)), Effort()


class _NoField(_Plain):
    def increment(self, problem, state, t, dt):
        return Phase(dt * state.w, dt * state.v), Effort()


class _NoNumbers(_Plain):
    def increment(self, problem, state, t, dt):
        return Phase(dt * state.v, -dt * state.u), Effort(None, None)


class _NoEffort(_Plain):
    def step(self, problem, state, t, dt):
        return state


class _OtherState(_Plain):
    def step(self, problem, state, t, dt):
        return Motion(state.u, state.v, state.v), Effort()


class _OtherShape(_Plain):
    def start(self, problem, u0, v0, dt):
        return Phase(u0, np.zeros(2)), Effort()


class _IncrementWithoutEffort(_Plain):
    def increment(self, problem, state, t, dt):
        return Phase(dt * state.v, -dt * state.u)


class _NoIncrement(_Plain):
    def increment(self, problem, state, t, dt):
        pass


class _ArrayIncrement(_Plain):
    def increment(self, problem, state, t, dt):
        return dt * state.v, Effort()


class _Single(_Plain):
    def increment(self, problem, state, t, dt):
        return Phase((dt * state.v).astype("float32"), -dt * state.u), Effort()


class _Branching(_Plain):
    def increment(self, problem, state, t, dt):
        return Phase(dt * state.v if state.v > 0 else state.v, -dt * state.u), Effort()


@pytest.mark.parametrize(
    "scheme, sentence",
    [
        (_IncrementWithoutEffort(), "must return a state and a study.building.Effort, not Phase."),
        (_NoIncrement(), "increment of _NoIncrement must return a state and a study.building.Effort, not NoneType."),
        (_ArrayIncrement(), "increment of _ArrayIncrement must return a named tuple with u and v, not"),
        (_Branching(), "increment of _Branching branches on a number that JAX traces"),
        (_Single(), "increment of _Single must return 'u' in float64, not in float32."),
        (_NoField(), "increment of _NoField raises AttributeError: 'Phase' object has no attribute 'w'"),
        (_NoNumbers(), "increment of _NoNumbers must return a study.building.Effort with iterations and"),
        (_NoEffort(), "step of _NoEffort must return a state and a study.building.Effort, not Phase."),
        (_OtherState(), "step of _OtherState must return a state like that of start"),
        (_OtherShape(), r"start of _OtherShape must return a state with 'v' of shape \(\)."),
    ],
)
def test_a_scheme_that_breaks_the_contract_gets_a_sentence(scheme, sentence):
    with pytest.raises(TypeError, match=sentence) as raised:
        study.run("hardening", scheme, dt=0.01, steps=3)
    assert len(raised.traceback) < 6  # the call above and a few lines of the march; JAX's frames are left out
    with pytest.raises(TypeError, match=sentence):
        study.LinearTheory(scheme, [0.01, 0.02])


class _SecondOrder(_Plain):
    order = "two"  # type: ignore[assignment]


class _NegativeLimit(_Plain):
    stability_limit = -1.0


class _NoTitle(_Plain):
    title: str = " "


class _RaisingOrder(_Plain):
    @property
    def order(self):  # type: ignore[override]
        return 1 // 0


@pytest.mark.parametrize(
    "scheme, sentence",
    [
        (_SecondOrder(), "order of _SecondOrder must be a whole number of at least 1, not 'two'."),
        (_NegativeLimit(), "stability_limit of _NegativeLimit must be a number of at least 0 or None, not -1.0."),
        (_NoTitle(), "title of _NoTitle must be a non-blank string, not ' '."),
        (_RaisingOrder(), "order of _RaisingOrder raises ZeroDivisionError: integer division or modulo by zero"),
    ],
)
def test_the_attributes_of_a_scheme_are_checked(scheme, sentence):
    for call in (
        study.assess_scheme,
        lambda scheme: study.assess("hardening", scheme),
        lambda scheme: study.register_scheme("a", scheme),
    ):
        with pytest.raises(TypeError, match=sentence):
            call(scheme)


def test_the_page_of_a_scheme_has_its_order_and_its_errors(tmp_path, capsys, undrawn):
    """It alone runs ``study assess-scheme``."""
    page = tmp_path / "heun.html"
    words = ["--compare-with", "rk4", "--problems", "hardening", "--output", str(page)]
    main(["assess-scheme", f"{EXAMPLE}:heun", *words])
    assert f"written: {page}" in capsys.readouterr().out
    text = page.read_text()
    assert "<td>Heun</td><td>2</td><td>2.00</td>" in text
    assert "study assess-scheme" in text
    # the answer begins with the scheme that was asked for; an explicit scheme has no radius at infinity
    first = text[: text.index("<h2>Model and reference motion")]
    assert "Heun is unstable without damping at every step" in first and "× the forces of Runge-Kutta" in first
    assert re.search("<td>Heun</td><td>2</td><td>2.00</td><td>0</td><td>–</td>", text)
