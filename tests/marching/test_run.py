"""``study.run`` as a user calls it: the labels of its results, and a sentence for every mistake."""

from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study


class _Nameless(study.Reduction):
    """A reduction whose author has not named its variables."""

    def start(self, problem, state):
        return state.u

    def update(self, carried, problem, state, t, effort):
        return state.u

    def result(self, carried, problem, state):
        return {"mine": carried}


class _Renamed(_Nameless):
    """A reduction that returns another variable than it names."""

    variables = {"last": {"long_name": "last displacement", "units": "m"}}


def test_the_contract_of_the_labels():
    ds = study.run("hardening", "rk4", dt=0.0075, steps=20, observe=["trajectory", "max_energy_error"])
    assert ds.u.dims == ("t",) and ds.v.attrs["units"] == "s-1"
    assert ds.t.attrs["long_name"] == "elapsed time"
    assert ds.max_energy_error.attrs["units"] == "1"
    for variable in ds.variables.values():
        assert variable.attrs["long_name"]


def test_vectors_have_components():
    problem = study.Problem(lambda u: u, u0=[1.0, 2.0], v0=[0.0, 0.0])
    ds = study.run(problem, "average_acceleration", dt=0.1, steps=5)
    assert ds.u.dims == ("t", "component")
    lanes = study.run(problem, "average_acceleration", dt=0.1, steps=5, u0=[[1.0, 2.0], [3.0, 4.0], [0.0, 1.0]])
    assert lanes.u.dims == ("lane", "t", "component") and lanes.sizes["lane"] == 3
    np.testing.assert_allclose(lanes.u[0], ds.u, rtol=1e-12)


@pytest.mark.parametrize("transform", [jax.jit, jax.grad])
def test_a_run_that_jax_traces_names_the_function_for_it(transform):
    def end(stiffness):
        return study.run(study.Problem(lambda u: stiffness * u, 1.0), "rk4", dt=0.1, steps=3).u.values[-1]

    with pytest.raises(TypeError, match="not values traced by jit, grad or vmap: use study.final_state there"):
        transform(end)(2.0)


def test_a_force_that_is_not_finite_is_the_likely_cause():
    falling, below = (study.Problem(lambda u: jnp.log(u) + 1, u0=u0) for u0 in (1.0, -1.0))
    with pytest.raises(RuntimeError, match="grows without bound, or the force is not finite along it"):
        study.run(falling, "rk4", dt=0.1, steps=300, on_failure="raise")
    with pytest.raises(RuntimeError, match="Likely cause: the force is not finite at the start."):
        study.run(below, "rk4", dt=0.1, steps=3, on_failure="raise")


@pytest.mark.parametrize(
    "how",
    [{"dt": 0.02, "steps": 20}, {"dt": np.array([1e-9, 0.02]), "steps": 20}, {"tolerance": 1e-2, "duration": 1.0}],
)
def test_a_derivative_of_the_force_that_is_not_finite_is_the_likely_cause(how):
    """arcsin(clip(u)) has the derivative ∞ · 0 from u = 1 on, which the motion reaches after a few steps."""
    clipped = study.Problem(lambda u: u + jnp.arcsin(jnp.clip(u, -1, 1)), u0=0.9, v0=1.0)
    with pytest.raises(RuntimeError, match="Likely cause: the derivative of the force is not finite there, although"):
        study.run(clipped, "average_acceleration", observe=[], on_failure="raise", **how)


def test_a_motion_that_grows_by_itself_is_not_blamed_on_the_step_alone():
    falling = study.Problem(lambda u: -u, u0=1.0)
    with pytest.raises(RuntimeError, match="at the start no mode oscillates, and the motion may also grow by itself"):
        study.run(falling, "central_difference", dt=0.1, steps=300, on_failure="raise")


def test_problems_and_schemes_of_the_user():
    problem = study.Problem(force=lambda u: 4 * u, u0=1.0, potential=lambda u: 2 * u**2, title="mine")
    ds = study.run(problem, study.Newmark(beta=1 / 6, gamma=0.5), dt=0.01, steps=100, observe=["max_energy_error"])
    assert ds.max_energy_error < 0.001


