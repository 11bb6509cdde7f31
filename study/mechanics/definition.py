"""Problems M ü + C u̇ + K u + p = f(t) with u(0) and u̇(0); p depends on u, and may depend on u̇, a history and t."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import Matrix, PositionsLike, Scalar, ScalarLike, Vector, VectorLike, as_float64
from study.algebra.counting import count
from study.algebra.hashing import hashable
from study.algebra.matrices import add, times
from study.algebra.reads import Reads, reading, reads_of, reads_of_program
from study.algebra.sparse import is_sparse
from study.mechanics import checks, function_checks, tangent
from study.mechanics.forms import entries_of, form_of_tangent, stored
from study.mechanics.ground import GroundLoad, GroundMotion
from study.mechanics.internal_force import (
    as_history,
    check_signature,
    depends_on_last,
    may_have_kinks,
    number_of_arguments,
    place_of_time,
)
from study.mechanics.terms import Rayleigh, gradient, rayleigh_matrix

#: Arguments of a problem that are numbers, arrays of numbers or matrices.
NUMBERS = ("u0", "v0", *checks.MATRICES, "positions", "influence")

#: Arguments of a problem that are functions.
FUNCTIONS = ("force", "potential", "load")

#: Times at which the form of the tangent of a force that takes the time is found.
PROBED_TIMES = (0.0, 0.3183, 1.4142, 27.183)


class Problem(eqx.Module):
    r"""A second-order initial value problem, Xie (1996), equation (1).

    .. math::

        M \ddot u + C \dot u + p(u) = f(t), \quad u(0) = u_0, \quad \dot u(0) = v_0

    A problem needs a force (or a potential, or a stiffness) and ``u0``. All else is optional, and an absent term costs
    nothing: it is not in the compiled loop.

    Force, potential and load may read globals, closures, attributes, dictionaries and arrays. A run uses the values
    that these have when the run is called. Numbers and arrays given to the problem itself are copied.

    Parameters
    ----------
    force
        Internal force p(u), written with ``jax.numpy`` and of the shape of ``u``. Without it, the force is the
        gradient of the potential, if there is one. A function of two arguments is p(u, u̇). A function of three
        arguments also takes a history, and returns the force and the new history: see ``history``. A further argument
        named ``t`` is the time, as in ``force(u, t)``; such a force has no potential. If the force branches, as contact
        does, Newton's iteration brackets the root or shortens its corrections.
    u0, v0
        Displacement and velocity at t = 0, both of shape () or (n,). The default velocity is zero.
    history
        Memory of a force, at rest: any arrays of real numbers, in any containers. By default the attribute ``history``
        of the force, as in :mod:`study.materials`. ``force(u, u̇, history)`` returns the force and the new history
        after a motion to u and u̇ from the end of the last step, where ``history`` was committed. Newton's iterations
        and the stages of a scheme start from the committed history; the end of the step commits the new one. Called
        again with the same u and u̇ and the new history, the function must return the same force and history.
    stiffness
        Constant stiffness K, with which the internal force is K u + p: a number, a diagonal (n,), or a symmetric
        matrix (n, n), dense, of :mod:`scipy.sparse`, or a ``BCOO`` of :mod:`jax.experimental.sparse`. The entries of a
        ``BCOO`` may depend on parameters that JAX differentiates, or differ between the problems of an ensemble. For
        the tangent, only p is differentiated. With a stiffness and no force the problem is linear: every balance of
        forces takes one linear solve. With sparse matrices p should act on few unknowns or couple neighbours. The
        factorisation of a sparse matrix is suited to its pattern, and is reused while the matrix stays the same.
    potential
        V(u), a scalar with p = ∂V/∂u, or a :class:`study.StrainEnergy`; V(u, history) for a force with a history. For a
        force that dissipates, V is the stored energy. Only energies and conserving schemes need a potential.
    mass
        M: a number, a diagonal (n,) or a symmetric matrix (n, n), dense or sparse; the identity by default. An unknown
        without mass makes M singular. Implicit schemes that are stable at infinite frequency can step such a problem.
        ``u0`` and ``v0`` should satisfy the equation of motion of this unknown; otherwise schemes without numerical
        damping make it oscillate from step to step.
    damping
        C: a number, a diagonal, a matrix (dense or sparse; symmetric if the tangent is matrix-free) or
        :class:`study.Rayleigh`; zero by default.
    load
        f(t), of the shape of ``u``. An attribute ``kinks`` may hold the times at which it or its slope jumps. The steps
        of references and of runs with a tolerance end at these times. Without it, the load is scanned for them.
    ground, influence
        Motion of the ground, and the displacement ι (of the shape of ``u``) of the unknowns for a unit displacement of
        the ground, by default one for each unknown. The unknowns are then relative to the ground, whose acceleration a
        adds the load −M ι a(t).
    tangent
        Form of ∂p/∂u with several unknowns: ``diagonal``, ``tridiagonal``, ``dense``, ``matrix_free`` (for symmetric
        tangents), the half bandwidth as a number, or a sparse matrix with an entry wherever ∂p/∂u has one. By default
        it is dense for at most four unknowns, and a band or dense for up to a thousand, as the tangent near u₀, at zero
        and far away requires, where gaps have closed. With more unknowns or sparse matrices it is diagonal, tridiagonal
        or sparse. Declare the form if the force couples other unknowns elsewhere: without their entries Newton's
        iteration is slow or fails, and derivatives are NaN. Bands are eliminated without pivoting between distant
        rows; declare ``dense`` for a saddle point, which needs such pivoting. Number the joints of a mesh along its
        short side: a narrow band is much faster. For sparse matrices the order of the unknowns does not matter.
    positions
        Positions of the masses at u = 0, of shape (points, directions). u holds the displacements of the points, one
        point after the other. Only observers of momentum need positions.
    title
        Name of the problem in figures and datasets.

    Raises
    ------
    ValueError, TypeError
        If shapes do not fit each other, a number is not finite, a matrix is not symmetric, the force is not the
        gradient of the potential near u₀, where alone it is compared, the tangent does not fit its declared form, or an
        argument is not a function.
    """

    force: Callable = None  # type: ignore[assignment]
    u0: VectorLike = None
    v0: VectorLike = None
    history: Any = eqx.field(default=None, kw_only=True)
    potential: Callable | None = eqx.field(default=None, kw_only=True)
    stiffness: Matrix = eqx.field(default=None, kw_only=True)
    mass: Matrix = eqx.field(default=None, kw_only=True)
    damping: Matrix = eqx.field(default=None, kw_only=True)
    load: Callable | None = eqx.field(default=None, kw_only=True)
    ground: GroundMotion | None = eqx.field(default=None, kw_only=True)
    influence: VectorLike = eqx.field(default=None, kw_only=True)
    tangent: Any = eqx.field(default=None, kw_only=True, static=True)
    positions: PositionsLike = eqx.field(default=None, kw_only=True)
    title: str = eqx.field(default="unnamed problem", kw_only=True, static=True)
    #: The history at rest; it stays the same when a step commits another history.
    _at_rest: Any = eqx.field(default=None, kw_only=True, repr=False)
    #: Rayleigh damping as given, from which C follows.
    _rayleigh: Rayleigh | None = eqx.field(default=None, kw_only=True, repr=False)
    #: What the functions read when all that follows from them was found.
    _examined_reads: Reads = eqx.field(init=False, repr=False, static=True)
    #: The time at which a force that takes it is evaluated; without it such a force cannot be evaluated.
    _time: Any = eqx.field(default=None, init=False, repr=False)
    #: Whether M is singular.
    massless: bool = eqx.field(init=False, static=True)
    #: Number of arguments of the force except the time, and the place of the time among all of them, if it takes it.
    arguments: int = eqx.field(init=False, static=True)
    place_of_time: int | None = eqx.field(init=False, static=True)
    #: Whether the force depends on the velocity.
    takes_velocity: bool = eqx.field(init=False, static=True)
    #: Whether the slope of the force may jump.
    kinked: bool = eqx.field(init=False, static=True)
    #: Whether a Newton iteration that fails starts again with a safeguard; see :mod:`study.mechanics.balance`.
    safeguarded: bool = eqx.field(default=False, init=False, static=True)

    @jax.enable_x64(True)  # the checks compare with round-off of double precision, even if runs use single precision
    def __post_init__(self):
        for name in NUMBERS:
            setattr(self, name, checks.numbers_or_matrix(name, getattr(self, name)))
        for name in FUNCTIONS:
            setattr(self, name, hashable(getattr(self, name)))
        if self.v0 is None and self.u0 is not None:
            self.v0 = np.zeros(np.shape(self.u0))
        checks.check_shapes(self)
        for name in NUMBERS:
            checks.check_finite(name, getattr(self, name))

        if self.force is None and self.potential is not None:
            self.force = eqx.Partial(gradient, self.potential)
        if self.ground is not None:
            self.load = self._with(self.ground)
        self._count_arguments()
        if self.linear:
            self.potential = _nothing
        checks.check_symmetry("mass", self.mass)
        checks.check_symmetry("stiffness", self.stiffness)
        # conjugate gradients need a symmetric matrix; other solvers also accept gyroscopic damping
        if isinstance(self.tangent, str) and self.tangent == "matrix_free":
            checks.check_symmetry("damping", self.damping)
        self.massless = checks.is_singular(self.mass)
        if isinstance(self.damping, Rayleigh):
            self._rayleigh = self.damping

        # a problem is complete before JAX traces it to find what it reads
        self._examined_reads, self.kinked, self.takes_velocity = Reads.unique(), False, False
        self._examined_reads = self.reads
        with reading(self._examined_reads):
            self._examine_functions()
            force = None if self.linear else self._coupling()
            sparse_ones = [
                entries for name in checks.MATRICES if (entries := entries_of(getattr(self, name), name)) is not None
            ]
            self.tangent = form_of_tangent(force, self.u0, self.tangent, self.massless, sparse_ones, self.title)
            for name in checks.MATRICES:
                setattr(self, name, stored(getattr(self, name), self.tangent))
            self._find_damping()

    def _examine_functions(self) -> None:
        """Check the functions, and set what follows from what they do."""
        function_checks.check_functions(self)
        initial = self.at_time(0.0)
        kinked = not self.linear and may_have_kinks(initial.varying_force, self.u0, self.v0)
        takes_velocity = self.arguments > 1 and depends_on_last(initial.varying_force, self.u0, self.v0)
        object.__setattr__(self, "kinked", kinked)
        object.__setattr__(self, "takes_velocity", takes_velocity)
        derived = isinstance(self.force, eqx.Partial) and self.force.func is gradient
        if derived and kinked:
            function_checks.check_derived_force(self)
        if isinstance(self.u0, jax.core.Tracer):  # traced numbers cannot be compared
            return
        with suppress(*function_checks.NOT_TRACEABLE):
            if self.history is not None:
                function_checks.check_history(initial._from, self.u0, self.v0, self.history, self.title)
            if self.linear or self.potential is None or derived:
                return
            if self.history is None:
                function_checks.check_gradient(self._without_velocity(), self.potential, self.u0, self.title)
            else:
                function_checks.check_stored_energy(self.force, self.potential, self.u0, self.history, self.title)

    def _find_damping(self) -> None:
        """Set the matrix C of Rayleigh damping, from the tangent at u = 0."""
        if self._rayleigh is not None:
            checks.check_rayleigh(self._rayleigh, self.title)
            object.__setattr__(self, "damping", self._rayleigh_matrix(self._rayleigh))

    @property
    def reads(self) -> Reads:
        """What the functions read now."""
        reads = reads_of(self.force, self.load, self.potential, self.history)
        return reads if reads.certain else self._traced_reads() or reads

    def _traced_reads(self) -> Reads | None:
        """What the traced functions hold now; None if JAX cannot trace them."""

        def values(problem, t, u, v):
            load = None if problem.load is None else problem.load(t)
            return (
                load,
                None if problem.linear else problem.at_time(t).varying_force(u, v),
                problem.potential and problem.stored_energy(u),
            )

        start = [jnp.asarray(x) for x in (0.0, self.u0, self.v0)]  # JAX compiles this conversion once for all reads
        with suppress(Exception), reading(Reads.unique()):  # a user's function may raise anything; the checks report it
            return reads_of_program(eqx.filter_make_jaxpr(values)(self, *start)[0])
        return None

    def examined(self) -> "Problem":
        """The same problem, marked as one whose functions do as those from which it was made."""
        return self._changed("_examined_reads", self.reads)

    def current(self) -> "Problem":
        """The problem with what follows from its functions as they are now: they may read values that have changed."""
        reads = self.reads
        if reads == self._examined_reads:
            return self
        copy = self._changed("_examined_reads", reads)
        with reading(reads):
            copy._examine_functions()
            copy._find_damping()
        return copy

    def _count_arguments(self) -> None:
        """Set the number of arguments of the force and its history at rest, and check that they fit each other."""
        function_checks.check_arguments(self.force, self.potential, self.load, self.title)
        self.arguments = number_of_arguments(self.force) if callable(self.force) else 1
        self.place_of_time = place_of_time(self.force) if callable(self.force) else None
        if self.history is None:
            self.history = getattr(self.force, "history", None)
        if self.history is not None:
            self.history = self._at_rest = as_history(self.history, self.title)
        check_signature(self.force, self.arguments, self.history, self.title)

    def _without_velocity(self) -> Callable:
        """The force p(u, 0) as a function of u."""
        return self.force if not self.dissipative else lambda u: self.varying_force(u, jnp.zeros_like(u))

    def _coupling(self) -> Callable:
        """A function of u whose derivative has an entry wherever ∂p/∂u or ∂p/∂u̇ has one."""
        if not self.dissipative:
            return self.force
        problems = [self.at_time(t) for t in (PROBED_TIMES if self.takes_time else (0.0,))]
        return lambda u: sum(problem.varying_force(u, self.v0 + (u - self.u0)) for problem in problems)

    def _with(self, ground: GroundMotion) -> GroundLoad:
        """The sum of the load f(t) and the load of the moving ground."""
        checks.check_ground(ground, self.load, self.title)
        if self.influence is None:
            self.influence = np.ones(np.shape(self.u0))
        inertia = self.mass @ self.influence if is_sparse(self.mass) else self.momentum(self.influence)
        return GroundLoad(as_float64(inertia), ground, self.load)

    def _rayleigh_matrix(self, damping: Rayleigh) -> Matrix:
        """The matrix C of Rayleigh damping, from the tangent at u = 0."""
        checks.check_rayleigh(damping, self.title)
        mass = 1.0 if self.mass is None else self.mass

        def matrix(u):
            return rayleigh_matrix(damping, mass, self.at_time(0.0).stiffness_at(u), u.size)

        # a matrix-free C holds functions, which a compiled function cannot return
        compute = matrix if self.tangent == "matrix_free" else jax.jit(matrix)
        return checks.finite_damping(compute(jnp.zeros_like(self.u0)), self.title)

    def untitled(self) -> "Problem":
        """The same problem without its title: problems that differ in the title alone share a compiled program."""
        return self._changed("title", "untitled")

    def with_safeguard(self) -> "Problem":
        """The same problem, whose Newton iterations start again with a safeguard if they fail."""
        return self._changed("safeguarded", True)

    def stiffness_at(self, u: VectorLike) -> Matrix:
        """K + ∂p/∂u at displacement u and without velocity."""
        if self.linear:
            return self.stiffness
        _, varying = tangent.force_and_tangent(self._without_velocity(), u, self.tangent)
        return varying if self.stiffness is None else add(varying, self.stiffness, n=np.size(u))

    def __repr__(self) -> str:
        force = f"p({', '.join(('u', 'u̇', 'history')[: self.arguments] + ('t',) * self.takes_time)})"
        present = {
            "ü" if self.mass is None else "M ü": True,
            "C u̇": self.damping is not None,
            "K u": self.stiffness is not None,
            force: not self.linear,
        }
        equation = " + ".join(term for term, is_present in present.items() if is_present)
        start = f"{np.size(self.u0)} unknowns" if np.ndim(self.u0) else f"u(0) = {self.u0}, u̇(0) = {self.v0}"
        return f"{self.title}: {equation} = {0 if self.load is None else 'f(t)'}\n{start}"

    @property
    def linear(self) -> bool:
        """Whether the internal force is K u alone."""
        return self.force is None

    @property
    def damped(self) -> bool:
        """Whether forces depend on the velocity."""
        return self.damping is not None or self.takes_velocity

    @property
    def takes_time(self) -> bool:
        """Whether the force takes the time."""
        return self.place_of_time is not None

    @property
    def dissipative(self) -> bool:
        """Whether the internal force takes a velocity, a history or the time, so that it may dissipate."""
        return self.arguments > 1 or self.takes_time

    @property
    def has_kinks(self) -> bool:
        """Whether the slope of the force may jump, also where a force with a history turns."""
        return self.kinked or self.history is not None

    @property
    def conservative(self) -> bool:
        """Whether the energy is constant: there is no damping, no load, and the force takes the displacement alone."""
        return self.damping is None and self.load is None and not self.dissipative

    def _changed(self, name: str, value: Any) -> "Problem":
        """A copy of the problem with another value of one field; the copy is not checked."""
        copy = object.__new__(type(self))
        for field in fields(self):
            if hasattr(self, field.name):  # a field is missing while the problem is made
                object.__setattr__(copy, field.name, getattr(self, field.name))
        object.__setattr__(copy, name, value)
        return copy

    def at(self, state: Any) -> "Problem":
        """The problem with the committed history of a state; a problem without a history is returned unchanged."""
        return self if self.history is None else self.remembering(state.history)

    def at_rest(self) -> "Problem":
        """The problem with its history at rest, at t = 0."""
        return (self if self.history is None else self.remembering(self._at_rest)).at_time(0.0)

    def at_time(self, t: ScalarLike) -> "Problem":
        """The problem with its force at the time t; a problem whose force does not take the time is unchanged."""
        return self._changed("_time", t) if self.takes_time else self

    def remembering(self, history: Any) -> "Problem":
        """The problem with the given history as the committed one."""
        return self._changed("history", history)

    def committed(self, u: VectorLike, v: VectorLike) -> "Problem":
        """The problem with the history after a motion to u and u̇; a problem without a history is returned unchanged."""
        return self if self.history is None else self.remembering(self._force_and_history(u, v)[1])

    def internal_force(self, u: VectorLike, v: VectorLike) -> Vector:
        """The force K u + p at displacement u and velocity u̇, from the committed history."""
        if self.stiffness is None:
            return self.varying_force(u, v)
        elastic = times(self.stiffness, u)
        if self.linear:
            count(forces=1)
            return elastic
        return elastic + self.varying_force(u, v)

    def static_force(self, u: VectorLike) -> Vector:
        """The force K u + p at displacement u and without velocity, from the committed history."""
        return self.internal_force(u, jnp.zeros_like(u))

    def varying_force(self, u: VectorLike, v: VectorLike) -> Vector:
        """The force p, without K u."""
        return self._force_and_history(u, v)[0]

    def _force_and_history(self, u: VectorLike, v: VectorLike) -> tuple[Vector, Any]:
        """The force p, and the history after a motion to u and u̇; None without a history."""
        return self._from(u, v, self.history) if self.history is not None else (self._from(u, v), None)

    def _from(self, *motion: Any) -> Any:
        """Value of the function of the force."""
        count(forces=1)
        arguments = list(motion[: self.arguments])
        if self.place_of_time is not None:
            if self._time is None:
                raise RuntimeError("the force takes the time, which problem.at_time(t) must state.")
            arguments.insert(self.place_of_time, self._time)
        return self.force(*arguments)

    def momentum(self, v: VectorLike) -> Vector:
        """M u̇."""
        return v if self.mass is None else times(self.mass, v)

    def energy(self, u: VectorLike, v: VectorLike) -> Scalar:
        """Kinetic and potential energy ½ u̇ᵀ M u̇ + ½ uᵀ K u + V, the scalar E of Xie (1996), eqs (4) and (5)."""
        return 0.5 * jnp.vdot(v, self.momentum(v)) + self.stored_energy(u)

    def stored_energy(self, u: VectorLike) -> Scalar:
        """½ uᵀ K u + V at displacement u, with the committed history."""
        if self.potential is None:
            raise ValueError("the energy of a problem needs its potential: give Problem(potential=...).")
        stored = self.potential(u) if self.history is None else self.potential(u, self.history)
        return stored if self.stiffness is None else stored + 0.5 * jnp.vdot(u, times(self.stiffness, u))


def _nothing(u: Vector) -> Vector:
    """Zero, the potential of a linear problem in addition to ½ uᵀ K u."""
    return jnp.zeros((), u.dtype)
