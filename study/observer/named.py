"""The observers that have names."""

from study.observer.base import Observer
from study.observer.crossings import Oscillations
from study.observer.diagnostics import Evaluations, LyapunovExponent, MomentumErrors, NewtonIterations
from study.observer.energy import EnergyBalance, EnergyDrift, EnergyError, MaxEnergyError, MeanEnergyError
from study.observer.motion import AbsoluteAcceleration, AbsoluteMotion, InternalForce, Trajectory
from study.observer.peak import Peak
from study.registry import Registry

#: Observers by name.
observers: Registry[Observer] = Registry(
    "observer",
    {
        "trajectory": Trajectory(),
        "energy_error": EnergyError(),
        "max_energy_error": MaxEnergyError(),
        "mean_energy_error": MeanEnergyError(),
        "energy_drift": EnergyDrift(),
        "energy_balance": EnergyBalance(),
        "momentum_errors": MomentumErrors(),
        "peak": Peak(),
        "oscillations": Oscillations(),
        "newton_iterations": NewtonIterations(),
        "effort": Evaluations(),
        "lyapunov_exponent": LyapunovExponent(),
        "absolute_acceleration": AbsoluteAcceleration(),
        "absolute_motion": AbsoluteMotion(),
        "internal_force": InternalForce(),
    },
)
