"""Input files of Abaqus and code_aster for linear structures: masses on a line, with springs and dashpots in between.

The files follow the manuals of both codes, but neither code has run them. The comment at the head of a file describes
the table ``NAME.csv`` that holds the motion.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple


class Chain(NamedTuple):
    """A linear structure with a mass on every unknown; node 0 is fixed.

    Attributes
    ----------
    springs
        Nodes, stiffness and damping of every pair of nodes with a spring or a dashpot.
    forces
        Amplitude of the harmonic load of every unknown.
    ground
        Times and accelerations of the ground; empty if the ground is at rest.
    """

    mass: list[float]
    springs: list[tuple[int, int, float, float]]
    u0: list[float]
    v0: list[float]
    forces: list[float]
    frequency: float
    phase: float
    ground: list[tuple[float, float]]

    @property
    def pull(self) -> list[float]:
        """K u₀, one force for every unknown."""
        u, forces = [0.0, *self.u0], [0.0] * (len(self.u0) + 1)
        for i, j, k, _ in self.springs:
            forces[i] += k * (u[i] - u[j])
            forces[j] += k * (u[j] - u[i])
        return forces[1:]


def _numbers(texts: Sequence[str]) -> list[float]:
    return [float(text) for text in texts]


def _pairs(problem: Mapping[str, Any]) -> Iterator[tuple[int, int, float, float]]:
    matrices = [[*map(_numbers, matrix)] for matrix in (problem["parameters"]["stiffness"], problem["damping"])]
    for i in range(len(problem["u0"])):
        for j in range(-1, i):
            # the sum of a row is the stiffness or damping to node 0, because the springs to other nodes cancel
            k, c = (sum(m[i]) if j < 0 else -m[i][j] for m in matrices)
            if k or c:
                yield j + 1, i + 1, k, c


def chain(problem: Mapping[str, Any]) -> Chain | None:
    """The problem of a case as masses, springs and dashpots; None if it is not linear or masses are coupled."""
    mass = [*map(_numbers, problem["mass"])]
    if problem["form"] != "linear" or any(x and i != j for i, row in enumerate(mass) for j, x in enumerate(row)):
        return None
    load = problem.get("load", {"amplitude": ["0"] * len(mass), "frequency": "1", "phase": "0"})
    ground = problem.get("ground", {"dt": "0", "acceleration": []})
    return Chain(
        [mass[i][i] for i in range(len(mass))],
        list(_pairs(problem)),
        _numbers(problem["u0"]),
        _numbers(problem["v0"]),
        _numbers(load["amplitude"]),
        float(load["frequency"]),
        float(load["phase"]),
        [(i * float(ground["dt"]), a) for i, a in enumerate(_numbers(ground["acceleration"]))],
    )


def _operator(scheme: Mapping[str, str]) -> str | None:
    """Parameters of ``*DYNAMIC`` for Newmark's method and HHT-α; None for any other scheme."""
    if scheme["family"] not in ("newmark", "hht"):
        return None
    return f"ALPHA={scheme.get('alpha', '0')}, BETA={float(scheme['beta'])!r}, GAMMA={float(scheme['gamma'])!r}"


def _amplitude(model: Chain, i: int) -> str:
    """Lines ``*AMPLITUDE`` for the force on an unknown: the load less K u₀, because U in Abaqus is u − u₀."""
    name, pull = f"*AMPLITUDE, NAME=FORCE{i + 1}", model.pull[i]
    if model.ground:
        return "\n".join([name, *(f"{t!r}, {-model.mass[i] * a - pull!r}" for t, a in model.ground)])
    cosine, sine = (model.forces[i] * part(model.phase) for part in (math.cos, math.sin))
    return f"{name}, DEFINITION=PERIODIC\n1, {model.frequency!r}, 0.0, {-pull!r}\n{cosine!r}, {sine!r}"


