"""Equation (1): M ü + C u̇ + p(u) = f(t), with u(0) and u̇(0)."""

import reprlib
from collections.abc import Callable
from dataclasses import fields
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.matrices import Banded, MatrixFree, add, banded, product, times
from study.problem import tangent


def _real(name: str, value):
    """Float64 for numbers and arrays; what JAX is tracing, and what is no array, stays as it is."""
    if value is None or isinstance(value, jax.core.Tracer | Rayleigh | Banded | MatrixFree):
        return value
    try:
        numbers = np.asarray(value)
    except ValueError:  # rows of different lengths
        numbers = np.asarray(None)
    if numbers.dtype.kind not in "fiu":
        raise ValueError(f"{name} takes real numbers and arrays of them, not {reprlib.repr(value)}.")
    return numbers.astype(np.float64)


class Rayleigh(NamedTuple):
    """Damping C = a M + b K with the stiffness K = ∂p/∂u of the undeformed structure.

    A mode of the circular frequency ω has the damping ratio ξ = (a/ω + b ω)/2.
    """

    a: float
    b: float


class StrainEnergy(eqx.Module):
    """A potential V(u) = Σ w(ε(u)) of strains ε, from which a conserving scheme can tell what a rigid motion leaves.

    Parameters
    ----------
    strains
        ε(u), of shape (m,): functions of u of second degree at most, such as elongations of springs in a row or
        squared lengths of bars.
    density
        w(ε), element by element: the energy of each strain, (m,).
    """

    strains: Callable
    density: Callable

    def __call__(self, u):
        """V(u)."""
        return jnp.sum(self.density(self.strains(u)))


def _gradient(potential, u):
    return jax.grad(potential)(u)


