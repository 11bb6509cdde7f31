"""Splitting methods that begin and end with a kick, so that consecutive steps share a force: Blanes and Moan's."""

from itertools import accumulate
from typing import ClassVar

import equinox as eqx

from study.algebra.arrays import VectorLike
from study.mechanics.balance import acceleration_within
from study.mechanics.state import Effort, Motion
from study.scheme.base import as_tuple
from study.scheme.splitting import Alternating, mirrored


class KickDriftKick(Alternating):
    r"""Kicks k₀, ..., k_s and drifts d₁, ..., d_s in turn, beginning and ending with a kick.

    .. math::

        \dot u &\leftarrow \dot u + k_0 \Delta t\,\ddot u, \quad\text{then for } i = 1, \dots, s \\
        u &\leftarrow u + d_i \Delta t\,\dot u \\
        M \ddot u + C (\dot u + h_i \ddot u) + p(u) &= f(t_i), \quad h_i = \tfrac12 k_i \Delta t,
            \quad h_s = k_s \Delta t \\
        \dot u &\leftarrow \dot u + k_i \Delta t\,\ddot u

    at the time t_i = t₀ + (d₁ + ... + d_i) Δt. The last force of a step is the first force of the next step. Symplectic
    without damping. k = (½, ½), d = (1) is velocity Verlet. The method SRKN6b of Blanes and Moan has six drifts, and is
    of order four and stable for ωΔt ≤ 3.163. SRKN6b is derived for ü that does not depend on u̇, and is of second order
    with damping. Carries u, u̇ and ü; s forces per step. The history of a force is committed at u₁; the forces of all
    kicks in a step start from the history at u₀.

    Parameters
    ----------
    kicks, drifts
        k and d; each sums to one, and k has one more number than d.
    order_without_damping
        Order of accuracy without damping.
    stability_limit
        Largest ωΔt at which the method is stable without damping, if known.

    Raises
    ------
    ValueError
        If the kicks or the drifts do not add up to one, if there is not one kick more than drifts, or if the order is
        invalid.

    References
    ----------
    S. Blanes, P. C. Moan, Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nyström methods, J. Comput.
    Appl. Math. 142(2), 2002, 313-330.
    """

    kicks: tuple[float, ...] = eqx.field(static=True, converter=as_tuple)
    drifts: tuple[float, ...] = eqx.field(static=True, converter=as_tuple)
    order_without_damping: int = eqx.field(static=True)
    stability_limit: float | None = eqx.field(default=None, static=True)
    title: str = eqx.field(default="Kick, drift, kick", static=True)

    source: ClassVar[str] = "Blanes and Moan (2002)"
    doi: ClassVar[str] = "10.1016/S0377-0427(01)00492-7"
    force_at_end = True

    def __check_init__(self):
        if len(self.kicks) != len(self.drifts) + 1:
            raise ValueError(
                f"KickDriftKick needs one kick more than drifts, not {len(self.kicks)} for {len(self.drifts)}."
            )

    def increment(self, problem, state, t, dt):
        u, v, a = state
        first, *rest = self.kicks
        du: VectorLike = 0.0
        dv: VectorLike = first * dt * a
        # the last balance takes the velocity after the kick, from which the next step starts
        parts = [0.5] * (len(rest) - 1) + [1.0]
        effort = Effort()
        for node, drift, kick, part in zip(accumulate(self.drifts), self.drifts, rest, parts, strict=True):
            h = kick * dt
            du = du + drift * dt * (v + dv)
            a, kicked = acceleration_within(problem, t + node * dt, u + du, v + dv, part * h, guess=a)
            dv, effort = dv + h * a, effort.then(kicked)
        return Motion(du, dv, a), effort


_kicks = (0.0829844064174052, 0.396309801498368, -0.0390563049223486)
_drift, _next = 0.245298957184271, 0.604872665711080
blanes_moan4 = KickDriftKick(
    kicks=mirrored(*_kicks),
    drifts=(_drift, _next, *(0.5 - _drift - _next,) * 2, _next, _drift),
    order_without_damping=4,
    stability_limit=3.1634651,
    title="Blanes-Moan, order 4",
)
