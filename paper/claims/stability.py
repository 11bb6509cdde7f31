"""Claims about stability at large steps and over long times."""

from paper.claims.ledger import PRACTICE, XIE_EXTENDED, Finding, by_name, claim, most, when
from paper.measures.outcomes import fewest_steps, is_outcome, most_steps, near_1996, some_near_1996
from paper.requirements import rising, spans
from paper.terms import CHAOTIC, DAMPED, FAITHFUL, REASONABLE, ROUND_OFF, RULE
from paper.wording import joined, listed, number

#: Dissipative schemes whose tongues are compared with the tongues of ``FAITHFUL``.
CLOSING = ["hht_alpha", "bathe"]


@claim(
    "stability",
    "Δt < T/20 is reasonable for average acceleration at every amplitude.",
    f"steps per period that keep the energy within {REASONABLE:g} % at all amplitudes of the maps",
    whose=XIE_EXTENDED,
    requires={"atlas.schemes": ["average_acceleration"]},
    atlas="stability/atlas",
)
def a_twentieth_at_every_amplitude(atlas):
    steps = by_name(fewest_steps(atlas, REASONABLE / 100).sel(scheme="average_acceleration"))
    holds, _ = most({name: value <= RULE for name, value in steps.items()})
    good = [name for name, value in steps.items() if value <= RULE]
    reason = when(len(good) < len(steps), f"only on {joined(good, atlas)}")
    return Finding(listed(steps, atlas, ".0f", most_steps(atlas)), holds, reason)


@claim(
    "stability",
    "In the double well at Δt = 2.5 average acceleration is chaotic.",
    "Lyapunov exponent of its map, per step",
    whose=XIE_EXTENDED,
    requires={
        "stability.bifurcation.problem": "double_well",
        "stability.bifurcation.scheme": "average_acceleration",
        "stability.bifurcation.dt": spans(2.5),
    },
    bifurcation="stability/bifurcation",
)
def chaos_of_average_acceleration(bifurcation):
    at = bifurcation.sel(step_size=2.5, method="nearest")
    a_step = (at.lyapunov_exponent * at.step_size).item()
    return Finding(number(a_step, ".2f"), a_step > CHAOTIC and at.steps_until_apart.item() > 0)


@claim(
    "stability",
    "If the effective equation of a step has several roots, the result depends on the start of Newton's iteration.",
    "spread of the displacements that Newton finds from different starts at the step size of the paper, by scheme",
    requires={"stability.roots.problem": "double_well", "stability.roots.paper_step_size": 2.5},
    roots="stability/roots",
)
def several_roots(roots):
    spread = (roots.root.max("guess") - roots.root.min("guess")).max("predictor")
    has_several = roots.unique_up_to < roots.paper_step_size
    decided = bool(((spread > ROUND_OFF) == has_several).all()) and bool(has_several.any())
    return Finding(listed(by_name(spread), roots), decided)


@claim(
    "stability",
    "Numerical damping keeps the schemes of the paper from chaos.",
    "share of their runs that end chaotic on the maps at amplitudes like those of 1996, in percent",
    whose=PRACTICE,
    requires={"atlas.schemes": DAMPED, "atlas.amplitudes": some_near_1996},
    atlas="stability/atlas",
)
def damping_against_chaos(atlas):
    near = near_1996(atlas).sel(scheme=DAMPED)
    chaotic = is_outcome(near, "chaotic")
    part = by_name(100 * chaotic.mean(["problem", "amplitude", "step_size_over_period"]))
    where = [p for p in near.problem.values if chaotic.sel(problem=p).any()]
    reason = when(where, f"some end chaotic, on {joined(where, atlas)}")
    return Finding(f"{listed(part, atlas)}, of {chaotic.isel(scheme=0).size} runs each", not where, reason)


@claim(
    "stability",
    "Numerical dissipation closes narrow tongues of Mathieu's equation, which schemes without it keep open.",
    "largest ε at which the highest tongue is closed at the coarsest step",
    requires={"mathieu.schemes": [*FAITHFUL, *CLOSING], "mathieu.steps_per_period": rising},
)
def dissipation_closes_tongues(mathieu):
    edge = mathieu.edge.isel(tongue=-1, steps_per_period=0).sel(scheme=[*FAITHFUL, *CLOSING])
    widest = edge.epsilon.where(edge.isnull().any("side")).max("epsilon")
    closed = widest.scheme.values[widest.notnull().values].tolist()
    reason = when(set(closed) != set(CLOSING), f"it is closed with {joined(closed, mathieu)} only")
    return Finding(listed(by_name(widest), mathieu, ".2f", "none"), not reason, reason)
