"""``study.assess``: the scheme and the step that a problem needs for an allowed error."""

import math
from collections.abc import Iterable, Mapping, Sequence

import xarray as xr

from study.algebra.scalars import is_number
from study.assessment.arguments import checked_errors, question_of
from study.assessment.large import assess_large
from study.assessment.program import assess_program, narrowed
from study.assessment.progress import Progress
from study.assessment.small import assess_small
from study.control.controllers import Controller
from study.mechanics.definition import Problem
from study.observer.motion import Quantity
from study.program.definition import Program
from study.scheme.base import Scheme


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
    allowed = checked_errors(allowed_errors)
    if isinstance(problem, Program):
        if quantities is not None or duration is not None or controller is not None:
            raise ValueError(
                "a program has its own quantities, duration and steps; leave quantities, duration and controller out."
            )
        program = narrowed(problem, schemes)  # type: ignore[arg-type]
        return assess_program(program, allowed, seconds, Progress(len(program.schemes)).report)
    question = question_of(problem, schemes, duration, quantities, allowed, maps, controller, seconds)
    progress = Progress(len(question.fit))
    progress.say(f"{question.problem.title}: {'; '.join(question.model)}")
    return (assess_large if question.is_large else assess_small)(question, progress)
