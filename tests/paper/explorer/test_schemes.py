"""The schemes and springs in the scripts of the page, compared with the schemes and springs of the study."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import paper.explorer
import study
from reference import closed_form
from study.observer.crossings import Oscillations
from study.scheme.named import SCHEMES_OF_1996

NODE = shutil.which("node") or ""
pytestmark = pytest.mark.skipif(not NODE, reason="needs node (Debian: nodejs)")
FOLDER = Path(paper.explorer.__file__).parent
#: Step sizes by problem, about a twentieth of a period.
STEPS = {"hardening": 0.0075, "softening": 0.057, "double_well": 0.37}


def _computed(expression):
    """The value of an expression in the scripts of the page."""
    scripts = [(FOLDER / f"{name}.js").read_text() for name in ("springs", "schemes", "panels")]
    code = "\n".join([*scripts, f"console.log(JSON.stringify({expression}))"])
    return json.loads(subprocess.run([NODE, "-"], input=code, capture_output=True, text=True, check=True).stdout)


@pytest.fixture(scope="module")
def runs():
    """Runs of the page by problem and scheme: u, v, and the energy above its minimum, relative to the start."""
    starts = {problem: (float(study.problems[problem].u0), dt) for problem, dt in STEPS.items()}
    return _computed(
        f"Object.fromEntries(Object.entries({json.dumps(starts)}).map(([problem, [u0, dt]]) => [problem, "
        "Object.fromEntries(Object.entries(SCHEMES).map(([name, scheme]) => "
        "[name, march(SPRINGS[problem], scheme, u0, dt, 100)]))]))"
    )


@pytest.mark.slow
@pytest.mark.parametrize("problem", STEPS)
def test_a_scheme_marches_as_in_the_study(runs, problem):
    """A formula in the JavaScript of the explorer that differs from that of the study."""
    # all schemes are compared on the softening spring, and two schemes on the other springs
    schemes = runs[problem] if problem == "softening" else ("average_acceleration", "energy_momentum")
    rest = study.OutcomeObserver.of(problem)
    for name in schemes:
        run = runs[problem][name]
        exact = study.run(problem, name, dt=STEPS[problem], steps=100, observe=["trajectory", rest])
        for quantity in ("u", "v"):
            apart = abs(np.array(run[quantity]) - exact[quantity].values).max()
            assert apart < 1e-9 * abs(exact[quantity]).max(), name
        error = abs(np.array(run["height"]) - 1).max()
        assert error == pytest.approx(exact.max_height_error.item(), abs=1e-11), name


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "newmark_dissipative", "energy_momentum"])
def test_a_step_at_which_newton_fails_is_taken_as_in_the_study(scheme):
    run = study.run("softening", scheme, dt=1.1, steps=20)
    assert run.newton_restarts > 0
    displacements = _computed(f"march(SPRINGS.softening, SCHEMES.{scheme}, 4, 1.1, 20).u")
    assert abs(np.array(displacements) - run.u.values).max() < 1e-9 * abs(run.u).max()


def test_a_run_ends_where_it_leaves_all_bounds():
    run = study.run("hardening", "central_difference", dt=0.1, steps=100, on_failure="ignore")
    assert len(_computed("march(SPRINGS.hardening, SCHEMES.central_difference, 1.5, 0.1, 100).u")) == run.failed_at_step


def test_the_schemes_of_the_short_study_are_there(runs):
    assert set(runs["softening"]) >= {*SCHEMES_OF_1996, "bathe", "energy_momentum"}


def test_springs_and_their_periods_are_exact():
    starts = {"hardening": [0.05, 1.5, 47.0], "softening": [0.13, 4.0, 126.0], "double_well": [0.016, 0.5, 1.2, 15.8]}
    periods = _computed(
        f"Object.entries({json.dumps(starts)}).map(([name, u0]) => u0.map((u) => periodOf(SPRINGS[name], u)))"
    )
    for (problem, u0), computed in zip(starts.items(), periods, strict=True):
        exact = [float(closed_form.period(study.problems[problem], start, 20)) for start in u0]
        np.testing.assert_allclose(computed, exact, rtol=1e-9)


def test_a_balance_is_found_however_far_off_the_guess():
    residuals = _computed(
        "[0.01, 0.3, 10].flatMap((c) => [-500, -4, 0.1, 30].map((u) => {"
        "const a = balance(SPRINGS.softening, u, c, 100); return a + SPRINGS.softening.force(u + c * a)}))"
    )
    assert len(residuals) == 12 and all(abs(residual) < 1e-9 for residual in residuals)


@pytest.mark.slow
def test_the_period_of_a_run_is_that_of_its_passages():
    run = study.run("softening", "rk4", dt=0.06, steps=1000, observe=[Oscillations(0.0)])
    period = _computed("meanPeriod(march(SPRINGS.softening, SCHEMES.rk4, 4, 0.06, 1000), 0)")
    assert period == pytest.approx(run.mean_period.item(), rel=1e-6)
