"""MuJoCo, a simulator of rigid bodies: ``conform conformance.codes.mujoco_code:step`` with the package ``mujoco``.

Bodies slide along one axis, and joints have no springs: a force that is applied before each evaluation holds the
load, the springs and the dampers. Its integrator RK4 is the classical Runge-Kutta method. Its integrator Euler is
symplectic Euler.
"""

import mujoco
import numpy as np

_INTEGRATORS = {"rk4": "RK4", "symplectic_euler": "Euler"}


def _model(mass, integrator, dt):
    bodies = "".join(
        f'<body><joint type="slide" axis="1 0 0"/><geom size="1" mass="{m!r}" contype="0" conaffinity="0"/></body>'
        for m in mass
    )
    option = f'<option gravity="0 0 0" timestep="{dt!r}" integrator="{integrator}"><flag contact="disable"/></option>'
    return mujoco.MjModel.from_xml_string(f"<mujoco>{option}<worldbody>{bodies}</worldbody></mujoco>")


def step(problem, scheme, dt, steps):
    """Displacement and velocity at the start and after every step, each (steps + 1, n)."""
    mass = np.diag(problem.mass)
    if scheme["family"] not in _INTEGRATORS or problem.text["form"] == "elastoplastic":
        raise NotImplementedError("it has no such integrator, or no spring with a memory")
    if np.any(problem.mass != np.diag(mass)):
        raise NotImplementedError("its masses are not coupled here")
    if scheme["family"] == "symplectic_euler" and problem.damping.any():
        raise NotImplementedError("a force of the damping would act on the velocity at the start of the step")
    sizes = np.broadcast_to(dt, steps).tolist()
    model = _model(mass.tolist(), _INTEGRATORS[scheme["family"]], sizes[0])
    data = mujoco.MjData(model)

    def force(model, data):
        data.qfrc_passive[:] += problem.load(data.time) - problem.damping @ data.qvel - problem.force(data.qpos.copy())

    mujoco.set_mjcb_passive(force)
    try:
        data.qpos[:], data.qvel[:] = problem.u0, problem.v0
        rows = [(problem.u0, problem.v0)]
        for size in sizes:
            model.opt.timestep = size
            mujoco.mj_step(model, data)
            rows.append((data.qpos.copy(), data.qvel.copy()))
    finally:
        mujoco.set_mjcb_passive(None)
    return [np.array(values) for values in zip(*rows, strict=True)]
