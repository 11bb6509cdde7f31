"""Claims of ours about stability at large steps and over long times."""

from paper.asks import rising, spans
from paper.claims.ledger import Finding, by_name, claim, listed
from paper.tables.outcomes_near_1996 import is_outcome, near_1996, some_near_1996

#: Lyapunov exponent per step above which a map is chaotic; a regular map has less than 0.01 after a thousand steps.
CHAOTIC = 0.05
#: The paper's schemes with numerical damping.
DAMPED = ["newmark_dissipative", "wilson_theta", "houbolt", "hht_alpha"]


@claim(
    "stability",
    "Δt < T/20 is reasonable for average acceleration, at every amplitude and for long.",
    "steps a period that keep the energy within 10 % over the longest runs at all amplitudes, by problem",
    reads=["stability/robustness"],
    asks={"robustness.schemes": ["average_acceleration"], "robustness.periods": rising("robustness.periods")},
)
def a_twentieth_at_every_amplitude(data):
    robustness = data["stability/robustness"]
    needed = robustness.steps_needed.sel(scheme="average_acceleration", level=10).isel(periods=-1)
    steps = by_name(needed)
    good = [name for name, value in steps.items() if value <= 20]
    return Finding(
        f"{listed(steps, '.0f')} (nan: more than {robustness.most_steps.item()})",
        bool(good),
        "" if len(good) == len(steps) else f"only on {', '.join(good) or 'none'}",
    )


@claim(
    "stability",
    "In the double well at Δt = 2.5 average acceleration is chaotic.",
    "Lyapunov exponent of its map, a step, and steps until a perturbation of 1e-10 is of order one",
    reads=["stability/bifurcation"],
    asks={
        "stability.bifurcation.problem": "double_well",
        "stability.bifurcation.scheme": "average_acceleration",
        "stability.bifurcation.dt": spans("stability.bifurcation.dt", 2.5),
    },
)
def chaos_of_average_acceleration(data):
    at = data["stability/bifurcation"].sel(dt=2.5, method="nearest")
    a_step = (at.lyapunov_exponent * at.dt).item()
    return Finding(f"{a_step:.2f}; {at.steps_until_apart.item()}", bool(a_step > CHAOTIC and at.steps_until_apart > 0))


@claim(
    "stability",
    "Where the effective equation of a step has several roots, Newton's choice among them decides.",
    "spread of the displacements that Newton finds from different starts at the step size of the paper, by scheme",
    reads=["stability/roots"],
    asks={"stability.roots.problem": "double_well", "stability.roots.paper_dt": 2.5},
)
def several_roots(data):
    roots = data["stability/roots"]
    spread = (roots.root.max("guess") - roots.root.min("guess")).max("predictor")
    has_several = roots.unique_up_to < roots.paper_dt
    decided = bool(((spread > 1e-6) == has_several).all()) and bool(has_several.any())
    return Finding(listed(by_name(spread), ".1f"), decided)


@claim(
    "stability",
    "Numerical damping keeps the schemes of the paper from chaos.",
    "part of their runs that end chaotic on the maps at amplitudes like those of 1996, in percent",
    reads=["stability/atlas"],
    asks={"atlas.schemes": DAMPED, "atlas.amplitudes": some_near_1996},
)
def damping_against_chaos(data):
    near = near_1996(data["stability/atlas"]).sel(scheme=DAMPED)
    chaotic = is_outcome(near, "chaotic")
    part = by_name(100 * chaotic.mean(["problem", "amplitude", "dt_over_period"]))
    where = [p for p in near.problem.values if chaotic.sel(problem=p).any()]
    return Finding(listed(part, ".1f"), max(part.values()) < 1, f"they are, on {', '.join(where)}" if where else "")
