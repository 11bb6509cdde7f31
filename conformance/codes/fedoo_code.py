"""fedoo, a code of finite elements: ``conform conformance.codes.fedoo_code:step`` with the package ``fedoo``.

A square of side 1 with E = k and ν = 0 is a spring of stiffness k, and α of Rayleigh's damping is c/m. An implicit
analysis of fedoo starts with zero velocity and acceleration; both are set here.
"""

import fedoo as fd
import numpy as np


def _integrator(scheme):
    """Integrator of a scheme; None if fedoo does not have the scheme."""
    numbers = {name: float(value) for name, value in scheme.items() if name not in ("family", "start")}
    match scheme["family"]:
        case "newmark":
            return fd.time.Newmark(**numbers)
        case "hht":
            return fd.time.GeneralizedAlpha(alpha_f=-numbers.pop("alpha"), **numbers)
        case "generalized_alpha":
            return fd.time.GeneralizedAlpha(**numbers)
        case "central_difference":
            return fd.time.CentralDifference()
    return None


def _problem(integrator, mass, damping, stiffness, dt):
    """Problem of one spring, its assembly, and its two free nodes."""
    fd.ModelingSpace("2Dplane")
    mesh = fd.mesh.rectangle_mesh(2, 2, 0, 1, 0, 1, elm_type="quad4")
    law = fd.constitutivelaw.ElasticIsotrop(stiffness, 0.0)
    # the free nodes have half of the lumped mass of the square, or a third of the consistent mass
    law.set_density((2 if integrator.is_explicit else 3) * mass)
    form = fd.weakform.StressEquilibrium(law).set_dissipation(alpha=damping / mass)
    assembly = fd.Assembly.create(form, mesh)
    if integrator.is_explicit:
        problem = fd.problem.ExplicitDynamic(assembly, dt, integrator)
    else:
        problem = fd.problem.NonLinear(assembly)
        problem.set_time_integrator(fd.time.SECOND_ORDER, integrator)
        problem.set_nr_criterion("Force", tol=1e-12)
    fixed, free = (np.flatnonzero(mesh.nodes[:, 0] == x) for x in (0, 1))
    problem.bc.add("Dirichlet", fixed, "Disp", 0)
    problem.bc.add("Dirichlet", free, "DispY", 0)
    return problem, assembly, free


def step(problem, scheme, dt, steps):
    """Displacement, velocity and acceleration at the start and after every step, each (steps + 1, 1)."""
    integrator = _integrator(scheme)
    if integrator is None or problem.text["form"] != "linear" or len(problem.u0) > 1 or np.ndim(dt):
        raise NotImplementedError("it has no such integrator, or is run with one linear spring and equal steps")
    parts = problem.mass, problem.damping, problem.tangent(problem.u0), problem.u0, problem.v0
    mass, damping, stiffness, u, v = (part.item() for part in parts)
    a = (problem.load(0.0).item() - damping * v - stiffness * u) / mass
    model, assembly, free = _problem(integrator, mass, damping, stiffness, dt)
    rows, end, is_free = [[u, v, a]], dt * steps, np.isin(np.arange(4), free)

    # each free node has half of the load, and `part` is a fraction of the duration
    def load(part):
        return problem.load(part * end).item()

    def read(state):
        if integrator.is_explicit:
            speeds = state.get_velocity("DispX"), state.get_acceleration("DispX")
        else:
            speeds = assembly.sv["Velocity"][0], assembly.sv["Acceleration"][0]
        rows.append([motion[free[0]] for motion in (state.get_disp("DispX"), *speeds)])

    model.bc.add("Neumann", free, "DispX", 0.5, start_value=0, time_func=load)
    if integrator.is_explicit:
        model.set_initial_displacement("DispX", u * is_free)
        model.set_initial_velocity("DispX", v * is_free)
        model.set_initial_acceleration("DispX", a * is_free)
        model.solve_history(end, callback=read)
    else:
        model.set_dof("DispX", u * is_free)
        model.initialize()
        assembly.sv["Velocity"][0], assembly.sv["Acceleration"][0] = v * is_free, a * is_free
        model.nlsolve(dt, False, end, print_info=0, interval_output=1, save_at_exact_time=False, callback=read)
    return [np.array(rows)[:, [i]] for i in range(3)]
