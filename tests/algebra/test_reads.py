"""What functions read, in every way in which a function can read a value."""

import contextvars
import dataclasses
import functools
import types
from collections import deque, namedtuple
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax
from numpy import random
from scipy import io as scipy_io
from scipy.io import loadmat

import study
from study.algebra.reads import reads_of
from study.mechanics.frequencies import frequencies
from study.mechanics.loads import excited

k = 1.0
pairs: dict[str, Any] = {"k": 1.0, "inner": {"k": 1.0}}
listed = [1.0]
array = np.ones(2)
module: Any = types.ModuleType("parameters")
module.k = 1.0
jax_array = jnp.asarray(1.0)
space = types.SimpleNamespace(k=1.0)
Pair = namedtuple("Pair", "k other")
pair = Pair(1.0, 0)


@dataclasses.dataclass
class Parameters:
    """Parameters of a spring."""

    k: float = 1.0
    load: float = 1.0


parameters = Parameters()


class Spring:
    """A spring in plain Python, which reads an attribute, a class attribute, a property and a static method."""

    class_stiffness = 1.0

    def __init__(self):
        self.k = 1.0

    def __call__(self, u):
        return self.k * u

    def by_class(self, u):
        return self.class_stiffness * u

    @property
    def stiffness(self):
        return k

    def by_property(self, u):
        return self.stiffness * u


class Slotted:
    """A spring whose attribute is a slot."""

    __slots__ = ("k",)
    k: float

    def __call__(self, u):
        return self.k * u


class Module(eqx.Module):
    """A spring with an array, which is an argument of a program, and a global, which is not."""

    scale: np.ndarray

    def __call__(self, u):
        return self.scale * k * u


spring, slotted = Spring(), Slotted()
slotted.k = 1.0


class Number(float):
    """A number of a type of its own."""


class Special(np.ndarray):
    """An array of a type of its own."""


class Soft:
    """A model with the same attributes as another one."""

    def __init__(self):
        self.k = 1.0

    def force(self, u):
        return self.k * u


class Hard(Soft):
    """A model of another class."""

    def force(self, u):
        return 2 * self.k * u


class Meta(type):
    """A metaclass with an attribute."""

    k = 1.0


class OfMeta(metaclass=Meta):
    """A class with the attribute of its metaclass."""


class Looked:
    """An object that looks its attributes up in a dictionary."""

    def __getattr__(self, name):
        return pairs[name]


number, special, masked = Number(1.0), np.ones(2).view(Special), np.ma.ones(2)
queue, model, models = deque([1.0]), Soft(), [Soft(), Hard()]
polynomial: Any = np.polynomial.Polynomial([0.0, 0.0, 0.5])
kinds = [np.polynomial.Polynomial, np.polynomial.Chebyshev]
looked = [Looked()]


def helper(u):
    return k * u


def assign(name, value):
    globals()[name] = value


def closure():
    value = 1.0

    def change(new):
        nonlocal value
        value = new

    return (lambda u: value * u), change


in_closure, change_closure = closure()


def with_default(u, k=1.0):
    return k * u


def with_keyword(u, *, k=1.0):
    return k * u


def with_attribute(u):
    return with_attribute.k * u  # type: ignore[attr-defined]


with_attribute.k = 1.0  # type: ignore[attr-defined]


@jax.custom_jvp
def custom(u):
    return k * u


custom.defjvp(lambda primals, tangents: (custom(*primals), k * tangents[0]))


def comprehended(u):
    return sum([k * u for _ in range(2)])


def defined_within(u):
    def inner(u):
        return k * u

    return inner(u)


def set_global(new):
    assign("k", new)


