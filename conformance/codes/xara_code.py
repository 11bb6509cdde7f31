"""xara, a code that descends from OpenSees: ``conform conformance.codes.xara_code:step`` with the package ``xara``.

Its package ``opensees`` has the functions of OpenSees. Its integrators HHT and GeneralizedAlpha take β before γ.
"""

from functools import partial

import opensees.openseespy as ops

from conformance.codes.opensees import INTEGRATORS, OTHERS, run

_ORDER = {"hht": lambda alpha, beta, gamma: ("HHT", 1 + alpha, beta, gamma)}

step, others = partial(run, ops, INTEGRATORS | _ORDER, True), partial(run, ops, OTHERS, True)