class Problem(eqx.Module):
    """A second-order initial value problem M ü + C u̇ + p(u) = f(t), Xie (1996), eq. (1).

    Everything but a force (or a potential), ``u0`` and ``v0`` is optional, and what is absent costs nothing: no such
    term is in the compiled loop.

    Parameters
    ----------
    force
        Internal force p(u), written with ``jax.numpy``; returns the shape of ``u``. Where there is none, it is the
        gradient of the potential.
    u0, v0
        Displacement and velocity at t = 0, both of shape () or (n,); at rest where no velocity is given.
    potential
        V(u) with p = ∂V/∂u, a scalar, or a :class:`StrainEnergy`. Needed only where an energy is asked for.
    mass
        M: a number, a diagonal (n,) or a symmetric matrix (n, n). Absent, it is the identity. A massless degree of
        freedom makes it singular, which schemes take that are implicit and unconditionally stable; ``u0`` and ``v0``
        should leave it in balance, or schemes that do not damp make it oscillate from step to step.
    damping
        C: a number, a diagonal, a matrix (symmetric where the tangent is matrix-free) or :class:`Rayleigh`. Absent, it
        is zero.
    load
        f(t), of the shape of ``u``.
    tangent
        Structure of ∂p/∂u with several unknowns: ``diagonal``, ``tridiagonal``, ``dense``, ``matrix_free`` (for
        symmetric tangents), or the half bandwidth. Absent, it is found for up to a thousand unknowns from the tangent
        at two displacements; a force that couples other unknowns later, as in contact, needs it declared. Bands are
        eliminated without pivoting between rows that are far apart, as a saddle point would need: that is ``dense``.
        The joints of a mesh should be numbered along its short side: a narrow band takes a small part of the time.
    positions
        Where masses stand at u = 0, of shape (points, directions), with u its change point by point. Needed only where
        a momentum is asked for.
    title
        What figures and datasets call it.

    Raises
    ------
    ValueError, TypeError
        If the shapes do not fit each other, a number is not finite, a matrix is not symmetric, the force is not the
        gradient of the potential, the declared structure is not that of the force, or a function is none.
    """

    force: Callable = None  # type: ignore[assignment]
    u0: Any = None
    v0: Any = None
    potential: Callable | None = eqx.field(default=None, kw_only=True)
    mass: Any = eqx.field(default=None, kw_only=True)
    damping: Any = eqx.field(default=None, kw_only=True)
    load: Callable | None = eqx.field(default=None, kw_only=True)
    tangent: str | int | None = eqx.field(default=None, kw_only=True, static=True)
    positions: Any = eqx.field(default=None, kw_only=True)
    title: str = eqx.field(default="unnamed problem", kw_only=True, static=True)
    #: Whether M is singular.
    massless: bool = eqx.field(init=False, static=True)

    @jax.enable_x64(True)  # what is checked here is told from round-off; a run may be of single precision
    def __post_init__(self):
        for name in ("u0", "v0", "mass", "damping", "positions"):
            setattr(self, name, _real(name, getattr(self, name)))
        if self.v0 is None and self.u0 is not None:
            self.v0 = np.zeros(np.shape(self.u0))
        self._check_shapes()
        derived = self.force is None and self.potential is not None
        if derived:
            self.force = eqx.Partial(_gradient, self.potential)
        self._check_functions()
        if not derived and self.potential is not None and not isinstance(self.u0, jax.core.Tracer):
            self._check_slope()
        self.massless = self._check_mass()
        if not isinstance(self.u0, jax.core.Tracer):
            self._settle_forms()

    def _check_shapes(self):
        shape = np.shape(self.u0)
        if self.u0 is None or len(shape) > 1 or shape == (0,):
            got = "nothing" if self.u0 is None else f"an array of shape {shape}"
            raise ValueError(f"u0 must be a number or a vector (n,), not {got}.")
        if np.shape(self.v0) != shape:
            raise ValueError(f"v0 must have the shape of u0, {shape}, not {np.shape(self.v0)}.")
        for name in ("mass", "damping"):
            value = getattr(self, name)
            if isinstance(value, np.ndarray | jax.Array) and value.shape not in {(), shape, shape * 2}:
                raise ValueError(
                    f"{name} must be a number, a diagonal or a matrix for u0 of shape {shape}; got {value.shape}."
                )
        if self.positions is not None and (
            np.ndim(self.positions) != 2
            or np.shape(self.positions)[1] > 3
            or np.size(self.positions) != np.size(self.u0)
        ):
            raise ValueError(
                f"positions must be of shape (points, directions), at most three directions, with one number for each "
                f"of u0's {np.size(self.u0)}, not {np.shape(self.positions)}."
            )
        for name in ("u0", "v0", "mass", "damping", "positions"):
            value = getattr(self, name)
            if isinstance(value, np.ndarray) and not np.isfinite(value).all():
                raise ValueError(f"{name} must be finite, not {value}.")

    def _check_functions(self):
        shape = np.shape(self.u0)
        for name, value, expected in (
            ("force", self.u0, shape),
            ("load", 0.0, shape),
            ("potential", self.u0, ()),
        ):
            function = getattr(self, name)
            if not callable(function) and (function is not None or name == "force"):
                raise TypeError(f"{name} must be a function, not {function!r}.")
            if function is None:
                continue
            try:
                received = jax.eval_shape(function, value)
            except Exception as error:  # whatever the function raises, it is told whose it is
                reason = f"{type(error).__name__}: {(str(error).splitlines() or [''])[0]}"
                raise ValueError(
                    f"{name} of '{self.title}' must be written with jax.numpy for u0's shape: {reason}"
                ) from error
            if not hasattr(received, "shape") or received.shape != expected:
                got = getattr(received, "shape", type(received).__name__)
                raise ValueError(f"{name} must return the shape {expected}, not {got}.")
            if received.dtype != float:
                raise ValueError(f"{name} must return float64, not {received.dtype}.")
        if isinstance(self.potential, StrainEnergy):
            strains = jax.eval_shape(self.potential.strains, self.u0).shape
            energies = jax.eval_shape(lambda u: self.potential.density(self.potential.strains(u)), self.u0).shape
            if len(strains) != 1 or energies != strains:
                raise ValueError(
                    f"a StrainEnergy needs strains of shape (m,) and a density of the same, not {strains} and "
                    f"{energies}."
                )

    def _check_slope(self):
        """Refuse a force that is not the slope of the potential, in one direction near the start."""
        scale = max(np.abs(self.u0).max(), 1.0)
        way, away = np.random.default_rng(0).uniform(0.5, 1.5, (2, *np.shape(self.u0)))
        u, h = self.u0 + 0.05 * scale * away, 1e-5 * scale
        ends = [float(self.potential(u + h * way)), float(self.potential(u - h * way))]
        slope, expected = (ends[0] - ends[1]) / (2 * h), float(np.vdot(way, self.force(u)))
        round_off = 1e-14 * max(map(abs, ends)) / h
        # where one of them is not finite a run will tell
        if abs(slope - expected) > 1e-5 * max(abs(slope), abs(expected)) + round_off:
            raise ValueError(
                f"the force of '{self.title}' is not the gradient of its potential: along a direction near u0 it is "
                f"{expected:g}, and the slope of the potential {slope:g}."
            )

    def _check_mass(self) -> bool:
        """Whether the mass is singular."""
        for name, value in (("mass", self.mass), ("damping", self.damping)):
            # damping may be gyroscopic, but for conjugate gradients
            if isinstance(value, np.ndarray) and value.ndim == 2 and (name == "mass" or self.tangent == "matrix_free"):
                difference = np.abs(value - value.T).max()
                if difference > 1e-12 * np.abs(value).max():
                    raise ValueError(f"{name} must be symmetric; it differs from its transpose by {difference:g}.")
        if not isinstance(self.mass, np.ndarray):
            return False
        diagonal = np.diagonal(self.mass) if self.mass.ndim == 2 else self.mass
        full = self.mass.ndim == 2 and np.count_nonzero(self.mass) > np.count_nonzero(diagonal)
        values = np.linalg.eigvalsh(self.mass) if full else diagonal
        # what is zero of a matrix is so to round-off
        least, zero = values.min(), np.abs(values).max() * (1e-14 * len(values) if full else 0.0)
        if least < -zero:
            raise ValueError(f"mass must not be negative; its smallest value is {least:g}.")
        if np.abs(values).max() == 0:
            raise ValueError("mass must not be zero in all: the problem would not move in time.")
        return bool(least <= zero)

    def _settle_forms(self):
        """The tangent's structure, and mass and damping in the least form that holds them."""
        n, declared = np.size(self.u0), self.tangent
        if np.ndim(self.u0):
            self.tangent = (
                tangent.found(self.force, self.u0, self.massless, self.title)
                if declared is None
                else tangent.checked(self.force, self.u0, declared, self.title)
            )
        elif declared is not None:
            raise ValueError(f"tangent={declared!r} of '{self.title}': one unknown has no structure; leave it out.")
        for name in ("mass", "damping"):
            value = getattr(self, name)
            if isinstance(self.tangent, int) and isinstance(value, np.ndarray) and value.ndim == 2:
                setattr(self, name, banded(value, self.tangent))
        if isinstance(self.damping, Rayleigh):
            if not all(np.ndim(c) == 0 and np.asarray(c).dtype.kind in "fiu" and np.isfinite(c) for c in self.damping):
                raise ValueError(f"{self.damping} of '{self.title}': a and b must be finite numbers.")
            undeformed = jax.jit(lambda u: tangent.force_and_tangent(self.force, u, self.tangent))
            _, stiffness = undeformed(np.zeros_like(self.u0))
            mass = 1.0 if self.mass is None else self.mass
            a, b = self.damping
            self.damping = add(product(float(a), mass, n), product(float(b), stiffness, n), n=n)
            if not all(np.isfinite(part).all() for part in jax.tree.leaves(eqx.filter(self.damping, eqx.is_array))):
                raise ValueError(
                    f"the stiffness of '{self.title}' at u = 0, of which Rayleigh takes its damping, is not finite."
                )

    def untitled(self) -> "Problem":
        """The same problem without its title, so that problems that differ in it alone share a compiled program."""
        copy = object.__new__(type(self))
        for field in fields(self):
            object.__setattr__(copy, field.name, getattr(self, field.name))
        object.__setattr__(copy, "title", "untitled")
        return copy

    def momentum(self, v):
        """M u̇."""
        return v if self.mass is None else times(self.mass, v)

    def energy(self, u, v):
        """Kinetic and potential energy ½ u̇ᵀ M u̇ + V(u), the scalar E of Xie (1996), eqs (4) and (5)."""
        if self.potential is None:
            raise ValueError(f"the energy of '{self.title}' needs its potential: give Problem(potential=...).")
        return 0.5 * jnp.vdot(v, self.momentum(v)) + self.potential(u)
