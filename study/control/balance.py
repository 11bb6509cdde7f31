"""An estimator with the acceleration that balances the forces, in place of the one that a scheme carries."""

from study.control.estimators import ZienkiewiczXie
from study.mechanics.balance import acceleration


class ZienkiewiczXieOfBalance(ZienkiewiczXie):
    r"""The estimate of Zienkiewicz and Xie with ü of the equation of motion in place of the one that a scheme carries.

    .. math::

        e = u_1 - u_0 - \Delta t\,\dot u_0 - \Delta t^2 (\tfrac13 a_0 + \tfrac16 a_1), \quad
        M a = f(t) - C \dot u - p(u)

    The estimate does not use the ``acceleration_offset`` of an α-method. It takes one additional force per step.

    References
    ----------
    O. C. Zienkiewicz, Y. M. Xie, A simple error estimator and adaptive time stepping procedure for dynamic analysis,
    Earthquake Eng. Struct. Dyn. 20(9), 1991, 871-887.
    """

    title = "Zienkiewicz-Xie, balance"

    def ends(self, scheme, problem, before, old, new, t, dt):
        return before, acceleration(problem, t + dt, new.u, new.v), 0.0
