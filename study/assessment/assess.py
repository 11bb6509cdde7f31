"""``study.assess``: the scheme and the step that a problem needs for an allowed error."""

import math
import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import replace

import numpy as np
import xarray as xr

from study.algebra.deadline import until
from study.algebra.reads import reading
from study.algebra.scalars import is_number
from study.assessment import failures, large, oscillation, steps
from study.assessment.arguments import checked_errors, chosen_schemes, refusal, remarks_on_own, wanted_quantities
from study.assessment.certified import KINKS, cases_of, certified, undeclared
from study.assessment.dataset import Assessed, dataset_of
from study.assessment.deadline import Budget, OutOfTime, within
from study.assessment.errors import DEFAULT
from study.assessment.periods import (
    has_a_period,
    highest_frequency_along,
    length_of,
    model_of,
    remark_on_record,
    slowest_period,
)
from study.assessment.program import assess_program, narrowed
from study.assessment.progress import Progress
from study.assessment.scales import lack_of_energy, measured, remarks_on_scales, with_reference
from study.assessment.search import ENERGY, sentence_on_starts
from study.assessment.steps import StepSearch
from study.assessment.tolerances import ToleranceSearch, variables_of
from study.control.controllers import Controller
from study.control.named import controllers
from study.io import processor
from study.marching.arguments import resolve
from study.mechanics.definition import Problem
from study.mechanics.loads import excited, record_of
from study.observer.motion import Quantity
from study.problem.named import problems
from study.program.definition import Program
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name
from study.settings import cores
from study.sizes import CERTAIN


