"""The estimators and controllers that have names."""

from study.control.balance import ZienkiewiczXieOfBalance
from study.control.codes import (
    ApparentFrequency,
    HalfIncrement,
    HalfStepResidual,
    Iterations,
    Nastran,
    Proportional,
)
from study.control.controllers import Controller, DeadBand, Filtered, Integral, ProportionalIntegral
from study.control.estimators import EmbeddedPair, Estimator, StepDoubling, ThreePoint, ZienkiewiczXie
from study.registry import Registry

#: Estimators by name.
estimators: Registry[Estimator] = Registry(
    "estimator",
    {
        "zienkiewicz_xie": ZienkiewiczXie(),
        "zienkiewicz_xie_balance": ZienkiewiczXieOfBalance(),
        "three_point": ThreePoint(),
        "half_step_residual": HalfStepResidual(),
        "apparent_frequency": ApparentFrequency(),
        "iterations": Iterations(),
        "step_doubling": StepDoubling(),
        "embedded_pair": EmbeddedPair(),
    },
)

#: Controllers by name, except ``Reversible`` and ``Prescribed``, which need arguments.
controllers: Registry[Controller] = Registry(
    "controller",
    {
        "integral": Integral(),
        "pi": ProportionalIntegral(),
        "h211b": Filtered(),
        "dead_band": DeadBand(),
        "half_increment": HalfIncrement(),
        "nastran": Nastran(),
        "proportional": Proportional(),
    },
)
