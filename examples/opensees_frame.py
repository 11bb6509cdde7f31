"""A portal frame of steel with fibre sections under the record of El Centro, in OpenSees.

    study assess examples/opensees_frame.py --opensees --duration 8 --spacing 0.02 \
        --schemes average_acceleration hht_alpha bathe --allowed-error 0.1 0.01 --output opensees_frame

The columns have a fixed base and carry gravity before the ground moves. Forces are in N, lengths in m.
"""

from pathlib import Path

import study

RECORD = Path(study.__file__).parent / "mechanics" / "records" / "el_centro_1940_ns.at2"

#: Width and height of the frame in m, mass at each joint in kg, and factor of the record.
WIDTH, HEIGHT, MASS, SCALE = 6.0, 3.5, 2.0e4, 1.5


def section(ops, tag, depth, width, web, flange):
    """Define a wide-flange section of steel fibres, with its dimensions in m."""
    ops.section("Fiber", tag)
    half = depth / 2
    ops.patch("rect", 1, 2, 1, half - flange, -width / 2, half, width / 2)
    ops.patch("rect", 1, 2, 1, -half, -width / 2, flange - half, width / 2)
    ops.patch("rect", 1, 8, 1, flange - half, -web / 2, half - flange, web / 2)


def build(ops):
    """Build the model: frame, gravity, damping and ground motion."""
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node, (x, y) in enumerate([(0, 0), (WIDTH, 0), (0, HEIGHT), (WIDTH, HEIGHT)], start=1):
        ops.node(node, x, y)
    for node in (1, 2):
        ops.fix(node, 1, 1, 1)
    for node in (3, 4):
        ops.mass(node, MASS, MASS, MASS * 0.1)
    # steel with a smooth stress-strain curve: modulus 200 GPa, strength 250 MPa, hardening of one percent
    ops.uniaxialMaterial("Steel02", 1, 250e6, 200e9, 0.01, 18.0, 0.925, 0.15)
    section(ops, 1, 0.25, 0.25, 0.010, 0.014)
    section(ops, 2, 0.30, 0.15, 0.008, 0.011)
    ops.geomTransf("PDelta", 1)
    for column in (1, 2):
        ops.beamIntegration("Lobatto", column, column, 5)
    for element, (first, last, kind) in enumerate([(1, 3, 1), (2, 4, 1), (3, 4, 2)], start=1):
        ops.element("forceBeamColumn", element, first, last, 1, kind, "-iter", 30, 1e-14)

    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for node in (3, 4):
        ops.load(node, 0.0, -9.81 * MASS, 0.0)
    ops.system("BandGeneral")
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.test("NormDispIncr", 1e-12, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 0.1)
    ops.analysis("Static")
    ops.analyze(10)
    ops.loadConst("-time", 0.0)

    ops.rayleigh(0.5, 0.0, 0.001, 0.0)
    samples = [0.0, *(9.81 * SCALE * float(word) for word in RECORD.read_text().split("SEC")[1].split())]
    ops.timeSeries("Path", 2, "-dt", 0.02, "-values", *samples)
    ops.pattern("UniformExcitation", 2, 1, "-accel", 2)


quantities = {"drift": lambda ops: ops.nodeDisp(3, 1) / HEIGHT, "moment": lambda ops: ops.eleForce(1, 3)}
