"""Claims about the cost of step control, and about the step control of published codes, decided by our runs."""

from paper.claims.ledger import PRACTICE, Finding, by_name, claim, when
from paper.measures.step_control import ALLOWED, CLEARLY, STIFF, ratio_of_forces, with_control
from paper.published import PROBLEMS
from paper.terms import ALMOST, REASONABLE
from paper.wording import listed, number
from study.sizes import fewest
from study.words import span

AVERAGE = "average_acceleration"

#: Smallest and largest ratio of the error to (tolerance × number of steps) on the linear oscillator, as a comment in
#: the tests of OrdinaryDiffEqNewmark states them.
SCIML_RATIOS = 0.2, 3.0


@claim(
    "adaptive",
    "Controlled steps need fewer forces than equal ones for an error of one percent.",
    "forces with controlled over forces with equal steps, average acceleration",
    whose=PRACTICE,
    requires={"control_cost.schemes": [AVERAGE]},
)
def control_saves_forces(control_cost):
    ratio = ratio_of_forces(control_cost, ALLOWED).sel(scheme=AVERAGE)
    saves = bool((ratio < 1).all())
    reason = when(not saves, "equal steps need as few or fewer on some problems")
    return Finding(listed(by_name(ratio), control_cost, ".2f", "not reached"), saves, reason)


@claim(
    "adaptive",
    "With intermittent contact, step control pays off for methods of higher order.",
    "forces with controlled over forces with equal steps, for one percent, on the bouncing mass",
    whose=PRACTICE,
    requires={"control_cost.problems": ["bouncing"], "control_cost.schemes": ["rk4"]},
)
def control_pays_at_contact(control_cost):
    higher = control_cost.scheme[control_cost.order > 2]
    ratio = ratio_of_forces(control_cost, ALLOWED).sel(problem="bouncing", scheme=higher)
    pays = bool((ratio < 1 / CLEARLY).all())
    reason = when(not pays, "a method of higher order needs as many forces or does not reach this error")
    return Finding(listed(by_name(ratio), control_cost, ".2f", "not reached"), pays, reason)


@claim(
    "adaptive",
    "A stiff mode that does not matter for the accuracy does not reduce the controlled steps.",
    "forces with controlled over forces with equal steps, for one percent, average acceleration on stiff and soft "
    "springs",
    whose=PRACTICE,
    requires={"control_cost.problems": STIFF, "control_cost.schemes": [AVERAGE]},
)
def a_stiff_mode_is_ignored(control_cost):
    ratio = ratio_of_forces(control_cost, ALLOWED).sel(problem=STIFF[0], scheme=AVERAGE).item()
    ignored = ratio < CLEARLY
    return Finding(
        number(ratio, ".2g", "not reached"),
        bool(ignored),
        when(not ignored, "the estimate includes the acceleration of that mode"),
    )


@claim(
    "adaptive",
    "A general solver that controls its step and order needs fewer forces than average acceleration.",
    "forces of CVODE's Adams methods over those of average acceleration with equal steps, for one percent",
    whose=PRACTICE,
    requires={"solver_cost.solvers": ["cvode_adams"], "control_cost.schemes": [AVERAGE]},
)
def a_general_solver_needs_fewer(control_cost, solver_cost):
    equal = with_control(control_cost, ALLOWED)[1].sel(scheme=AVERAGE)
    solver = fewest(solver_cost.sampled_error, solver_cost.force_evaluations, ALLOWED, "tolerance").sel(
        solver="cvode_adams"
    )
    ratio = solver / equal
    fewer = bool((ratio < 1).all())
    reason = when(not fewer, "it needs as many or more on some problems")
    return Finding(listed(by_name(ratio), control_cost, ".2f", "not reached"), fewer, reason)


@claim(
    "adaptive",
    "A half-increment residual of a tenth of the force gives high accuracy.",
    "energy error in percent over the run and steps in a period, HHT-α with the controller of Abaqus",
    whose="Hibbitt and Karlsson (1979)",
    requires={"control_of_codes.problems": PROBLEMS},
)
def a_tenth_of_the_force_is_accurate(control_of_codes):
    tight = control_of_codes.sel({"code": "Abaqus", "class": "tight"})
    error = 100 * tight.max_energy_error
    accurate = bool((error < REASONABLE).all())
    energy, steps = (listed(by_name(values), control_of_codes) for values in (error, tight.steps_per_period))
    return Finding(f"{energy}; steps {steps}", accurate, when(not accurate, "it allows very few steps in a period"))


@claim(
    "adaptive",
    "The number of Newton iterations shows how accurate a step is.",
    "energy error in percent with the controller of OpenSees, for the two looser settings of its number of iterations",
    whose="McKenna (1997)",
    requires={"control_of_codes.problems": PROBLEMS},
)
def iterations_tell_the_error(control_of_codes):
    loose = control_of_codes.max_energy_error.sel({"code": "OpenSees", "class": ["middle", "loose"]})
    loose = 100 * loose.max("class")
    shows = bool((loose < REASONABLE).all())
    return Finding(listed(by_name(loose), control_of_codes), shows, when(not shows, "iterations do not show the error"))


@claim(
    "adaptive",
    "Halving the step during a run excites oscillations of average acceleration.",
    "ratio of the largest energy error with the step halved in the middle to the error with equal steps",
    whose="MOOSE",
    requires={"control_of_codes.problems": PROBLEMS},
)
def a_halved_step_disturbs(control_of_codes):
    largest = control_of_codes.halved_energy_error.max("steps_at_first")
    disturbs = bool((largest > ALMOST).any())
    reason = when(not disturbs, "the energy error remains that of the larger step")
    return Finding(listed(by_name(largest), control_of_codes, ".3f"), disturbs, reason)


@claim(
    "adaptive",
    "On the linear oscillator the largest error, over tolerance times number of steps, is between 0.2 and 3.",
    "largest error of displacement or velocity over the tolerance times the number of steps, average acceleration with "
    "the estimator of 1991",
    whose="SciML",
)
def errors_are_tolerances_times_steps(control_of_codes):
    ratio = control_of_codes.error_in_tolerances
    inside = bool(((ratio >= SCIML_RATIOS[0]) & (ratio <= SCIML_RATIOS[1])).all())
    reason = when(not inside, "our controller chooses other steps")
    return Finding(span(ratio.values, ".2f"), inside, reason)