#: A function, and a function that changes a value which it reads.
WAYS = {
    "global": (lambda u: k * u, set_global),
    "helper": (lambda u: helper(u), set_global),
    "helper that is replaced": (lambda u: helper(u), lambda new: assign("helper", lambda u: new * u)),
    "comprehension": (comprehended, set_global),
    "function within": (defined_within, set_global),
    "closure": (in_closure, change_closure),
    "default": (with_default, lambda new: setattr(with_default, "__defaults__", (new,))),
    "keyword": (with_keyword, lambda new: setattr(with_keyword, "__kwdefaults__", {"k": new})),
    "attribute of the function": (with_attribute, lambda new: setattr(with_attribute, "k", new)),
    "callable object": (spring, lambda new: setattr(spring, "k", new)),
    "bound method": (spring.by_class, lambda new: setattr(Spring, "class_stiffness", new)),
    "property": (spring.by_property, set_global),
    "slot": (slotted, lambda new: setattr(slotted, "k", new)),
    "module of Equinox": (Module(np.ones(())), set_global),
    "dictionary": (lambda u: pairs["k"] * u, lambda new: pairs.update(k=new)),
    "nested dictionary": (lambda u: pairs["inner"]["k"] * u, lambda new: pairs["inner"].update(k=new)),
    "list": (lambda u: listed[0] * u, lambda new: listed.__setitem__(0, new)),
    "array": (lambda u: array[0] * u, lambda new: array.__setitem__(0, new)),
    "module": (lambda u: module.k * u, lambda new: setattr(module, "k", new)),
    "namespace": (lambda u: space.k * u, lambda new: setattr(space, "k", new)),
    "dataclass": (lambda u: parameters.k * u, lambda new: setattr(parameters, "k", new)),
    "named tuple": (lambda u: pair.k * u, lambda new: assign("pair", Pair(new, 0))),
    "partial": (functools.partial(lambda of, u: of["k"] * u, pairs), lambda new: pairs.update(k=new)),
    "array of JAX": (lambda u: jax_array * u, lambda new: assign("jax_array", jnp.asarray(new))),
    "compiled": (jax.jit(helper), set_global),
    "compiled by Equinox": (eqx.filter_jit(helper), set_global),
    "gradient": (jax.grad(helper), set_global),
    "vectorised": (jax.vmap(helper), set_global),
    "checkpoint": (jax.checkpoint(helper), set_global),
    "own derivative": (custom, set_global),
    "number of another type": (lambda u: number * u, lambda new: assign("number", Number(new))),
    "array of another type": (lambda u: special[0] * u, lambda new: special.__setitem__(0, new)),
    "masked array": (lambda u: masked[0] * u, lambda new: masked.__setitem__(0, new)),
    "queue": (lambda u: queue[0] * u, lambda new: queue.__setitem__(0, new)),
    "class of an object": (lambda u: model.force(u), lambda new: assign("model", models[int(new) - 1])),
    "class of an object of NumPy": (
        lambda u: polynomial.coef[2] * u,
        lambda new: assign("polynomial", kinds[int(new) - 1]([0, 0, 0.5])),
    ),
    "metaclass": (lambda u: OfMeta.k * u, lambda new: setattr(Meta, "k", new)),
    "attribute that is looked up": (lambda u: looked[0].k * u, lambda new: pairs.update(k=new)),
    "partial of JAX": (jax.tree_util.Partial(helper), set_global),
}


@pytest.mark.parametrize("way", WAYS)
def test_reads_follow_every_value(way, request):
    function, change = WAYS[way]
    kept = helper
    request.addfinalizer(lambda: (change(1.0), assign("helper", kept)))
    change(1.0)
    before, again = reads_of(function), reads_of(function)
    change(2.0)
    after = reads_of(function)
    assert before.certain and after.certain
    assert before == again != after


def from_file(u):
    return np.loadtxt(module.file) * u


def by_name(u):
    return getattr(spring, "k") * u  # noqa: B009


def by_import(u):
    import os

    return float(os.environ["STIFFNESS"]) * u


#: Functions whose reads the search does not see.
HIDDEN = {
    "file": (from_file, lambda new: np.savetxt(module.file, [new])),
    "computed name": (by_name, lambda new: setattr(spring, "k", new)),
    "import": (by_import, None),
}


@pytest.mark.parametrize("way", HIDDEN)
def test_what_the_search_does_not_see_is_traced(way, tmp_path, monkeypatch):
    function, change = HIDDEN[way]
    monkeypatch.setattr(module, "file", tmp_path / "k.txt", raising=False)
    change = change or (lambda new: monkeypatch.setenv("STIFFNESS", str(new)))
    change(1.0)
    assert reads_of(function) != reads_of(function)
    problem = study.Problem(function, u0=1.0)
    before, again = problem.reads, problem.reads
    change(2.0)
    assert before == again != problem.reads
    change(1.0)


def test_an_attribute_with_the_name_of_a_function_that_reads_a_file_is_seen():
    assert reads_of(lambda u: jnp.sin(parameters.load) * u).certain
    assert not reads_of(lambda u: jnp.load("file") * u).certain


def test_modules_of_numpy_and_scipy_that_read_files_or_have_a_state_are_seen():
    assert not reads_of(lambda u: loadmat("file")["k"] * u).certain
    assert not reads_of(lambda u: scipy_io.loadmat("file")["k"] * u).certain
    assert not reads_of(lambda u: random.default_rng().normal() * u).certain


def test_lanes_read_a_variable_of_the_context():
    """Lanes run in threads, whose contexts are copies of that of the call."""
    variable = contextvars.ContextVar("k", default=1.0)
    problem = study.Problem(lambda u: variable.get() * u, u0=[1.0, 1.0])
    variable.set(4.0)
    end = study.Quantity(lambda u: u[0], name="end", reduce="final")
    ends = study.run(problem, "rk4", u0=np.ones((2, 2)), dt=0.01, steps=100, observe=end).end.values
    np.testing.assert_allclose(ends, np.cos(2.0), rtol=1e-7)