def assess(
    problem: str | Problem | Program,
    schemes: str | Scheme | Mapping[str, Scheme] | Iterable[str | Scheme] | None = None,
    *,
    duration: float | None = None,
    quantities: Mapping[str, Quantity] | None = None,
    allowed_errors: Sequence[float] = (0.1, 0.01, 0.001),
    maps: bool = True,
    controller: str | Controller | None = None,
    seconds: float = math.inf,
) -> xr.Dataset:
    """Find the scheme and the step that a problem needs for an allowed error, by runs against a certified reference.

    Two independent solvers give the reference and its uncertainty. Every scheme runs at random steps, octave by octave,
    from a quarter of the slowest period of small motions down to a twentieth of the largest step that keeps the
    smallest allowed error, or to a limit on the number of steps. An octave has up to 128 runs, the octave below a
    recommended step up to 500; both have fewer if the runs have many steps. All steps tried up to ``largest_step_size``
    keep an error, and ``largest_step_size`` itself keeps it with a margin for the scatter of the errors below it. The
    recommended step is the largest step with two digits up to ``largest_step_size``. If the load is a record with equal
    spacing of the samples, the step is an integer fraction or multiple of this spacing. The recommended step must keep
    the error with the given initial values and load, and with values one percent smaller and larger. If none of n
    random finer steps exceeds the error, at most 3/n of all finer steps do, with 95 % confidence. Every recommended
    step was run; neither the step nor its error is interpolated.

    A run ends with the last step that fits into the duration. Quantities along time are compared with the reference at
    every step.

    A problem of more than 1,000 unknowns, or with an unknown without mass, is assessed like a :class:`study.Program`:
    the given schemes and two witnesses run with halved steps until two schemes agree. The result on which they agree is
    the reference; its uncertainty follows from their difference. The witnesses are ``rk4`` and ``nystrom4``, or
    ``esdirk4`` and ``generalized_alpha`` if an unknown has no mass. Only a few random finer steps confirm a recommended
    step.

    Parameters
    ----------
    problem
        Name in ``study.problems``, your own :class:`study.Problem`, or a :class:`study.Program`, which defines its own
        schemes, duration and quantities.
    schemes
        Names in ``study.schemes``, your own :class:`study.Scheme`, or a mapping from names to schemes; ten common
        schemes by default, or all schemes of a program. Schemes that cannot step the problem are left out.
    duration
        Simulated time of the runs in seconds. The default for a free undamped oscillator of one unknown is ten of its
        periods; other problems need a duration.
    quantities
        Quantities whose errors are measured: a mapping from names to :class:`study.Quantity`. The default quantities
        are displacement and velocity along time; the acceleration, unless an unknown has no mass or the force has a
        history; the balance of energies, if the problem has a potential and its force cannot dissipate; and period,
        phase and amplitude of a free undamped oscillator of one unknown. A warning is given if the balance of energies
        is left out because the energy at the start is too small to scale its errors. For a problem of more than 1,000
        unknowns, or with an unknown without mass, the default is displacement and velocity of at most 256 unknowns,
        all with a mass.
    allowed_errors
        Allowed errors, as fractions of the value to which the errors of a quantity are relative: its largest value
        along time, or the peak, the final value or the root mean square itself (``scale`` of :class:`study.Quantity`).
        The error of the balance of energies is a fraction of the energy put in, those of period and phase are fractions
        of the period, and that of the amplitude is the loss per oscillation.
    maps
        Whether to make a map of the failures of each scheme over step size and excitation, the multiple of initial
        values and load. Without maps, ``stable_step_size`` is that of the given start and load alone. A program, or a
        problem that is assessed like one, has no map.
    controller
        Name in ``study.controllers``, or your own :class:`study.Controller`. Each scheme that does not need equal steps
        then also runs with controlled steps at random tolerances; the result has the tolerance that keeps each error,
        and its cost. A program, or a problem that is assessed like one, cannot have a controller.
    seconds
        Wall time in s after which no work begins. The results so far are returned. The verdict is ``out_of_time`` where
        the runs do not suffice, schemes without any run are left out with a warning, and there are neither maps nor
        times. Runs and the two solvers of the reference are given up at the next of their pauses, which are about a
        second apart. A compilation that has begun ends: five to ten seconds for a reference, and one to five for a
        scheme. No scheme is compiled if the time is shorter than earlier schemes took. A run of a program ends, and so
        does the first run of a problem that is assessed like one, which compiles.

    Returns
    -------
    xarray.Dataset
        Over ``scheme``, ``step_size`` and ``quantity``: ``error``. Over ``scheme`` and ``step_size``: ``status``,
        ``energy_imbalance`` and ``newton_iterations_per_step``. Where a step was not tried, ``status`` is ``not_tried``
        and the other variables are NaN. Over ``scheme``, ``quantity`` and ``allowed_error``: ``verdict``,
        ``largest_step_size`` and ``recommended_step_size``; ``recommended_error``, ``seconds``, ``seconds_spread`` and
        ``force_evaluations`` of the run with the recommended step; ``steps_tried``, the number of steps tried from a
        twentieth of the recommended step up to it, and ``largest_error``, their largest error. Over ``quantity``:
        ``reference_uncertainty``, and the coordinates ``relative_to``, the value to which errors are relative,
        ``scaled_from``, the time from which on a longer run does not change it, and ``quantity_units``. Over
        ``quantity`` and ``component``: ``reference_value``, the reduced value of the reference or its largest value
        along time, ``reference_value_uncertainty`` in the same unit, and ``reference_time``, at which the value is
        reached. Over ``quantity`` and ``reference_t``, parts of the duration: ``reference_low`` and ``reference_high``,
        the lowest and highest value of the reference in the part, of the component with the largest value.
        ``highest_frequency`` is the highest circular frequency of small motions about points of the reference.

        With a controller: ``tolerance``, the largest round tolerance (1, 2 or 5 times a power of ten) that keeps the
        error, as all smaller tolerances tried do, down to a hundredth of it; ``tolerance_error``, ``controlled_steps``
        and ``controlled_force_evaluations`` of the run with this tolerance.

        For a program: ``reason`` and ``seconds_per_run`` of each run; ``repeated``, the relative difference between a
        run of each scheme and its repetition. Variables that have no value for a program are NaN.

        The attributes have the names of the solvers or schemes that gave the reference. They also have the ``model`` in
        two lines (unknowns, periods of small motions, duration; damping ratios and record), the ``remarks``, the time
        up to which the reference holds, the versions and the processor. :func:`study.recommend` and
        :func:`study.report` take this dataset.

    Raises
    ------
    KeyError
        If there is no such problem, scheme or controller.
    TypeError, ValueError
        If an argument is invalid, the problem does not move, no reference is accurate enough, or the time ends before
        there is a reference and a run.

    Examples
    --------
    >>> import study
    >>> ds = study.assess("softening", ["average_acceleration", "rk4"])  # doctest: +SKIP
    >>> study.recommend(ds, allowed_error=0.01, quantity="displacement")  # doctest: +SKIP
    """
    if not (is_number(seconds) and seconds >= 0):
        raise ValueError(f"seconds must be a time in s, zero or more, not {seconds!r}.")
    if isinstance(problem, Program):
        if quantities is not None or duration is not None or controller is not None:
            raise ValueError(
                "a program has its own quantities, duration and steps; leave quantities, duration and controller out."
            )
        selection = narrowed(problem, schemes)  # type: ignore[arg-type]
        return assess_program(
            selection, checked_errors(allowed_errors), seconds, Progress(len(selection.schemes)).report
        )
    # scaled by one, so that it shares a compiled program with the same problem scaled by 0.99 and 1.01
    equation = excited(resolve(problem, problems, Problem), 1.0, displaced=True)
    chosen, allowed = chosen_schemes(schemes), checked_errors(allowed_errors)
    selected = wanted_quantities(quantities, equation)
    with_energy = quantities is None and equation.potential is not None and not equation.dissipative
    length = requested = length_of(equation, duration)
    for name, quantity in selected.items():
        if reason := refusal(replace(quantity, name=name), equation):
            raise ValueError(reason)
    control = None if controller is None else resolve(controller, controllers, Controller)  # type: ignore[type-abstract]
    fit = {name: scheme for name, scheme in chosen.items() if not scheme.refusal(equation)}
    if not fit:
        raise ValueError(next(iter(chosen.values())).refusal(equation))
    own_schemes = {name: scheme for name, scheme in fit.items() if scheme not in schemes_by_name.values()}
    asked = "; ".join(own_schemes)
    spacing, progress, budget = steps.spacing(equation, length), Progress(len(fit)), Budget(time.monotonic() + seconds)
    model = model_of(equation, length, spacing)
    progress.say(f"{equation.title}: {'; '.join(model)}")
    remarks = remark_on_record(equation, spacing) + remarks_on_own(own_schemes.values())
    if np.size(equation.u0) > large.MOST or equation.massless:
        if control is not None:
            raise ValueError(
                f"controlled steps are assessed for up to {large.MOST:,} unknowns, all with a mass; leave controller "
                "out."
            )
        if any(quantity.reduce for quantity in selected.values()):
            remarks.append(
                "reduced quantities are compared with those of the whole duration, also if the last step of a run ends "
                "before it"
            )
        program = large.program_of(equation, fit, length, quantities, spacing)
        ds = assess_program(program, allowed, seconds, progress.report)
        ds.attrs |= {"model": "\n".join(model), "asked_for": asked} | record_of(equation.load)
        ds.attrs["remarks"] = "; ".join([*remarks, *([ds.attrs["remarks"]] if ds.attrs["remarks"] else [])])
        if quantities is None and np.size(equation.u0) > large.SHOWN:
            compared = f"{large.SHOWN} of {np.size(equation.u0):,} unknowns"
            ds.attrs["starts"] += f" Errors were compared at {compared}; others may have larger ones."
        return ds
    slowest = slowest_period(equation) or length / steps.COARSEST
    coarsest = slowest / steps.COARSEST
    if length / coarsest > steps.MOST_STEPS:
        raise ValueError(
            f"duration must be at most {steps.MOST_STEPS * coarsest:g} s, which is {steps.MOST_STEPS:,} steps at "
            f"{steps.COARSEST} per period of the slowest small motion of '{equation.title}', not {length:g} s."
        )
    progress.report(f"solving for a reference of '{equation.title}'")
    unfinished = (
        f"the reference of '{equation.title}' was not found in {seconds:g} s; allow more seconds, larger errors or a "
        f"shorter duration{', or ' + KINKS if undeclared(equation.load) else ''}: {model[0]}."
    )
    # functions inside the force are traced again too if what they read has changed
    with within(budget.end, unfinished), reading(equation.reads):
        reference = certified(equation, length, selected, allowed[-1], coarsest, periodic=quantities is None)
    length = reference.horizon
    if length < requested:
        warnings.warn(
            f"the references of '{equation.title}' agree up to t = {length:.4g} of {requested:g} s: errors are "
            "measured up to this time only.",
            RuntimeWarning,
            stacklevel=2,
        )
    remarks += remarks_on_scales(reference.targets)
    with within(budget.end, unfinished), reading(equation.reads):
        cases = cases_of(equation, reference, selected, allowed[-1])
    if with_energy and (lack := lack_of_energy(equation, reference.solution)):
        warnings.warn(lack, RuntimeWarning, stacklevel=2)
        with_energy = False
    uncertainty = reference.uncertainty | ({ENERGY: 0.0} if with_energy else {})
    names = [*selected, *([ENERGY] if with_energy else []), *(oscillation.QUANTITIES if reference.oscillation else [])]
    highest = highest_frequency_along(equation, reference.solution)
    finest = steps.finest_step(length, slowest, highest, np.size(equation.u0))
    limits = [(name, error) for name in names for error in allowed if error >= CERTAIN * uncertainty[name]]

    def assessment_of(scheme: Scheme) -> Assessed | None:
        if not budget.allows("compiling"):
            return None
        with until(budget.end):
            runs = StepSearch(scheme, cases, length, min(coarsest, length), finest, with_energy, budget.end)
            runs.search(limits, lambda top: progress.report(f"{scheme.title}: steps of {top / 2:.3g} to {top:.3g} s"))
        if not len(runs.runs):
            return None
        budget.took("compiling", runs.compiling)
        verdicts = {limit: runs.verdict(*limit) for limit in limits}
        recommended = np.unique([verdict.recommended for verdict in verdicts.values() if verdict.recommended > 0])
        if maps and not runs.late and budget.allows("map"):
            with budget.work("map"):
                map_or_limit = failures.map_of(equation, scheme, length, coarsest, recommended)
        else:
            map_or_limit = failures.limit_of(equation, scheme, length, coarsest)
        if control is None or scheme.needs_equal_steps:
            return Assessed(runs.runs, verdicts, map_or_limit)
        with_control = ToleranceSearch(scheme, control, cases, length, with_energy, budget.end)
        along = [limit for limit in limits if limit[0] in selected or limit[0] == ENERGY]
        with_control.late = not budget.allows("compiling control")
        with until(budget.end):
            with_control.search(along, lambda top: progress.report(f"{scheme.title}: tolerances up to {top:.3g}"))
        budget.took("compiling control", with_control.compiling)
        tolerances = {limit: with_control.verdict(*limit) for limit in along}
        return Assessed(runs.runs, verdicts, map_or_limit, tolerances)

    results = _assess_each(
        fit, assessment_of, progress, f"no scheme was run on '{equation.title}' in {seconds:g} s; allow more seconds."
    )
    ds = dataset_of(equation, results, {name: chosen[name] for name in results}, names, allowed, budget.end)
    if control is not None:
        ds = ds.merge(variables_of({name: result.tolerances for name, result in results.items()}, names, allowed))
        ds.attrs["controller"] = control.title
    ds["reference_uncertainty"] = (
        "quantity",
        [uncertainty[name] for name in names],
        {"long_name": "relative difference of the reference from its witness", "units": "1"},
    )
    ds["highest_frequency"] = (
        (),
        highest,
        {"long_name": "highest circular frequency of small motions about points of the motion", "units": "s-1"},
    )
    ds = with_reference(ds, measured(reference, with_energy, equation.conservative))
    titles = {name: quantity.long_name or name for name, quantity in (quantities or DEFAULT).items()}
    titles |= {ENERGY: "balance of energies, relative to the energy that was put in"} | oscillation.TITLES
    described = {"long_name": "description of the quantity"}
    ds = ds.assign_coords(quantity_title=("quantity", [titles[name] for name in names], described))
    ds.attrs |= {
        "model": "\n".join(model),
        "remarks": "; ".join(remarks),
        "asked_for": asked,
        "reference": reference.route.name,
        "witness": reference.witness.name,
        "reference_tolerance": reference.rtol,
        "starts": sentence_on_starts(cases),
        "duration": length,
        "duration_requested": requested,
        "free_vibration": int(
            equation.conservative
            and not equation.kinked
            and (reference.oscillation is not None or has_a_period(equation, length))
        ),
        "problem": equation.title,
        "command": f"study.assess(problem, {list(chosen)}, duration={requested:.17g}, "
        f"allowed_errors={allowed}, maps={maps}" + (", quantities=quantities)" if quantities else ")"),
        "processor": processor(),
        "not_fit": "; ".join(str(chosen[name].refusal(equation)) for name in chosen if name not in fit),
        **({} if spacing is None else {"spacing": spacing}),
        **record_of(equation.load),
    }
    return ds


def _assess_each(
    schemes: dict[str, Scheme], function: Callable[[Scheme], Assessed | None], progress: Progress, late: str
) -> dict[str, Assessed]:
    """Results by name of the scheme; after Ctrl-C, or for lack of time, results of the finished schemes only.

    Raises
    ------
    OutOfTime
        If there was no time for any scheme; ``late`` is the message.
    """
    with progress.bar, ThreadPoolExecutor(min(cores(), len(schemes))) as pool:
        waiting = {name: pool.submit(function, scheme) for name, scheme in schemes.items()}
        try:
            for future in as_completed(waiting.values()):
                future.result()
                progress.update()
        except KeyboardInterrupt:
            progress.stopped = True
            pool.shutdown(cancel_futures=True)
    done = {
        name: future.result() for name, future in waiting.items() if not future.cancelled() and not future.exception()
    }
    results = {name: result for name, result in done.items() if result is not None}
    if not done:
        raise KeyboardInterrupt
    if not results:
        raise OutOfTime(late)
    if missing := [name for name in schemes if name not in results]:
        cause = "interrupted" if progress.stopped else "out of time"
        warnings.warn(f"{cause}: {', '.join(missing)} were not assessed.", RuntimeWarning, stacklevel=3)
    return results
