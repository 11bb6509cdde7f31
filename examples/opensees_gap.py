"""Two floors that pound against each other across a gap on moving ground, in OpenSees.

    study assess examples/opensees_gap.py --opensees --duration 4 --schemes average_acceleration hht_alpha bathe \
        --allowed-error 0.1 0.01 --output opensees_gap

The ground moves as a sine. Forces are in kN, lengths in m.
"""

import math

#: Masses of the floors in t, stiffnesses of their storeys in kN/m, dampings in kN s/m, gap in m, and stiffness of the
#: contact in kN/m.
MASSES, STIFFNESSES, DAMPINGS, GAP, CONTACT = (50.0, 30.0), (8.0e3, 2.0e4), (20.0, 20.0), 0.02, 2.0e5


def build(ops):
    """Build the model."""
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.fix(1, 1)
    for floor, (mass, stiffness, damping) in enumerate(zip(MASSES, STIFFNESSES, DAMPINGS, strict=True), start=2):
        ops.node(floor, 0.0)
        ops.mass(floor, mass)
        ops.uniaxialMaterial("Elastic", floor, stiffness, damping)
        ops.element("zeroLength", floor, 1, floor, "-mat", floor, "-dir", 1)
    # the spring of the contact acts once the gap has closed, and never yields
    ops.uniaxialMaterial("ElasticPPGap", 1, CONTACT, -1e9, -GAP)
    ops.element("zeroLength", 1, 2, 3, "-mat", 1, "-dir", 1)
    ops.timeSeries("Trig", 1, 0.0, 100.0, 2 * math.pi / 12.0, "-factor", 3.0)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)


quantities = {
    "first floor": lambda ops: ops.nodeDisp(2, 1),
    "second floor": lambda ops: ops.nodeDisp(3, 1),
}