@pytest.mark.parametrize(
    "arguments, error, sentence",
    [
        ({"problem": "hardning"}, KeyError, "there is no problem 'hardning'; did you mean 'hardening'?"),
        ({"scheme": "houbold"}, KeyError, "there is no scheme 'houbold'; did you mean 'houbolt'?"),
        ({"scheme": "zzz"}, KeyError, "there is no scheme 'zzz'; known are average_acceleration, "),
        ({"observe": ["trajectry"]}, KeyError, "there is no observer 'trajectry'; did you mean 'trajectory'?"),
        ({"problem": 3}, TypeError, "3 is no problem: give a name or a study.Problem."),
        ({"scheme": None}, TypeError, "None is no scheme: give a name or a study.Scheme."),
        ({"dt": 0.0}, ValueError, "dt must be finite and greater than zero, not 0.0."),
        ({"dt": -1.0}, ValueError, "dt must be finite and greater than zero, not -1.0."),
        ({"dt": float("nan")}, ValueError, "dt must be finite and greater than zero, not nan."),
        ({"dt": [0.1, 0.0]}, ValueError, "dt must be finite and greater than zero"),
        ({"dt": [[0.1]]}, ValueError, "dt must be a number or an array of shape (lanes,)"),
        ({"dt": "fast"}, ValueError, "dt must be a real number or an array of real numbers, not 'fast'."),
        ({"steps": 0}, ValueError, "steps must be a whole number of at least 1, not 0."),
        ({"steps": 1.5}, ValueError, "steps must be a whole number of at least 1, not 1.5."),
        ({"steps": 10**20}, ValueError, "steps must be a whole number of at least 1 and at most 23"),
        ({"dt": True}, ValueError, "dt must be a real number or an array of real numbers, not True."),
        ({"observe": study.Quantity}, TypeError, "Quantity'> is no observer: give a name or a study.Observer"),
        ({"observe": _Nameless()}, TypeError, "_Nameless lacks the class variable 'variables'"),
        ({"observe": _Renamed()}, ValueError, "_Renamed.result returns mine, which is none of its variables: last"),
        ({"observe": None}, TypeError, "observe must be a list of observers; known are trajectory"),
        ({"steps": True}, ValueError, "steps must be a whole number of at least 1, not True."),
        ({"steps": [10, 20]}, ValueError, "'u' is recorded along time, which needs one number of steps for all lanes"),
        ({"steps": [10, 0]}, ValueError, "steps must be whole numbers of at least 1, not [10  0]."),
        ({"steps": [[10]]}, ValueError, "steps must be a whole number or of shape (lanes,), not of shape (1, 1)."),
        ({"every": 3}, ValueError, "every must divide the number of steps; 3 does not divide 10."),
        ({"u0": [[1.0]]}, ValueError, "u0 must have the shape () of the problem"),
        ({"u0": float("inf")}, ValueError, "u0 must be finite"),
        ({"u0": "high"}, ValueError, "u0 must be a real number or an array of real numbers, not 'high'."),
        ({"u0": []}, ValueError, "an ensemble needs at least one lane"),
        ({"u0": [1.0, 2.0], "dt": [0.1, 0.1, 0.1]}, ValueError,
         "the lanes of an ensemble need arrays of one length, not dt 3, u0 2."),
        ({"dt": "0.1"}, ValueError, "dt must be a real number or an array of real numbers, not '0.1'."),
        ({"u0": [[1.0], [1, 2]]}, ValueError, "u0 must be a real number or an array of real numbers, not [[1.0], ["),
        ({"scheme": "newmark_d"}, KeyError, "there is no scheme 'newmark_d'; did you mean 'newmark_dissipative'?"),
        ({"scheme": "hht_a"}, KeyError, "did you mean 'hht_alpha_1996' or 'hht_alpha'?"),
        ({"observe": ["trajectory", study.Quantity(lambda u: u, "u")]}, ValueError,
         "two variables of the result would have the name 'u'; give one of them another name."),
        ({"observe": study.Quantity(lambda u: u, "status")}, ValueError, "would have the name 'status'"),
        ({"observe": study.Quantity(lambda u: u[0], "first")}, ValueError,
         "the quantity 'first' cannot be computed for 'hardening spring': IndexError"),
        ({"problem": "fpu_chain", "observe": study.Quantity(lambda a: a[99], "far")}, ValueError,
         "the quantity 'far' takes an entry that 'Fermi-Pasta-Ulam chain' does not have: index 99 is out of bounds"),
        ({"on_failure": "stop"}, ValueError, "on_failure must be one of 'warn', 'raise', 'ignore', not 'stop'."),
        ({"steps": 10**12}, ValueError, "1000000000001 samples of 'u', 'v' need 29802 GiB, and this machine has "),
        ({"steps": 10**9, "u0": [1.0] * 1000}, ValueError, "samples of 'u', 'v' need 29802"),
        ({"problem": "fpu_chain", "observe": [study.OutcomeObserver(rest=0.0)]}, ValueError, "more than one unknown"),
        ({"problem": "duffing_chaotic", "observe": study.OutcomeObserver(rest=0.0)}, ValueError, "damping or a load"),
        ({"problem": study.Problem(lambda u: u, u0=1.0, title="bare"), "observe": ["max_energy_error"]}, ValueError,
         "max_energy_error of 'bare' needs Problem(potential=...), which it was made without."),
    ],
)  # fmt: skip
def test_mistakes_get_a_sentence(arguments, error, sentence):
    arguments = {"problem": "hardening", "scheme": "rk4", "dt": 0.01, "steps": 10} | arguments
    with pytest.raises(error) as caught:
        study.run(**arguments)
    assert sentence in str(caught.value)


