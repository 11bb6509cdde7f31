"""The terms of a problem, or of several stages of a problem, that a balance of forces needs."""

from collections.abc import Callable
from typing import Protocol

from study.algebra.arrays import Matrix
from study.mechanics.tangent import FormOfTangent


class System(Protocol):
    """The terms of a problem that a balance needs: p, K, M, C and the form of ∂p/∂u."""

    @property
    def internal_force(self) -> Callable:
        """The force K u + p as a function of u and u̇."""

    @property
    def varying_force(self) -> Callable:
        """The force p as a function of u and u̇."""

    @property
    def linear(self) -> bool:
        """Whether the internal force is K u alone, without p."""

    @property
    def stiffness(self) -> Matrix:
        """K, zero if None."""

    @property
    def takes_velocity(self) -> bool:
        """Whether p depends on u̇."""

    @property
    def kinked(self) -> bool:
        """Whether the slope of p may jump."""

    @property
    def safeguarded(self) -> bool:
        """Whether an iteration that fails starts again with a safeguard."""

    @property
    def mass(self) -> Matrix:
        """M, the identity if None."""

    @property
    def massless(self) -> bool:
        """Whether M is singular."""

    @property
    def damping(self) -> Matrix:
        """C, zero if None."""

    @property
    def tangent(self) -> FormOfTangent:
        """Form of ∂p/∂u as in :func:`study.mechanics.tangent.force_and_tangent`."""