def abaqus(case: Mapping[str, Any]) -> str | None:
    """Input of a case for Abaqus/Standard; None for an unsupported problem or scheme."""
    model, operator = chain(case["problem"]), _operator(case["scheme"])
    if model is None or operator is None:
        return None
    dt, steps, unknowns = float(case["run"]["dt"]), case["run"]["steps"], range(1, len(model.mass) + 1)
    lines = [
        f"** {case['name']}: {case['title']}",
        "** Run in double precision with full output. U is u - u0, as it starts at zero, and the forces hold -K u0.",
        f"** {case['name']}.csv: t, u1 = U1 + u0, v1 = V1, a1 = A1 of every node in turn, with a row for t = 0.",
        "*HEADING",
        case["name"],
        "*NODE, NSET=ALL",
        *(f"{node + 1}, {float(node)!r}, 0.0, 0.0" for node in (0, *unknowns)),
        "*NSET, NSET=FREE, GENERATE",
        f"2, {len(model.mass) + 1}, 1",
    ]
    for node, mass in zip(unknowns, model.mass, strict=True):
        lines += [f"*ELEMENT, TYPE=MASS, ELSET=M{node}", f"{node}, {node + 1}", f"*MASS, ELSET=M{node}", repr(mass)]
    number = len(model.mass)
    for i, j, *values in model.springs:
        for kind, value in zip(("SPRING", "DASHPOT"), values, strict=True):
            if not value:
                continue
            number, place = number + 1, f"{kind[0]}{i}{j}"
            lines += [f"*ELEMENT, TYPE={kind}2, ELSET={place}", f"{number}, {i + 1}, {j + 1}"]
            lines += [f"*{kind}, ELSET={place}", "1, 1", repr(value)]
    lines += [_amplitude(model, i) for i in range(len(model.mass))]
    lines += ["*BOUNDARY", "1, 1, 3", "FREE, 2, 3", "*INITIAL CONDITIONS, TYPE=VELOCITY"]
    lines += [f"{node + 1}, 1, {v!r}" for node, v in zip(unknowns, model.v0, strict=True)]
    lines += [f"*STEP, NLGEOM=NO, INC={steps}", f"*DYNAMIC, TIME INTEGRATOR=HHT-TF, {operator}, DIRECT"]
    lines += [f"{dt!r}, {dt * steps!r}"]
    for node in unknowns:
        lines += [f"*CLOAD, AMPLITUDE=FORCE{node}", f"{node + 1}, 1, 1.0"]
    lines += ["*OUTPUT, HISTORY, FREQUENCY=1", "*NODE OUTPUT, NSET=FREE", "U1, V1, A1", "*END STEP"]
    return "\n".join(lines) + "\n"


def _schema(scheme: Mapping[str, str]) -> str | None:
    """Arguments of code_aster's ``SCHEMA_TEMPS`` for a scheme; None for an unsupported scheme."""
    family, numbers = scheme["family"], {n: float(x) for n, x in scheme.items() if n not in ("family", "start")}
    if family == "newmark":
        return f'SCHEMA="NEWMARK", FORMULATION="DEPLACEMENT", BETA={numbers["beta"]!r}, GAMMA={numbers["gamma"]!r}'
    # code_aster derives β and γ of HHT-α from α
    if family == "hht" and math.isclose(numbers["beta"], (1 - numbers["alpha"]) ** 2 / 4):
        return f'SCHEMA="HHT", FORMULATION="DEPLACEMENT", ALPHA={numbers["alpha"]!r}, MODI_EQUI="OUI"'
    if family == "central_difference":
        return 'SCHEMA="DIFF_CENT", FORMULATION="ACCELERATION", STOP_CFL="NON"'
    if family == "tchamwa_wielgosz":
        return f'SCHEMA="TCHAMWA", FORMULATION="ACCELERATION", PHI={numbers["phi"]!r}, STOP_CFL="NON"'
    return None


def mesh(case: Mapping[str, Any]) -> str | None:
    """Mesh of a case in code_aster's format; None for an unsupported problem or scheme.

    Node N0 is fixed, M1 is the mass on node N1, and S01 is the spring between N0 and N1.
    """
    model = chain(case["problem"])
    if model is None or _schema(case["scheme"]) is None:
        return None
    n = len(model.mass)
    lines = ["COOR_3D", *(f"N{i} {float(i)!r} 0.0 0.0" for i in range(n + 1)), "FINSF"]
    lines += ["POI1", *(f"M{i} N{i}" for i in range(1, n + 1)), "FINSF"]
    lines += ["SEG2", *(f"S{i}{j} N{i} N{j}" for i, j, _, _ in model.springs), "FINSF"]
    for i in range(n + 1):
        lines += [f"GROUP_NO NOM=N{i}", f"N{i}", "FINSF"]
    for name in [*(f"M{i}" for i in range(1, n + 1)), *(f"S{i}{j}" for i, j, _, _ in model.springs)]:
        lines += [f"GROUP_MA NOM={name}", name, "FINSF"]
    return "\n".join([*lines, "FIN"]) + "\n"


