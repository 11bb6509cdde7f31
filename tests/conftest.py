"""Strict settings of JAX for every test, and fixtures that several folders use."""

import functools
import gc
from collections.abc import Iterable
from contextlib import nullcontext
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.algebra.jit import short_runs
from study.problem import trusses
from tests import browser as browsers

PROJECT = Path(__file__).parent.parent
# as in the pipeline's jobs: imported objects are never freed, so the garbage collector can skip them
gc.freeze()
# a search among all programs takes a fifth of a second, and by Python's own thresholds every tenth test starts one
gc.set_threshold(50_000, 20, 50)
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")


#: Folder of the tests that run Snakemake.
PIPELINE = PROJECT / "tests" / "pipeline"
#: Folders of tests in the order in which they run, by the lines of code that they mirror per second: 90 to 10.
ORDER = (
    "runs",
    "program",
    "experiments",
    "observer",
    "mechanics",
    "algebra",
    "assessment",
    "scheme",
    "problem",
    "marching",
    "control",
    "reference",
    "analysis",
    "docs",
    "paper",
)
#: Folders and files whose runs have so few steps that programs without optimisation are faster.
SHORT = [
    *(PROJECT / "tests" / room for room in ("scheme", "observer")),
    *(PROJECT / "tests" / "marching" / f"test_{name}.py" for name in ("components", "family", "kernel")),
]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark tests that run Snakemake or a browser, and sort all tests.

    Tests of the pipeline are first, because at the end one worker would wait for the other.
    """
    for item in items:
        if item.path.parent == PIPELINE or "browser" in item.fixturenames:
            item.add_marker("pipeline")
    rank = {PROJECT / "tests" / room: place for place, room in enumerate(ORDER)}
    items.sort(
        key=lambda item: (
            item.get_closest_marker("pipeline") is None,
            min((rank[folder] for folder in item.path.parents if folder in rank), default=len(ORDER)),
        )
    )


def pytest_runtest_teardown(item, nextitem):
    """Clear compiled programs between folders: other folders rarely use them, and thousands slow all tests down."""
    if nextitem is None or nextitem.path.parent != item.path.parent:
        jax.clear_caches()


@pytest.fixture(autouse=True, scope="module")
def _compilation(request):
    with short_runs() if any(map(request.path.is_relative_to, SHORT)) else nullcontext():
        yield


@pytest.fixture(params=list(study.schemes))
def scheme_name(request) -> str:
    """The name of every scheme in turn."""
    return request.param


@pytest.fixture
def scheme(scheme_name) -> study.Scheme:
    """Every scheme in turn."""
    return study.schemes[scheme_name]


#: Name of the first scheme of every class, by class.
KINDS = {type(scheme): name for name, scheme in reversed(list(study.schemes.items()))}


@pytest.fixture(params=KINDS.values())
def kind(request) -> str:
    """The name of one scheme of every class in turn, for tests in which parameters do not matter."""
    return request.param


def _state_of(name: str) -> str:
    """Type, shapes and precision of the state that a scheme carries from step to step."""
    spring = study.problems["hardening"]
    state, _ = jax.eval_shape(lambda: study.schemes[name].start(spring, np.float64(1.0), np.float64(0.0), 0.01))
    return f"{jax.tree.structure(state)} {jax.tree.leaves(state)}"


#: Name of one scheme for every kind of state of the schemes in ``KINDS``: an implicit one, if there is one.
STATES = {_state_of(name): name for name in sorted(KINDS.values(), key=lambda name: not study.schemes[name].explicit)}


@pytest.fixture(params=STATES.values())
def state_kind(request) -> str:
    """The names in ``STATES`` in turn, for tests in which formulas do not matter."""
    return request.param


def _sampled(names: Iterable[str]) -> list:
    """Parameters with some names, of which ``make test`` runs those in ``STATES``."""
    return [pytest.param(name, marks=() if name in STATES.values() else pytest.mark.exhaustive) for name in names]


@pytest.fixture(params=_sampled(study.schemes))
def sampled_scheme(request) -> str:
    """The name of every scheme in turn, for tests in which formulas matter little."""
    return request.param


@pytest.fixture(params=_sampled(KINDS.values()))
def sampled_kind(request) -> str:
    """The name of one scheme of every class in turn, for tests in which formulas matter little."""
    return request.param


class _Pull(eqx.Module):
    """The load 0.3 cos 2t on the last of n unknowns."""

    n: int = eqx.field(static=True)

    def __call__(self, t):
        return jnp.zeros(self.n).at[-1].set(0.3 * jnp.cos(2 * t))


def _elongations(u):
    return jnp.concatenate([u[:1], jnp.diff(u)])


def _linear(strain):
    return strain * strain / 2


def _hardening(strain):
    return strain * strain / 2 + strain**4 / 4


@functools.cache
def _damped_chain(structure=None, linear=False) -> study.Problem:
    n = 5
    return study.Problem(
        potential=study.StrainEnergy(_elongations, _linear if linear else _hardening),
        u0=np.linspace(0.2, 1, n),
        v0=np.linspace(0.5, -0.5, n),
        mass=np.array([1.0, 2.0, 1.0, 1.0, 1.5]),
        damping=study.Rayleigh(a=0.1, b=0.02),
        load=_Pull(n),
        tangent=structure,
    )


@pytest.fixture(scope="session")
def damped_chain():
    """Function that returns the problem of five masses in a row, with stretched springs, damping and a load.

    Its arguments are the structure of the tangent and whether the springs are linear.
    """
    return _damped_chain


@pytest.fixture
def small_truss(monkeypatch):
    """Trusses of four cells."""
    monkeypatch.setattr(trusses, "TRUSS", (4, 1))


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A browser that reaches no network."""
    driver = browsers.start(tmp_path_factory.mktemp("browser"))
    yield driver
    driver.quit()


@pytest.fixture
def compiled():
    """Durations of all compilations by XLA so far."""
    durations: list[str] = []

    def listen(event, duration, **_):
        durations.extend([event] if event.endswith("backend_compile_duration") else [])

    jax.monitoring.register_event_duration_secs_listener(listen)
    yield durations
    jax.monitoring.unregister_event_duration_listener(listen)