def test_a_failed_run_says_so():
    arguments = {"dt": 0.5, "steps": 100, "observe": ["max_energy_error"]}
    sentence = r"'Central difference' failed on 'hardening spring' at step \d+, t = .*, with dt = 0.5: the displacement"
    with pytest.warns(study.RunFailedWarning, match=sentence):
        study.run("hardening", "central_difference", **arguments)
    without_root = study.Problem(lambda u: -u * u, u0=1.0)
    with pytest.raises(RuntimeError, match="'Average acceleration' failed .*: Newton's iteration found no balance"):
        study.run(without_root, "average_acceleration", dt=2.0, steps=10, on_failure="raise")
    with pytest.warns(study.RunFailedWarning, match="1 of 2 runs failed, the first of them, lane 1: "):
        study.run("hardening", "central_difference", **arguments | {"dt": [0.001, 0.5]})


def test_a_result_says_what_made_it():
    ds = study.run("hardening", study.Newmark(beta=0.3, gamma=0.6), dt=0.01, steps=5, v0=0.5, observe=["energy_drift"])
    made_by = {"dt": 0.01, "steps": 5, "u0": 1.5, "v0": 0.5, "scheme_parameters": "Newmark(beta=0.3, gamma=0.6)"}
    assert made_by.items() <= ds.attrs.items() and ds.version == study.__version__
    lanes = study.run("hardening", "rk4", dt=[0.01, 0.02], steps=5, v0=[0.0, 0.5])
    assert lanes.dt.values.tolist() == [0.01, 0.02] and lanes.v0.values.tolist() == [0.0, 0.5]
    assert lanes.attrs["u0"] == 1.5 and "dt" not in lanes.attrs


def test_initial_velocities_are_lanes():
    problem = study.Problem(lambda u: u, u0=[1.0, 2.0])
    lanes = study.run(problem, "rk4", dt=0.01, steps=5, v0=[[0.0, 0.0], [1.0, -1.0]])
    alone = study.run(problem, "rk4", dt=0.01, steps=5, v0=[1.0, -1.0])
    np.testing.assert_allclose(lanes.u[1], alone.u, rtol=1e-14)
    assert lanes.v0.dims == ("lane", "component")


def test_names_that_people_type_find_their_scheme():
    for typed, name in {
        "newmark": "average_acceleration",
        "HHT": "hht_alpha",
        "HHT-alpha": "hht_alpha",
        "central difference": "central_difference",
        "Trapezoidal": "average_acceleration",
    }.items():
        assert study.schemes[typed] is study.schemes[name]


@pytest.mark.slow
def test_threads_agree():
    def last(name):
        return study.run("hardening", name, dt=0.01, steps=5).u.values[-1]

    names = ["rk4", "central_difference", "average_acceleration"]
    alone = [last(name) for name in names]
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(last, names * 60)) == alone * 60