def test_arrays_that_are_arguments_are_not_read():
    first, second = Module(np.ones(())), Module(np.full((), 2.0))
    assert reads_of(first) == reads_of(second)
    assert reads_of(lambda u: first(u)) != reads_of(lambda u: second(u))


def test_equal_numbers_of_other_types_or_signs_differ():
    distinct = {
        reads_of(functools.partial(helper, value)) for value in (0.0, -0.0, 0, False, np.float64(0), np.float32(0))
    }
    assert len(distinct) == 6


def test_a_value_that_refers_to_itself_ends_the_search():
    pairs["self"] = pairs
    try:
        assert reads_of(lambda u: pairs["k"] * u).certain
    finally:
        del pairs["self"]


#: Functions inside a force that JAX traces once and keeps by their identity.
def branch(u):
    return k * u


def kept_by_jax(u):
    branched = lax.cond(u > 0, branch, branch, u)
    scanned = lax.scan(lambda c, _: (c, None), branched, length=1)[0]
    return jax.checkpoint(branch)(u) / 3 + jax.jit(branch)(u) / 3 + scanned / 3


@pytest.mark.slow
def test_programs_follow_what_functions_read(request):
    """Every kind of run, and what is computed for it, uses the value that holds when it is called.

    It alone sees a program of an ensemble, a family, a controlled or a pure run that keeps an old value.
    """
    request.addfinalizer(lambda: set_global(1.0))
    set_global(1.0)
    damping = study.Rayleigh(a=0.0, b=0.01)
    problem = study.Problem(kept_by_jax, u0=1.0, damping=damping, load=lambda t: k * jnp.ones_like(t))
    options = {"dt": 0.01, "steps": 100, "observe": study.Quantity(lambda u: k * u, name="end", reduce="final")}

    def family(mass):
        return study.Problem(lambda u: k * u, u0=1.0, mass=mass)

    for stiffness in (1.0, 4.0, 1.0):
        set_global(stiffness)
        half = 0.005 * stiffness  # of Rayleigh's damping
        omega = np.sqrt(stiffness - half**2)
        # about the displacement k/k under the load; the motion starts there
        np.testing.assert_allclose(study.run(problem, "rk4", **options).end, stiffness, rtol=1e-12)
        decay = np.exp(-half) * (np.cos(omega) + half / omega * np.sin(omega))
        exact = stiffness * (1 + decay)
        ends = [
            study.run(problem, "rk4", u0=2.0, **options).end,
            *study.run(problem, "rk4", u0=[2.0, 2.0], **options).end.values,
            study.run(problem, "rk4", u0=2.0, tolerance=1e-9, duration=1.0, observe=options["observe"]).end,
            study.final_state(problem, "rk4", u0=2.0, **options)["end"],
        ]
        np.testing.assert_allclose(np.array(ends, float), exact, rtol=1e-7)
        end = study.run(family, "rk4", over={"mass": [1.0]}, **options).end.values
        np.testing.assert_allclose(end, stiffness * np.cos(np.sqrt(stiffness)), rtol=1e-8)
        np.testing.assert_allclose(frequencies(problem), np.sqrt(stiffness))


def test_a_problem_in_which_nothing_changed_is_not_examined_again():
    problem = study.Problem(lambda u: k * u, u0=1.0, load=jnp.sin)
    assert problem.current() is problem
    scaled = excited(problem, 2.0)
    assert scaled.current() is scaled


class Hidden:
    """Functions that read an attribute by its name."""

    factor = 4.0

    def force(self, u):
        return getattr(self, "factor") * u  # noqa: B009

    def load(self, t):
        return getattr(self, "factor") * jnp.ones_like(t)  # noqa: B009


@pytest.mark.parametrize("steps", [{"dt": 0.01, "steps": 10}, {"tolerance": 1e-3, "duration": 0.1}])
def test_reads_that_the_search_cannot_see_are_found_by_tracing_without_compiling_again(steps, compiled):
    """With the factor k as stiffness and load, u = 1 + cos(√k t) from u(0) = 2."""
    hidden = Hidden()
    problem = study.Problem(hidden.force, u0=2.0, load=hidden.load)
    observe = study.Quantity(lambda u: u, name="end_u", reduce="final")
    ends = [study.run(problem, "rk4", observe=observe, **steps) for _ in range(2)]
    count = len(compiled)
    ends.append(study.run(problem, "rk4", observe=observe, **steps))
    assert len(compiled) == count
    hidden.factor = 100.0
    ends.append(study.run(problem, "rk4", observe=observe, **steps))
    for end, k in zip(ends, (4.0, 4.0, 4.0, 100.0), strict=True):
        assert float(end.end_u) == pytest.approx(1 + np.cos(np.sqrt(k) * 0.1), abs=2e-3)