def code_aster(case: Mapping[str, Any]) -> str | None:
    """Commands of a case for code_aster, in Python; None for an unsupported problem or scheme."""
    model, schema = chain(case["problem"]), _schema(case["scheme"])
    if model is None or schema is None:
        return None
    dt, steps, free = float(case["run"]["dt"]), case["run"]["steps"], range(1, len(model.mass) + 1)
    discrete = [f'_F(GROUP_MA="M{i}", CARA="M_T_D_N", VALE={m!r})' for i, m in zip(free, model.mass, strict=True)]
    for i, j, k, c in model.springs:
        for name, value in (("K_T_D_L", k), ("A_T_D_L", c)):
            discrete.append(f'_F(GROUP_MA="S{i}{j}", CARA="{name}", VALE=({value!r}, 0.0, 0.0))')
    if model.ground:
        samples = ", ".join(f"{t!r}, {a!r}" for t, a in model.ground)
        forces = [-m for m in model.mass]
        along = f'DEFI_FONCTION(NOM_PARA="INST", PROL_DROITE="CONSTANT", VALE=({samples}))'
    else:
        forces = model.forces
        along = f'FORMULE(NOM_PARA="INST", VALE="cos({model.frequency!r} * INST - {model.phase!r})")'
    fields = {
        name: ", ".join(f'_F(GROUP_NO="N{i}", NOM_CMP="DX", VALE={x!r})' for i, x in zip(free, values, strict=True))
        for name, values in (("u0", model.u0), ("v0", model.v0))
    }
    nodal = ", ".join(f'_F(GROUP_NO="N{i}", FX={f!r})' for i, f in zip(free, forces, strict=True))
    # scale of an absolute tolerance; a relative tolerance refers to the external forces, which are zero in free motion
    largest = max(map(abs, [*model.pull, *model.forces, *(m * a for m in model.mass for _, a in model.ground)]))
    columns = {
        f"{name}{i}": f'RECU_FONCTION(RESULTAT=motion, NOM_CHAM="{field}", NOM_CMP="DX", GROUP_NO="N{i}")'
        for name, field in (("u", "DEPL"), ("v", "VITE"), ("a", "ACCE"))
        for i in free
    }
    read = "\n".join(f"{name} = {command}" for name, command in columns.items())
    across = ", ".join(f'_F(GROUP_NO="N{i}", DY=0.0, DZ=0.0)' for i in free)
    rest = '_F(TOUT="OUI", NOM_CMP=("DX", "DY", "DZ"), VALE=(0.0, 0.0, 0.0))'
    return f"""# {case["name"]}: {case["title"]}
# The mesh {case["name"]}.mail is unit 20. The table {case["name"]}.csv appears in the folder of the run.
DEBUT(PAR_LOT="NON")
mesh = LIRE_MAILLAGE(FORMAT="ASTER", UNITE=20)
model = AFFE_MODELE(MAILLAGE=mesh, AFFE=_F(TOUT="OUI", PHENOMENE="MECANIQUE", MODELISATION="DIS_T"))
springs = AFFE_CARA_ELEM(MODELE=model, DISCRET=({", ".join(discrete)},))
steel = DEFI_MATERIAU(ELAS=_F(E=1.0, NU=0.0))
field = AFFE_MATERIAU(MAILLAGE=mesh, AFFE=_F(TOUT="OUI", MATER=steel))
fixed = AFFE_CHAR_MECA(MODELE=model, DDL_IMPO=(_F(GROUP_NO="N0", DX=0.0, DY=0.0, DZ=0.0), {across}))
load = AFFE_CHAR_MECA(MODELE=model, FORCE_NODALE=({nodal},))
along = {along}
u0 = CREA_CHAMP(OPERATION="AFFE", TYPE_CHAM="NOEU_DEPL_R", MODELE=model, AFFE=({rest}, {fields["u0"]}))
v0 = CREA_CHAMP(OPERATION="AFFE", TYPE_CHAM="NOEU_DEPL_R", MODELE=model, AFFE=({rest}, {fields["v0"]}))
times = DEFI_LIST_REEL(DEBUT=0.0, INTERVALLE=_F(JUSQU_A={dt * steps!r}, NOMBRE={steps}))
motion = DYNA_NON_LINE(
    MODELE=model, CHAM_MATER=field, CARA_ELEM=springs, ETAT_INIT=_F(DEPL=u0, VITE=v0),
    EXCIT=(_F(CHARGE=fixed), _F(CHARGE=load, FONC_MULT=along)), COMPORTEMENT=_F(RELATION="ELAS"),
    INCREMENT=_F(LIST_INST=times), NEWTON=_F(MATRICE="TANGENTE", REAC_ITER=1),
    CONVERGENCE=_F(RESI_GLOB_MAXI={1e-9 * largest!r}, ITER_GLOB_MAXI=50), SCHEMA_TEMPS=_F({schema}))
{read}
histories = [function.Valeurs() for function in ({", ".join(columns)},)]
with open("{case["name"]}.csv", "w") as table:
    print("t,{",".join(columns)}", file=table)
    for row in zip(histories[0][0], *(history[1] for history in histories)):
        print(*row, sep=",", file=table)
FIN()
"""
